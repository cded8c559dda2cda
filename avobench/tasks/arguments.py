"""The arguments of the functions that `import avobench` offers, held against the types that their signatures state."""

import inspect
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.tasks.contract import Box, Task
from avobench.tasks.errors import UsageError, if_uneven, shown
from avobench.tasks.prior import Distributed, Distribution, Ends, Law

WORDS = {
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    str: "a text",
    NoneType: "None",
    Path: "a path",
    Mapping: "a mapping of names",
    Callable: "a function",
    tuple: "a pair of numbers",
    Distribution: "a distribution",
    Task: "a task, such as avobench.task makes of a function",
}
"""How the types of arguments are called in messages."""
ARRAY = frozenset(get_args(ArrayLike))
"""The types that NumPy makes an array of."""

P = ParamSpec("P")
R = TypeVar("R")


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """A function of which an argument of another type than its signature states is a UsageError of one line.

    Whole numbers may be NumPy's, or floats such as 2e4. What an array or a pair of numbers holds is looked at by the
    function itself, which knows what it is for.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def called(*arguments: P.args, **options: P.kwargs) -> R:
        hints = get_type_hints(function)
        for name, value in signature.bind(*arguments, **options).arguments.items():
            kind = signature.parameters[name].kind
            if kind is inspect.Parameter.VAR_KEYWORD or name not in hints or _fits(value, hints[name]):
                continue
            wanted, what = _said(hints[name]), f"{name} of avobench.{function.__name__}"
            raise UsageError(f"{what} must be {wanted}, got {shown(value)}")
        return function(*arguments, **options)

    return called


def _said(hint: Any) -> str:
    origin, inner = get_origin(hint) or hint, get_args(hint)
    if origin in (Union, UnionType):
        arrays = ["an array of one dimension or more"] if set(inner) >= ARRAY else []
        return " or ".join(dict.fromkeys(arrays + [_said(each) for each in inner if not arrays or each not in ARRAY]))
    if origin in (Sequence, list):
        return f"a list, each {_said(inner[0])}"
    if origin in WORDS:
        return WORDS[origin]
    if inspect.isclass(origin) and not getattr(origin, "_is_protocol", False):
        return f"{'an' if origin.__name__[0] in 'AEIOU' else 'a'} {origin.__name__}"
    return "an array"


def numbers(what: str, values: ArrayLike, *, infinite: bool = False) -> NDArray:
    """An array of real numbers, finite unless `infinite`. Raises UsageError, which names `what`, for others."""
    array = reals(what, values)
    if np.isnan(array).any() or not (infinite or np.isfinite(array).all()):
        raise UsageError(f"{what} hold NaN{' or infinite' * (not infinite)} values: mend or drop them")
    return array


def reals(what: str, values: ArrayLike) -> NDArray:
    """An array of real numbers, which may be NaN. Raises UsageError, which names `what`, for others, as in a column."""
    if isinstance(values, pd.DataFrame):  # each column has a type of its own
        columns = [reals(f"column {name} of {what}", column) for name, column in values.infer_objects().items()]
        return np.column_stack(columns or [np.empty((len(values), 0))])
    if np.ma.is_masked(values):
        raise UsageError(f"{what} hold masked values: drop these, or fill them")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        hint = if_uneven(values) or f", got {shown(values)}"
        raise UsageError(f"{what} must be an array of numbers, all rows of one length{hint}") from error
    if array.dtype.kind not in "biuf":
        raise UsageError(f"{what} must be real numbers, got {array.dtype}{if_uneven(array.ravel())}")
    return array


def distinct(what: str, names: Iterable[object]) -> None:
    """Raise UsageError, which says `what` they are of, where two names are the same."""
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise UsageError(f"two {what} have the name {twice[0]}: give each a name of its own")


def box_of(prior: Mapping[str, Ends], integers: Sequence[str] = ()) -> Box:
    """The box of the ends of each parameter, or of its distribution, of whole numbers for `integers`.

    Raises UsageError for what are neither two numbers, the lower one first, nor a distribution of one number.
    """
    laws: list[Law | None] = []
    for name, given in prior.items():
        if isinstance(given, Distribution):
            laws.append(Law.of(name, given, name in integers))
            continue
        laws.append(None)
        try:
            Box(*((end,) for end in given))
        except (TypeError, ValueError) as error:
            raise UsageError(
                f"the prior of {name} must be two numbers, low < high, between which it is uniform, or a distribution "
                f"of one number such as scipy.stats.norm(0, 1), got {shown(given)}"
            ) from error
    if not prior:
        return Box((), ())
    both = zip(prior.values(), laws, strict=True)
    ends = zip(*(given if law is None else law.ends for given, law in both), strict=True)
    return Distributed(*ends, tuple(laws)) if any(laws) else Box(*ends)


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is of a type, or may be: what cannot be told from the type alone is."""
    origin, inner = get_origin(hint) or hint, get_args(hint)
    if origin is Any:
        return True
    if origin in (Union, UnionType):
        return any(_fits(value, one) for one in inner)
    if isinstance(value, np.ndarray) and value.ndim == 0:  # one number, and nothing to go through
        return origin in (bool, int, float) and _fits(value.item(), hint)
    if origin is Literal:
        return isinstance(value, tuple(map(type, inner)))
    if origin is type:
        return isinstance(value, type) and issubclass(value, inner)
    if origin in (None, NoneType):
        return value is None
    if origin is bool:
        return isinstance(value, bool | np.bool_)
    if origin is int:
        whole = isinstance(value, Integral) or (isinstance(value, float) and value.is_integer())
        return whole and not isinstance(value, bool)
    if origin is float:
        return isinstance(value, Real) and not isinstance(value, bool)
    if origin in (Sequence, list):
        listed = isinstance(value, Sequence | np.ndarray) and not isinstance(value, str | bytes)
        return listed and all(_fits(one, inner[0]) for one in value)
    if origin is Mapping:
        return isinstance(value, Mapping) and all(_fits(k, inner[0]) and _fits(v, inner[1]) for k, v in value.items())
    if origin is Callable:
        return callable(value)
    if origin is tuple or not inspect.isclass(origin) or getattr(origin, "_is_protocol", False):
        return True
    return isinstance(value, origin)
