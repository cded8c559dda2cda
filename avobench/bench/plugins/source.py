"""The source of a user's class or function, with the parts of its module that it uses, and the values that it holds.

Only those top-level statements count that bind a name which it uses, directly or not. The hash of the whole file would
take 50 lines in place of 160, but then every edit of a script's plots or budget would run all cells again. Other
modules of the user's are not followed, except for base classes.

No source tells the values in objects, partials and functions that were made inside others. They are read each time, as
a user may change them in between.
"""

import ast
import functools
import hashlib
import inspect
import os
import re
import symtable
import sys
import textwrap
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import joblib
import numpy as np

from avobench.bench.plugins import user_files

EVERYTHING = "*"
"""The name that `from module import *` binds: nobody can tell which it does, so the statement counts always."""


CODE = '"""Code that a model names which avobench saved beside it."""'
"""The first line of a module that is made of another one."""


PLAIN = (bool, int, float, complex, str, bytes, type(None))
"""The types of values that their text tells."""
WRAPPED = "__wrapped__"
"""The attribute by which what `functools.cache` or a compiler made of a function has that function."""


class Statement(NamedTuple):
    """A statement at the top of a module."""

    text: str
    binds: frozenset[str]
    uses: frozenset[str]


def is_ours(thing: Any) -> bool:
    """Tell whether a class or function belongs to this project, to Python, or to what is compiled into it."""
    module = thing.__module__
    top = module.partition(".")[0]
    ours = top == "avobench" or (top in sys.stdlib_module_names and top != "__main__")
    return ours and not module.startswith(user_files.PREFIX)


def source_hash(things: list[Any]) -> str | None:
    """SHA-256 of texts, and of the source of those classes, functions and objects that are not ours; None if all are.

    With the source of a function or an object count the values that it holds.

    Raises OSError or TypeError where a source cannot be read, as of what was typed at a prompt.
    """
    theirs = list(dict.fromkeys(source for thing in things for source in _sources(thing)))
    return hashlib.sha256("\0".join(theirs).encode()).hexdigest() if theirs else None


def as_module(module: str, names: set[str]) -> str | None:
    """The statements of a module that bind these names at its top, and what they use, as the text of a module.

    None where they cannot be read, or do not bind all names. In a notebook the module is what was run so far.
    """
    home = sys.modules.get(module)
    try:
        source = inspect.getsource(home)
    except (OSError, TypeError):
        source = "\n".join(filter(_is_python, getattr(home, "In", ())))
    statements = _statements(source)
    if not names <= frozenset().union(*(each.binds for each in statements)):
        return None
    future = [each.text for each in statements if each.text.startswith("from __future__ ")]
    chosen = [text for text in _closure(statements, names) if text not in future]
    folder = os.path.dirname(os.path.abspath(getattr(home, "__file__", None) or "x"))
    path = f"import sys\n\nsys.path.append({folder!r})  # where other modules of its own are"
    return "\n\n".join(text.rstrip() for text in [CODE, *future, path, *chosen]) + "\n"


def _is_python(cell: str) -> bool:
    """Tell whether the cell of a notebook is nothing but Python: a line that begins with % is not."""
    try:
        ast.parse(cell)
    except SyntaxError:
        return False
    return True


def _sources(thing: Any, within: tuple[int, ...] = ()) -> Iterator[str]:
    """The texts that tell a thing; `within` has the ids of the values that it is a part of."""
    if isinstance(thing, str):
        yield thing
    elif isinstance(thing, functools.partial):
        yield from _sources(thing.func, within)
        yield fingerprint((thing.args, thing.keywords), within)
    elif inspect.ismethod(thing):
        yield from _sources(thing.__func__, within)
        yield fingerprint(thing.__self__, within)
    elif inspect.isclass(thing):
        bases = [base for base in thing.__mro__ if not is_ours(base)]
        yield from (base.__qualname__ for base in bases[:1])
        for module in dict.fromkeys(base.__module__ for base in bases):
            yield from _used(module, [base for base in bases if base.__module__ == module], within)
        yield from (fingerprint(_attributes(base), within) for base in bases if not _has_a_name(base))
    elif inspect.isfunction(thing):
        if not is_ours(thing):
            yield thing.__qualname__
            yield from _used(thing.__module__, [thing], within)
        if not _has_a_name(thing) and (values := _values(thing)):
            yield fingerprint(values, within)
    elif WRAPPED in getattr(thing, "__dict__", ()):
        yield from _sources(thing.__wrapped__, within)
    else:
        yield from _sources(type(thing), within)
        if _is_installed(type(thing)):
            yield fingerprint(thing, within)
        elif state := _state(thing):
            yield fingerprint(state, within)


