"""Pages that show what a command prints: `python -m avobench.reports.printed README.md docs/performance.md`.

A comment such as `<!-- printed by: avobench status --results results/reference -->` before a fenced block says which
command printed the block; this one runs it again, from the folder of the repository, and writes the block anew.
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

from avobench.bench.atomic import write_atomically

BLOCK = re.compile(r"(^<!-- printed by: (.+?) -->\n\s*```\n)(.*?)(^```$)", re.MULTILINE | re.DOTALL)
PROGRAMS = {"avobench": [sys.executable, "-m", "avobench"], "python": [sys.executable]}


def printed(command: str) -> str:
    """What a command that starts with `avobench` or `python` prints, without white space at line ends.

    Raises CalledProcessError if it fails.
    """
    program, *arguments = shlex.split(command)
    done = subprocess.run([*PROGRAMS[program], *arguments], stdout=subprocess.PIPE, text=True, check=True)
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines()) + "\n"


def filled(page: str) -> str:
    """The text of a page, with every block as its command prints it now."""
    return BLOCK.sub(lambda block: block[1] + printed(block[2]) + block[4], page)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        page = Path(name)
        write_atomically(page, filled(page.read_text()).encode())
