"""Measured data with hidden effects, and the answers in a file of their own."""

import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from avobench.bench import registry
from avobench.bench.errors import UsageError
from avobench.bench.store import write_atomically
from avobench.diagnosis.effects.base import Effect
from avobench.diagnosis.effects.catalogue import catalogue
from avobench.tasks import Task
from avobench.tasks.base import stable_hash

from .injections import Injection, Place, Simulate, shapes
from .visibility import visibility

KINDS = ("none", "own", "foreign", "two", "withheld")
"""No effect; one in a shape of the catalogue's; one in a shape that is not; two; one that solving must do without."""
SHOWN = (0.1, 50.0)
"""Effects are drawn anew, up to MAX_DRAWS times, until the chi2/ndf that they would at best reach, less 1, lies here:
below nobody could see them, above they are toys. The last draw stays: it may be one that theta absorbs."""
MAX_DRAWS = 6
OWN_RANGE = (0.003, 1.0)
"""Strengths of the catalogue's own shapes are log-uniform between these shares of the way from null to the bound."""
NUM_REFERENCE = 20_000
MANIFEST = {"schema": "avobench-challenge", "version": 1}
SETS = ("own", "foreign")


@dataclass(frozen=True)
class OwnShape:
    """An effect of the catalogue with its parameters fixed; what an `Injection` is for foreign shapes."""

    effect: Effect
    phi: NDArray[np.float64]
    """(q,)"""
    stage: int = 1

    @classmethod
    def draw(cls, effect: Effect, rng: np.random.Generator) -> "OwnShape":
        """In any of its shapes; strength by OWN_RANGE, to either side where there are two, shape uniform."""
        choices = effect.shapes()
        chosen = choices[rng.integers(len(choices))]
        phi = []
        for parameter in chosen.parameters:
            low, high = parameter.low, parameter.high
            if parameter is chosen.parameters[0]:
                bound = rng.choice([end for end in (low, high) if end != parameter.null])
                share = np.exp(rng.uniform(*np.log(OWN_RANGE)))
                phi.append(parameter.null + share * (bound - parameter.null))
            elif parameter.logarithmic:
                phi.append(np.exp(rng.uniform(np.log(low), np.log(high))))
            else:
                phi.append(rng.uniform(low, high))
        return cls(chosen, np.array(phi))

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def shape(self) -> str:
        return self.effect.shape

    @property
    def settings(self) -> dict[str, float]:
        return {parameter.name: float(v) for parameter, v in zip(self.effect.parameters, self.phi, strict=True)}

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return self.effect.apply(simulate, theta, np.tile(self.phi, (len(theta), 1)), rng)


def make(
    spec: str,
    cases: int,
    seed: int,
    out: Path,
    *,
    num_events: int = 50_000,
    kinds: tuple[str, ...] = KINDS,
    progress: Callable[[str], None] = lambda line: None,
) -> None:
    """Write `cases` data sets of the task `spec` to the new folder `out`, the kinds in equal shares and random order.

    `manifest.json` and `data/` are all that solving needs; `answers.json` holds what was hidden. The manifest comes
    last, so that a folder without it is known to be incomplete. Raises UsageError for anything that cannot be met.
    """
    if cases < 1 or num_events < 1 or seed < 0:
        raise UsageError("--cases and --events must be at least 1, --seed at least 0")
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown or not kinds:
        raise UsageError(f"--kinds must be among {', '.join(KINDS)}, got {', '.join(unknown) or 'none'}")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"{out} exists and is not an empty folder")
    task = registry.build("task", spec, {})
    registry.require_packages("task", task)
    (out / "data").mkdir(parents=True, exist_ok=True)
    root = np.random.SeedSequence([stable_hash("challenge", task.name), seed])
    order = np.random.default_rng(root.spawn(1)[0]).permutation([kinds[i % len(kinds)] for i in range(cases)])
    public, answers = [], []
    for number, (kind, child) in enumerate(zip(order, root.spawn(cases), strict=True)):
        x, answer = hide(task, str(kind), num_events, np.random.default_rng(child))
        name = f"{number:04d}"
        file = io.BytesIO()
        np.savez_compressed(file, x=x)
        write_atomically(out / "data" / f"{name}.npz", file.getvalue())
        public.append({"case": name, "effects": answer.pop("allowed")})
        answers.append({"case": name, **answer})
        progress(f"{name}: made")
    write_atomically(out / "answers.json", _json({**MANIFEST, "task": spec, "seed": seed, "cases": answers}))
    write_atomically(
        out / "manifest.json", _json({**MANIFEST, "task": spec, "num_events": num_events, "cases": public})
    )


