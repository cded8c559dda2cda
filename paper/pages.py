"""Pages whose Python is run and whose output stands below it: `python -m paper.pages docs/tutorial.md`.

The fenced `python` blocks of a page are run in order, in one namespace and from the folder of the page. What a block
prints is written into the fenced `text` block that directly follows it, which is made or removed as needed. The code
itself saves its pictures, with a path such as figures/tutorial_1.png. A block that directly follows the comment
`<!-- not run -->` is left alone.
"""

import contextlib
import io
import re
import sys
from pathlib import Path

import matplotlib

from avobench.bench.store.files import write_atomically

BLOCK = re.compile(r"^```python\n(.*?)^```$(\n\n?```text\n.*?^```$)?", re.MULTILINE | re.DOTALL)
NOT_RUN = "<!-- not run -->\n"


def executed(page: str, folder: Path) -> str:
    """The text of a page with what its code prints now. The code runs from a folder, and what it raises is raised."""
    names = {"__name__": "page"}

    def run(block: re.Match[str]) -> str:
        if page[: block.start()].endswith(NOT_RUN):
            return block[0]
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(block[1], names)
        lines = [line.rstrip() for line in printed.getvalue().strip("\n").splitlines()]
        output = "\n".join(["", "", "```text", *lines, "```"]) if lines else ""
        return f"```python\n{block[1]}```{output}"

    with contextlib.chdir(folder):
        return BLOCK.sub(run, page)


if __name__ == "__main__":
    matplotlib.use("Agg")  # draws without a window
    for name in sys.argv[1:]:
        path = Path(name)
        write_atomically(path, executed(path.read_text(), path.parent).encode())
