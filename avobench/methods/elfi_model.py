"""The parts that the adapters of ELFI share: its import, a client in this process, and a model of the prior."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from avobench.tasks import Box

if TYPE_CHECKING:
    from elfi import ElfiModel


def import_elfi():
    """ELFI. Its dependencies tell Python to ignore every DeprecationWarning when imported; that is undone here.

    ArviZ, which it imports, writes the date to a file of the user's on the first import of a day. Of two processes that
    do so at once one fails, with a file that is gone; by then the other one has written it.
    """
    with warnings.catch_warnings():
        with suppress(FileNotFoundError):
            import arviz  # noqa: F401
        import elfi
    return elfi


@contextmanager
def own_client(elfi) -> Iterator[None]:
    """Let ELFI evaluate in this process with a new client, and put its global one back afterwards."""
    previous = elfi.get_client()
    elfi.set_client("native")
    try:
        yield
    finally:
        elfi.set_client(previous)


def prior_model(elfi, box: Box) -> tuple["ElfiModel", dict[str, tuple[float, float]]]:
    """A model, never ELFI's current default one, with a uniform prior of theta (p,), and the bounds of each parameter.

    ELFI sorts parameters by name: zero-padded numbers keep their order.
    """
    model = elfi.ElfiModel()
    bounds = {f"theta_{i:03d}": ends for i, ends in enumerate(zip(box.low, box.high, strict=True))}
    for name, low, width in zip(bounds, box.low, box.width, strict=True):
        elfi.Prior("uniform", low, width, model=model, name=name)
    return model, bounds
