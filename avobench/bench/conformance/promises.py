"""The promises that tasks and methods share, and the words of a check that finds one broken."""

import json
import random
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import joblib
import numpy as np

from avobench.bench.plugins import registry
from avobench.methods import Method
from avobench.methods.contract import global_seed
from avobench.tasks import Task

ALPHA = 1e-6
"""Chance that a statistical check blames a sound task or effect: a suite runs hundreds of them."""
Round = list[tuple[str, Callable[[], None]]]
"""Checks by what they promise. Each raises when the promise is broken."""


class BrokenPromise(Exception):
    """A check found a promise broken; the text says which, in a sentence."""


def expect(holds: bool, why: str) -> None:
    """Raise BrokenPromise with `why` unless the promise holds."""
    if not holds:
        raise BrokenPromise(why)


def is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip())


def recordable(kind: str, name: str, subject: Task | Method) -> None:
    """Raise BrokenPromise unless a record can hold what identifies the task or method."""
    for attribute in ("name", "version", "source"):
        expect(is_text(getattr(subject, attribute)), f"{attribute} must be text, got {getattr(subject, attribute)!r}")
    identity = registry.identity(kind, name, subject)
    try:
        json.dumps(identity)
    except TypeError as error:
        raise BrokenPromise(f"a record cannot hold the settings {identity[f'{kind}_settings']}: {error}") from error


@contextmanager
def state_kept(by: str) -> Iterator[None]:
    """Raise BrokenPromise if the block changes what tasks and methods share with the rest of the process."""
    with global_seed(np.random.default_rng(1)):
        before = _global_state()
        yield
        after = _global_state()
    changed = sorted(what for what in before if before[what] != after[what])
    expect(not changed, f"{by} changes {', '.join(changed)}")


def _global_state() -> dict[str, Any]:
    state = {
        "numpy.random": joblib.hash(np.random.get_state()),  # noqa: NPY002 - looked at, not drawn from
        "random": random.getstate(),
        "numpy's floating-point error handling": np.geterr(),
        "warnings.filters": list(warnings.filters),
    }
    if torch := sys.modules.get("torch"):
        state["PyTorch's random state"] = torch.get_rng_state().tolist()
    return state
