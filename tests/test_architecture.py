"""The rules of the house that a reader relies on, beside the direction of imports, which `make lint` checks."""

import ast
from functools import cache
from pathlib import Path

import avobench

PACKAGE = Path(avobench.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def name(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


def number(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and isinstance(value.value, int | float)


def without_reason(path: Path) -> list[int]:
    """Lines that set several numbers at once, or one of which neither a docstring nor a comment gives the reason."""
    body, source, found = tree(path).body, path.read_text().splitlines(), []
    for statement, following in zip(body, [*body[1:], None], strict=True):
        if not isinstance(statement, ast.Assign):
            continue
        if isinstance(statement.targets[0], ast.Tuple):
            if any(map(number, getattr(statement.value, "elts", []))):
                found.append(statement.lineno)
        elif number(statement.value):
            told = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
            if not (told or "#" in source[statement.lineno - 1]):
                found.append(statement.lineno)
    return found


def test_constants_stand_one_a_line_with_their_reason():
    assert {name(path): lines for path in MODULES if (lines := without_reason(path))} == {}
