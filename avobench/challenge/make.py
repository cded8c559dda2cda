"""A challenge: measured data with hidden effects, and the answers in a file of their own."""

import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from avobench.bench.plugins import registry
from avobench.bench.store.files import write_atomically
from avobench.challenge.hide import hide
from avobench.challenge.shape import Shape
from avobench.tasks.contract import stable_hash
from avobench.tasks.errors import UsageError
from avobench.tasks.meter import Meter, metered

KINDS = ("none", "own", "foreign", "two", "withheld")
"""No effect; one in a shape of the catalogue's; one in a shape that is not; two; one that solving must do without."""
MANIFEST = {"schema": "avobench-challenge", "version": 1}
"""What says that a file is the public part of a challenge, and of which version."""
UNFINISHED = {"data", "answers.json"}
"""A file that only an interrupted `make` leaves. The next `make` begins anew."""


def make(
    spec: str,
    cases: int,
    seed: int,
    out: Path,
    *,
    num_events: int = 50_000,
    kinds: tuple[str, ...] | None = None,
    shapes: Sequence[Shape] = (),
    progress: Callable[[str], None] = lambda line: None,
) -> int:
    """Write `cases` data sets of the task `spec` to the folder `out`, the kinds in equal shares and random order.
    Returns how many events it simulated, with those that say how visible each effect is.

    `manifest.json` and `data/` are all that solving needs; `answers.json` holds what was hidden. The manifest comes
    last. `kinds` are all of KINDS by default, of which `foreign` needs `shapes`. Raises UsageError.
    """
    kinds = tuple(kind for kind in KINDS if shapes or kind != "foreign") if kinds is None else kinds
    if cases < 1 or num_events < 1 or seed < 0:
        raise UsageError("--cases and --events must be at least 1, --seed at least 0")
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown or not kinds:
        raise UsageError(f"--kinds must be among {', '.join(KINDS)}, got {', '.join(unknown) or 'none'}")
    if out.exists() and (not out.is_dir() or {path.name for path in out.iterdir()} - UNFINISHED):
        raise UsageError(f"{out} exists and is not an empty folder")
    if "foreign" in kinds and not shapes:
        raise UsageError("--kinds foreign needs --shapes: the catalogue has only its own shapes")
    task = registry.build("task", spec, {})
    registry.require_packages("task", task)
    task = metered(task, meter := Meter())
    (out / "data").mkdir(parents=True, exist_ok=True)
    root = np.random.SeedSequence([stable_hash("challenge", task.name), seed])
    order = np.random.default_rng(root.spawn(1)[0]).permutation([kinds[i % len(kinds)] for i in range(cases)])
    public, answers = [], []
    for number, (kind, child) in enumerate(zip(order, root.spawn(cases), strict=True)):
        x, answer = hide(task, str(kind), num_events, np.random.default_rng(child), shapes)
        name = f"{number:04d}"
        file = io.BytesIO()
        np.savez_compressed(file, x=x)
        write_atomically(out / "data" / f"{name}.npz", file.getvalue())
        public.append({"case": name, "effects": answer.pop("allowed")})
        answers.append({"case": name, **answer})
        progress(f"{name}: made")
    common = {**MANIFEST, "task": spec, "num_events": num_events}
    write_atomically(out / "answers.json", _json({**common, "seed": seed, "kinds": kinds, "cases": answers}))
    write_atomically(out / "manifest.json", _json({**common, "cases": public}))
    return meter.used


def named_shapes(spec: str) -> list[Shape]:
    """The shapes that `module:NAME` or `file.py:NAME` lists. Raises UsageError where it does not."""
    shapes = registry.imported("shapes", spec)
    if not isinstance(shapes, list | tuple) or not shapes or not all(isinstance(each, Shape) for each in shapes):
        raise UsageError(f"--shapes takes a list of avobench.challenge.shape.Shape, and {spec} is none")
    return list(shapes)


def _json(content: dict[str, Any]) -> bytes:
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()
