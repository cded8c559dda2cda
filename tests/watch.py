"""A view of a sweep that keeps what it is shown."""

from avobench.bench.sweep.runner import View


class Watch(View):
    """The notes, the cells in the order in which they were finished, and the shares of each as it went on."""

    def __init__(self, act=lambda: None):
        """`act` is called after the first cell."""
        self.act, self.notes, self.order, self.shares = act, [], [], {}

    def note(self, line):
        self.notes.append(line)

    def finished(self, sweep, cell, record):
        self.order.append(cell)
        if len(self.order) == 1:
            self.act()

    def tick(self, sweep):
        for id, share in sweep.running.items():
            self.shares.setdefault(id, []).append(share)