def fingerprint(value: Any, within: tuple[int, ...] = ()) -> str:
    """A text that differs where values do, and is the same in every process.

    Code is told by its source, and an object by its class and what it holds, unless they are an installed package's.
    All else is told by its hash; what has none, such as a lock, an open file or a compiled simulator, by its type.
    """
    if type(value) in PLAIN:
        return repr(value)
    if id(value) in within:
        return "itself"
    within = (*within, id(value))
    tell, code = functools.partial(fingerprint, within=within), inspect.isclass(value) or inspect.isfunction(value)
    texts = [type(value).__qualname__]
    if isinstance(value, functools.partial):
        texts += map(tell, (value.func, value.args, value.keywords))
    elif inspect.ismethod(value):
        texts += map(tell, (value.__func__, value.__self__))
    elif not code and WRAPPED in getattr(value, "__dict__", ()):
        texts.append(tell(value.__wrapped__))
    elif not _is_installed(value if code else type(value)):
        texts += [value.__qualname__ if code else "", *_sources(value, within)]
    elif isinstance(value, dict):
        texts += sorted(f"{tell(key)}: {tell(each)}" for key, each in value.items())
    elif isinstance(value, set | frozenset):
        texts += sorted(map(tell, value))
    elif isinstance(value, list | tuple):
        texts += map(tell, value)
    else:
        with suppress(Exception):  # what cannot be pickled may raise anything
            texts.append(joblib.hash(value))
    return joblib.hash(texts)


def _is_installed(thing: Any) -> bool:
    """Tell whether a class or function belongs to Python or to an installed package, so that its name tells it."""
    module = thing.__module__ or "builtins"
    if module.partition(".")[0] == "avobench":  # with the modules of a user's files
        return False
    file = getattr(sys.modules.get(module), "__file__", None) or ""
    return is_ours(thing) or not {"site-packages", "dist-packages"}.isdisjoint(Path(file).parts)


def _has_a_name(thing: Any) -> bool:
    """Tell whether its module has a class or function by its name, so that the source of the module tells it."""
    value = sys.modules.get(thing.__module__)
    for name in thing.__qualname__.split("."):
        value = getattr(value, name, None)
    return value is thing


def _values(function: FunctionType) -> dict[str, Any]:
    """The values that a function keeps, by their names: of the functions around it, defaults and attributes."""
    values = dict(vars(function))
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        with suppress(ValueError):  # it has no value yet
            values[name] = cell.cell_contents
    defaults = {"defaults": function.__defaults__, "keyword defaults": function.__kwdefaults__}
    return values | {name: value for name, value in defaults.items() if value}


def _attributes(cls: type) -> dict[str, Any]:
    """The attributes of a class, and the values that its methods keep."""
    return {
        name: _values(value) if inspect.isfunction(value) else value
        for name, value in vars(cls).items()
        if inspect.isfunction(value) or not name.startswith("__")
    }


def _state(thing: Any) -> list[Any]:
    """What an object holds: what pickle would keep of it, but for cached properties, and its elements."""
    try:
        state = thing.__getstate__()
    except Exception:  # a user's class may refuse to be pickled
        state = vars(thing)
    if isinstance(state, dict):
        attribute = functools.partial(inspect.getattr_static, type(thing))
        state = {
            k: value for k, value in state.items() if not isinstance(attribute(k, None), functools.cached_property)
        }
    held = [state] if state else []
    if isinstance(thing, np.ndarray):
        held.append(np.asarray(thing))
    return held + [kind(thing) for kind in (dict, list, tuple, set, frozenset, int, float) if isinstance(thing, kind)]


