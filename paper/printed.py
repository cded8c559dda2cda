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

BLOCK = re.compile(r"(^<!-- printed by: (.+?) -->\n\s*```\n)(.*?)(^```$)", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"(^<!-- (?:code|text) of: (.+?) -->\n```(?:python)?\n)(.*?)(^```$)", re.MULTILINE | re.DOTALL)
OUTPUT = re.compile(r"(^<!-- output of: (.+?) -->\n```\n)(.*?)(^```$)", re.MULTILINE | re.DOTALL)
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


def filled(page: str) -> str:
    """The text of a page, with every block as its command prints it now, or as its file reads."""
    page = FILE.sub(lambda block: block[1] + Path(block[2]).read_text() + block[4], page)
    return BLOCK.sub(lambda block: block[1] + printed(block[2]) + block[4], page)


def with_outputs(page: str) -> str:
    """The text of a page, with every block of an example's output as it prints it now."""
    return OUTPUT.sub(lambda block: block[1] + output(block[2]) + block[4], page)


if __name__ == "__main__":
    for name in sys.argv[1:]:
        page = Path(name)
        write_atomically(page, with_outputs(filled(page.read_text())).encode())
