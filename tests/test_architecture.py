"""The rules of the house that a reader relies on, beside the direction of imports, which `make lint` checks."""

import ast
from functools import cache
from pathlib import Path

import avobench

PACKAGE = Path(avobench.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
LONGEST_FUNCTION = 60
MOST_PARAMETERS = 14
"""Keyword-only settings of `avobench.run` and `avobench.diagnose`, each with a default; everything else has fewer."""


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@cache
def functions(path: Path) -> list[ast.FunctionDef]:
    return [node for node in ast.walk(tree(path)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]


def name(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


def code_lines(function: ast.FunctionDef) -> int:
    """Lines from its name on, without those of its docstring, where its parameters are explained."""
    first = function.body[0]
    documented = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
    return function.end_lineno - function.lineno + 1 - (first.end_lineno - first.lineno + 1 if documented else 0)


def parameters(function: ast.FunctionDef) -> int:
    a = function.args
    return len([arg for arg in (*a.posonlyargs, *a.args, *a.kwonlyargs) if arg.arg not in ("self", "cls")])


def test_every_module_says_what_it_holds():
    said = {name(path): (ast.get_docstring(tree(path)) or "").splitlines()[:1] for path in MODULES}
    assert [path for path, line in said.items() if not line or not line[0].endswith((".", "?", ":"))] == []


def test_no_function_is_longer_than_a_screen():
    lines = {f"{name(path)}:{f.name}": code_lines(f) for path in MODULES for f in functions(path)}
    assert {where: n for where, n in lines.items() if n > LONGEST_FUNCTION} == {}


def test_no_function_takes_more_than_a_reader_can_hold():
    many = {f"{name(path)}:{f.name}": parameters(f) for path in MODULES for f in functions(path)}
    assert {where: n for where, n in many.items() if n > MOST_PARAMETERS} == {}


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