def _used(module: str, things: list[Any], within: tuple[int, ...]) -> list[str]:
    """The statements of a module that these classes or functions of it consist of and use, in their order."""
    try:
        statements = _statements(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):  # what was typed in a notebook has no file, nor has what is compiled
        return [text for thing in things for text in _of_values(thing, set(), within)]
    wanted = {thing.__qualname__.partition(".")[0] for thing in things}
    if any(name.startswith("<") for name in wanted):  # a lambda, alone or in a comprehension
        return [*map(inspect.getsource, things), *_closure(statements, _names(_text(things[0])))]
    return _closure(statements, wanted)


def _closure(statements: tuple[Statement, ...], wanted: set[str] | frozenset[str]) -> list[str]:
    """The statements that bind one of these names, or one that such a statement uses."""
    wanted, chosen, more = {*wanted, EVERYTHING}, set(), True
    while more:
        more = [k for k, each in enumerate(statements) if k not in chosen and each.binds & wanted]
        chosen.update(more)
        wanted = wanted.union(*(statements[k].uses for k in more))
    return [statements[k].text for k in sorted(chosen)]


@functools.lru_cache(maxsize=64)
def _statements(source: str) -> tuple[Statement, ...]:
    """The statements at the top of a module; also those of a script under `if __name__ == "__main__":`."""
    lines, statements = source.splitlines(keepends=True), []
    nodes = list(ast.parse(source).body)
    while nodes:
        node = nodes.pop(0)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "__name__ == '__main__'" and node.body[0].col_offset:
            nodes = [*node.body, *nodes]
            continue
        first = min([node.lineno, *(each.lineno for each in getattr(node, "decorator_list", []))])
        text = textwrap.dedent("".join(lines[first - 1 : node.end_lineno]))
        statements.append(Statement(text, frozenset(_bound(node)), _names(text)))
    return tuple(statements)


def _bound(node: ast.AST) -> Iterator[str]:
    """Names that a statement gives a value, or changes the value of: `x = 1`, `def x`, `x[0] = 1`, `x.append(1)`."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield node.name
        return
    if isinstance(node, ast.Import | ast.ImportFrom):
        yield from ((alias.asname or alias.name).partition(".")[0] for alias in node.names)
    elif isinstance(node, ast.Name | ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
        yield _root(node)
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and isinstance(node.value.func, ast.Attribute):
        yield _root(node.value)
    for child in ast.iter_child_nodes(node):
        yield from _bound(child)


def _root(node: ast.AST) -> str:
    """The name at the left of a chain of attributes, indices and calls; "" where there is none."""
    while isinstance(node, ast.Attribute | ast.Subscript | ast.Call):
        node = node.func if isinstance(node, ast.Call) else node.value
    return node.id if isinstance(node, ast.Name) else ""


@functools.lru_cache(maxsize=1024)
def _names(text: str) -> frozenset[str]:
    """Names of its module that a text uses."""
    try:
        tables = [symtable.symtable(text, "source", "exec")]
    except SyntaxError:  # the line of a lambda need not be a whole statement
        return frozenset(re.findall(r"[^\W\d]\w*", text))
    names = {symbol.get_name() for symbol in tables[0].get_symbols() if symbol.is_referenced()}
    for table in tables:
        for child in table.get_children():
            tables.append(child)
            # A name that a class both sets and uses, as in `rate = rate`, may be that of the module.
            in_class = child.get_type() == "class"
            names |= {s.get_name() for s in child.get_symbols() if s.is_global() or (in_class and s.is_referenced())}
    return frozenset(names)


def _text(thing: Any) -> str:
    return textwrap.dedent(inspect.getsource(thing))


def _of_values(thing: Any, visited: set[str], within: tuple[int, ...]) -> Iterator[str]:
    """The text of a class or function without a file, and the values in its module of the names that it uses."""
    text, home = _text(thing), vars(sys.modules[thing.__module__])
    yield text
    for name in sorted(_names(text) & home.keys() - visited):
        visited.add(name)
        value = home[name]
        if inspect.isfunction(value) or inspect.isclass(value):
            if value.__module__ == thing.__module__:
                yield from _of_values(value, visited, within)
        elif not inspect.ismodule(value):
            yield f"{name} = {fingerprint(value, within)}"
