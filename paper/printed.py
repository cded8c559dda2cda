"""Pages that show what a command prints: `python -m paper.printed README.md docs/performance.md`.

A comment such as `<!-- printed by: avobench status --results results/reference -->` before a fenced block says which
command printed the block; this one runs it again, from the folder of the repository, and writes the block anew.
`<!-- code of: examples/gamma_line.py -->` and `<!-- text of: results/robustness/kills.txt -->` show a file, and
`<!-- output of: examples/gamma_line.py -->` what it prints; the pictures that it saves are those in docs/figures.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from avobench.bench.store.files import write_atomically

BLOCK = re.compile(r"(^<!-- (\w+) (?:by|of): (.+?) -->\n\s*```(?:python)?\n)(.*?)(^```$)", re.MULTILINE | re.DOTALL)
PICTURES = Path("docs/figures")
PROGRAMS = {"avobench": [sys.executable, "-m", "avobench"], "python": [sys.executable]}


def printed(command: str) -> str:
    """What a command that starts with `avobench` or `python` prints, without white space at line ends.

    Raises CalledProcessError if it fails.
    """
    program, *arguments = shlex.split(command)
    done = subprocess.run([*PROGRAMS[program], *arguments], stdout=subprocess.PIPE, text=True, check=True)
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines()) + "\n"


def output(example: str, folder: Path = PICTURES) -> str:
    """What a Python file prints; the pictures that it saves go to the folder. Raises CalledProcessError if it fails."""
    command = [sys.executable, str(Path(example).resolve())]
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}  # as the command has it
    return subprocess.run(command, cwd=folder, env=one_thread, stdout=subprocess.PIPE, text=True, check=True).stdout


STEADY = {"printed": printed, "code": lambda path: Path(path).read_text(), "text": lambda path: Path(path).read_text()}
"""What fills the blocks that are the same on every machine; the numbers of an example's output are not, quite."""


def filled(page: str, ways: dict = STEADY) -> str:
    """The text of a page, with every block of these ways as its command prints it now, or as its file reads."""
    return BLOCK.sub(
        lambda block: block[1] + ways[block[2]](block[3]) + block[5] if block[2] in ways else block[0], page
    )


if __name__ == "__main__":
    for name in sys.argv[1:]:
        page = Path(name)
        write_atomically(page, filled(page.read_text(), {**STEADY, "output": output}).encode())