def hide(task: Task, kind: str, num_events: int, rng: np.random.Generator) -> tuple[NDArray, dict[str, Any]]:
    """One data set of `kind` at a random theta of the prior, and the answer: (num_events, d), what was hidden.

    The answer's `allowed` is the list of effects that solving may use, None for all of the catalogue.
    """
    theta = task.prior.sample(1, rng)[0]
    at = np.tile(theta, (num_events, 1))
    answer = {"kind": kind, "set": None, "theta": theta.tolist(), "effects": [], "allowed": None}
    answer |= {"distance": 0.0, "power": None}
    if kind == "none":
        return task.simulate(at, rng), answer
    source = kind if kind in SETS else str(rng.choice(SETS))
    reference = task.simulate(at[:NUM_REFERENCE], rng)
    for _ in range(MAX_DRAWS):
        hidden = _draw(task, source, 2 if kind == "two" else 1, reference, rng)
        simulate = _chain(task.simulate, [injection for injection, _ in hidden])
        size = num_events if task.event_shape or task.num_features > 1 else 2 * num_events
        seen = visibility(task, simulate(np.tile(theta, (size, 1)), rng), theta, num_events, rng)
        if SHOWN[0] <= seen.distance <= SHOWN[1]:
            break
    answer |= {"set": source, "distance": seen.distance, "power": seen.power}
    answer["effects"] = [
        {"name": injection.name, "feature": feature, "shape": _shape(injection), "settings": injection.settings}
        for injection, feature in hidden
    ]
    if kind == "withheld":
        names = dict.fromkeys(effect.name for effect in catalogue(task))
        answer["allowed"] = [name for name in names if name != hidden[0][0].name]
    return simulate(at, rng), answer


def feature_label(task: Task, feature: int | Literal["all"] | None) -> str | None:
    """As a diagnosis says it: a name, "all", or None where there is nothing to choose from."""
    if not isinstance(feature, int):
        return feature
    return task.feature_names[feature] if task.feature_names else f"x{feature + 1}"


def _draw(
    task: Task, source: str, number: int, reference: NDArray, rng: np.random.Generator
) -> list[tuple[Injection | OwnShape, str | None]]:
    """Injections of different families, each with the label of its feature, in the order in which they act.

    A family is drawn first, among the names that the catalogue and the foreign shapes share, then its place, then its
    shape, so that no family is favoured for having many of them.
    """
    keys = {(effect.name, effect.feature): effect for effect in catalogue(task)}
    foreign: dict[tuple[str, Any], list[type[Injection]]] = {}
    for feature in dict.fromkeys(feature for _, feature in keys):
        for shape in shapes(Place(task, feature, reference)):
            if (shape.name, feature) in keys:
                foreign.setdefault((shape.name, feature), []).append(shape)
    families = list(dict.fromkeys(name for name, _ in foreign))
    if number > len(families):
        raise UsageError(f"there are not enough injections for {task.name} to hide {number} effects")
    drawn = []
    for family in rng.choice(families, number, replace=False):
        features = [feature for name, feature in foreign if name == family]
        feature = features[rng.integers(len(features))]
        if source == "own":
            injection = OwnShape.draw(keys[family, feature], rng)
        else:
            choices = foreign[family, feature]
            injection = choices[rng.integers(len(choices))].draw(Place(task, feature, reference), rng)
        stage = foreign[family, feature][0].stage  # of the family, as the catalogue does not say
        drawn.append((stage, injection, feature_label(task, feature)))
    return [(injection, label) for _, injection, label in sorted(drawn, key=lambda each: each[0])]


def _chain(simulate: Simulate, injections: list[Injection | OwnShape]) -> Simulate:
    """The simulator with each injection acting on what those before it leave."""
    for injection in injections:

        def simulate(theta, rng, inner=simulate, injection=injection):
            return injection.measure(inner, theta, rng)

    return simulate


def _shape(injection: Injection | OwnShape) -> str:
    return injection.shape if isinstance(injection, OwnShape) else type(injection).__name__


def _json(content: dict[str, Any]) -> bytes:
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()
