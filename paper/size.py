"""How large each room is: `python -m paper.size [JUNIT.XML]`, or `make size`.

Prints lines and numeric constants by room, the longest functions, and of a report of pytest the slowest tests.
"""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd

ROOMS = ("paper", "shapes", "tests")
"""The folders beside the package; of the package every folder is a room."""
LONGEST = 10
"""Functions, and tests, that are listed."""


def files() -> Iterator[tuple[str, Path]]:
    """Every file of Python in this folder with the name of its room."""
    for top in ("avobench", *ROOMS):
        for path in sorted(Path(top).rglob("*.py")):
            yield top if top in ROOMS else "/".join(path.parts[: 2 if len(path.parts) > 2 else 1]), path


def constants(tree: ast.Module) -> int:
    """How many numbers, or tuples of numbers, a module gives a name."""
    values = [node.value for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign) and node.value]
    return sum(_numeric(value) for value in values)


def _numeric(value: ast.expr) -> bool:
    if isinstance(value, ast.Tuple | ast.List):
        return bool(value.elts) and all(map(_numeric, value.elts))
    if isinstance(value, ast.UnaryOp | ast.BinOp):  # such as -1 and 10**6
        return all(_numeric(part) for part in ast.iter_child_nodes(value) if isinstance(part, ast.expr))
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


def functions(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """The length in lines and the name of every function."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.end_lineno - node.lineno + 1, node.name


def slowest(report: Path) -> pd.DataFrame:
    """The tests of a junit report that took longest, with their seconds."""
    cases = ElementTree.parse(report).iter("testcase")
    rows = [(float(case.get("time", 0)), f"{case.get('classname')}::{case.get('name')}") for case in cases]
    return pd.DataFrame(sorted(rows, reverse=True)[:LONGEST], columns=["seconds", "test"])


def main(report: Path | None) -> None:
    """Print the tables."""
    rows, longest = [], []
    for room, path in files():
        text = path.read_text()
        tree = ast.parse(text)
        rows.append((room, len(text.splitlines()), constants(tree)))
        longest += [(length, f"{path}:{name}") for length, name in functions(tree)]
    table = pd.DataFrame(rows, columns=["room", "lines", "constants"])
    rooms = table.groupby("room", sort=False).sum().assign(files=table.groupby("room").size())
    rooms.loc["the package"] = rooms[rooms.index.str.startswith("avobench")].sum()
    print(rooms.to_string(), "\n")
    print(pd.DataFrame(sorted(longest, reverse=True)[:LONGEST], columns=["lines", "function"]).to_string(index=False))
    if report is not None:
        print("\n" + slowest(report).to_string(index=False))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if sys.argv[1:] else None)
