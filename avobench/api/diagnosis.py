"""A diagnosis of a user's own events, from Python as from the command line."""

import base64
import html
import io
import json
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.bench.events.checks import Simulate, with_times
from avobench.bench.plugins import registry
from avobench.bench.processes.apart import apart_within
from avobench.bench.store.files import require_folder, write_atomically
from avobench.effects import Effect
from avobench.tasks import Task
from avobench.tasks.errors import UsageError, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from avobench.diagnosis import Diagnosis, Result
    from avobench.diagnosis.report.model_file import ModelFile

TRIED = 50
"""Events on which an effect of the user's is tried before anything is fitted."""


@dataclass(frozen=True, repr=False)
class Diagnosed:
    """What a simulator lacks, by measured events; shows itself in a notebook, and is kept by `save`."""

    result: "Result"
    own: Mapping[str, tuple[str | None, Effect]] = field(default_factory=dict)
    """Effects of the user's own by name: how each is found again, and the effect as it is before it sees data."""
    spec: str | None = None
    """The name by which the task is loaded again; None where only this process has it."""
    entries: Sequence[Effect] = ()
    """The catalogue's entries for the task."""

    @property
    def task(self) -> Task:
        return self.result.task

    @property
    def diagnosis(self) -> "Diagnosis":
        """All that is said, as it stands in `diagnosis.json`."""
        return self.result.diagnosis

    @property
    def verdict(self) -> str:
        return str(self.diagnosis.verdict)

    @property
    def effects(self) -> pd.DataFrame:
        """A row for each parameter of each effect that was found missing, with what it cannot be told from."""
        from avobench.reports.diagnosis.text import label

        rows = [
            {
                "effect": effect.name,
                "feature": effect.feature,
                "shape": effect.shape,
                "parameter": name,
                **value.model_dump(),
                "tied_with": ", ".join(map(label, effect.tied_with)),
            }
            for effect in self.diagnosis.effects
            for name, value in effect.parameters.items()
        ]
        columns = ["effect", "feature", "shape", "parameter", "value", "std", "null", "unit", "tied_with"]
        return pd.DataFrame(rows, columns=columns)

    @property
    def theta(self) -> pd.DataFrame:
        """A row a parameter of the task: value and standard error without effects, and with those that were found."""
        fits = {"before": self.diagnosis.theta_before, "after": self.diagnosis.theta_after or {}}
        columns = {
            f"{what}_{when}": {name: getattr(value, what) for name, value in theta.items()}
            for when, theta in fits.items()
            for what in ("value", "std")
        }
        return pd.DataFrame(columns, index=pd.Index(self.diagnosis.theta_before, name="parameter"), dtype=float)

    @cached_property
    def model(self) -> Task:
        """The task with the effects that were found: its parameters are those of the task and of the effects."""
        from avobench.effects.model_file import AugmentedTask

        plain = {source or effect.name: effect for source, effect in self.own.values()}
        content = self._content()
        return AugmentedTask.of(
            content, lambda spec, settings: self.task, lambda source: plain[source], entries=list(self.entries)
        )

    def plot(self, name: str | None = None) -> "Figure":
        """A figure by its name; by default the measured events against the simulation before and after.

        The default is of the feature that the first effect acts on, or else in which the events disagree most. Names
        are distribution-1, distribution-2, ... (or maps, for images), gap, theta and candidates. Raises UsageError for
        another name.
        """
        from avobench.reports.diagnosis.figures import drawings

        available = dict(drawings(self.task, self.diagnosis, self.result.pictures))
        if name is not None and name not in available:
            raise UsageError(f"there is no figure '{name}'; this diagnosis has {', '.join(available)}")
        return available[name or self._most_telling(list(available))]().figure

    def _most_telling(self, figures: list[str]) -> str:
        """The name of the figure of the first effect's feature, or else of where the events disagree most."""
        regions = sorted(self.diagnosis.regions, key=lambda region: -abs(region.z))
        wanted = [each.feature for each in (*self.diagnosis.effects[:1], *regions)]
        drawn = {each.feature: f"distribution-{k}" for k, each in enumerate(self.result.pictures.spectra, start=1)}
        return next((drawn[feature] for feature in wanted if feature in drawn), figures[0])

    def save(self, folder: str | Path, title: str | None = None) -> list[Path]:
        """Write `report.html`, its figures, `diagnosis.json`, `model.json`, and `correction.npz` where there is one.

        Each file is written whole or not at all, and diagnosis.json last, so that a folder that has it has all. There
        is no model.json, and a warning says so, where no file could say how to find the task or an effect again, such
        as one that was defined in a notebook. Raises UsageError where the folder cannot be used.
        """
        from avobench.reports import diagnosis as report

        folder = Path(folder)
        require_folder(folder)
        # All that may fail is made before anything of another run is removed, to which this does not belong.
        lost = self._not_found_again()
        model = "" if lost else self._content().model_dump_json(indent=1)
        content = json.dumps(self.diagnosis.model_dump(mode="json"), indent=1)
        for name in ("diagnosis.json", "correction.npz", "model.json"):
            (folder / name).unlink(missing_ok=True)
        paths = report.write(self.task, self.result, folder, title or self.task.name)
        if lost:
            warnings.warn(
                f"no model.json: {lost} has no file; define it in one and name it as file.py:name", stacklevel=2
            )
        else:
            paths.append(write_atomically(folder / "model.json", f"{model}\n".encode()))
        if (weights := self.result.correction) is not None:
            buffer = io.BytesIO()
            np.savez_compressed(buffer, x=weights.x, weights=weights.weights)
            paths.append(write_atomically(folder / "correction.npz", buffer.getvalue()))
        return [*paths, write_atomically(folder / "diagnosis.json", f"{content}\n".encode())]

    def details(self) -> str:
        """All that a screen of text holds: tests, probabilities, regions and notes beside what `print` shows."""
        from avobench.reports.diagnosis.text import details

        return details(self.diagnosis)

    def __str__(self) -> str:
        from avobench.reports.diagnosis.text import summary

        return summary(self.diagnosis)

    def __repr__(self) -> str:
        return str(self)  # what a prompt shows; of all fields it would be pages

    def _repr_html_(self) -> str:
        content = io.BytesIO()
        self.plot().savefig(content, format="png", dpi=100)
        image = base64.b64encode(content.getvalue()).decode()
        picture = f'<img src="data:image/png;base64,{image}" alt="measured and simulated events">'
        return f"<pre>{html.escape(str(self))}</pre>{picture}"

    def _not_found_again(self) -> str:
        """What another process could not find; empty where it finds all."""
        used = {effect.name for effect in self.result.fit.model.effects}
        lost = [f"the effect {name}" for name, (source, _) in self.own.items() if source is None and name in used]
        return f"the task {self.task.name}" if self.spec is None else next(iter(lost), "")

    def _content(self) -> "ModelFile":
        from avobench.diagnosis.report.model_file import describe
        from avobench.diagnosis.report.uncertainties import QuotedFit

        fit, theta = self.result.fit, self.diagnosis.theta_after or self.diagnosis.theta_before
        std = QuotedFit(fit).std
        std[: fit.model.num_theta] = [value.std for value in theta.values()]
        return describe(fit, std, self.spec or self.task.name, self.own)


def diagnose(
    task: Task | str,
    x: ArrayLike,
    *,
    seed: int = 0,
    alpha: float = 0.05,
    max_effects: int = 3,
    simulations: int | None = None,
    fit: str = "surrogate",
    effects: Sequence[str] | str | None = None,
    own: Sequence[Effect | type[Effect] | str] = (),
    drop_invalid: bool = False,
    jobs: int = 1,
    ordered: bool = False,
    time: ArrayLike | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    seconds: float | None = None,
) -> Diagnosed:
    """Say whether measured events disagree with a simulator, where, which effect is missing, and add it.

    The simulator runs in this process, and what ends it ends all, unless `seconds` is given; the command
    `avobench diagnose` has a process for it.

    Parameters
    ----------
    task
        A task, or its name, `module:Class`, `path/to/file.py:Class`, or the path of a model.json.
    x
        Measured events (N, d), or (N,) where an event is one number.
    seed
        Of all that is random. The same seed gives the same diagnosis.
    alpha
        Rate of false alarms, at most.
    max_effects
        Effects to add at most.
    simulations
        Simulated events, at most, with those of the checks; as many as it takes where None.
    fit
        Method that looks for theta first; by default a surrogate of the summary.
    effects
        Names of the effects of the catalogue to try; all that apply where None.
    own
        Effects of one's own to try too: an effect, its class, `module:Class` or `path/to/file.py:Class`.
    drop_invalid
        Leave out rows that hold NaN or infinite values.
    jobs
        Worker processes.
    ordered
        Whether the order of the events is theirs: then drift, change points, seasons and clustering are looked for.
    time
        When each event was (N,), in any unit and order: the same along the time.
    progress
        Is told now and then the phase, the simulated events so far, and about how many there will be.
    seconds
        Works in a process of its own, with one thread, and ends it after so long; the task is sent there. `progress`
        is called there too.

    Raises
    ------
    UsageError
        If there is no such task or effect, if the events are not those of the task, or a number makes no sense.
    ProcessEnded
        If the process took longer than `seconds`, or was ended by what it ran.
    """
    from avobench.diagnosis.checks import Checks
    from avobench.diagnosis.run import diagnose as diagnosed
    from avobench.effects.catalogue import chosen

    if seconds is not None:
        options = {"seed": seed, "alpha": alpha, "max_effects": max_effects, "simulations": simulations, "fit": fit}
        options |= {"effects": effects, "own": own, "drop_invalid": drop_invalid, "jobs": jobs, "ordered": ordered}
        return apart_within(seconds, diagnose, task, x, **options, time=time, progress=progress)
    seed, max_effects, jobs = whole("seed", seed, 0), whole("max_effects", max_effects, 0), whole("jobs", jobs, 1)
    simulations = None if simulations is None else whole("simulations", simulations, 1)
    effects = [effects] if isinstance(effects, str) else effects
    spec = task if isinstance(task, str) else registry.spec_of("task", task)
    if isinstance(task, str):
        task = registry.build("task", task, {})
    registry.require_packages("task", task)
    checks = Checks(task, simulations)
    possible = registry.blamed(checks.entries, f"task {task.name}")
    tried = list(possible) if effects is None else chosen(possible, effects, spec or task.name)
    theirs = {effect.name: (source, effect) for source, effect in map(_own, own)}
    if len(theirs) < len(own) or set(theirs) & {effect.name for effect in possible}:
        raise UsageError(f"two effects have the same name; your own are {', '.join(theirs)}: give them other names")
    for _, effect in theirs.values():
        require_events(effect, task, checks.simulate)
    notes = []
    if time is not None:
        x, time, notes = with_times(x, time, drop_invalid=drop_invalid)
    x, remarks = checks.events(x, drop_invalid=drop_invalid)
    for source, effect in theirs.values():  # what no file can keep would else show when all is done
        registry.blamed(lambda s=source, e=effect: _keepable(e, x, task, s), f"effect {effect.name}")
    result = diagnosed(
        task,
        x,
        seed=seed,
        alpha=alpha,
        max_effects=max_effects,
        num_simulations=simulations,
        num_spent=checks.used,
        fit=fit,
        effects=[*tried, *(effect for _, effect in theirs.values())],
        jobs=jobs,
        ordered=ordered,
        time=time,
        progress=progress,
    )
    diagnosis = result.diagnosis
    diagnosis = diagnosis.model_copy(update={"notes": notes + remarks + diagnosis.notes})
    return Diagnosed(replace(result, diagnosis=diagnosis), theirs, spec, possible)


def _own(given: Effect | type[Effect] | str) -> tuple[str | None, Effect]:
    """The name by which an effect of the user's is loaded again, and the effect."""
    if isinstance(given, str):
        return given, registry.effect(given)
    effect = given() if isinstance(given, type) else given
    return registry.spec_of("effect", effect), effect


def _keepable(effect: Effect, x: NDArray, task: Task, source: str | None) -> None:
    from avobench.diagnosis.report.model_file import kept

    kept(effect.adapted(x), task, source, effect)


def require_events(effect: Effect, task: Task, simulate: Simulate) -> None:
    """Try an effect of the user's on a few events. Raises UsageError if it raises or makes other events than the task.

    Before anything is fitted, since a fault would else show minutes later; `avobench check effect` tries much more.
    """
    rng, what = np.random.default_rng(0), f"effect {effect.name}"
    theta = task.prior.sample(TRIED, rng)

    def apply() -> NDArray:
        phi = rng.uniform(*np.transpose([(p.low, p.high) for p in effect.parameters]), (TRIED, len(effect.parameters)))
        return np.asarray(effect.apply(simulate, theta, phi, rng))

    x = registry.blamed(apply, what)
    if x.shape != (TRIED, task.num_features):
        raise UsageError(f"{what} makes events of shape {x.shape}, not {(TRIED, task.num_features)}")
    if x.dtype != np.dtype(task.dtype) or not np.isfinite(x).all():
        raise UsageError(f"{what} must make finite events of {np.dtype(task.dtype)}, and makes {x.dtype}: {x[0]}")
    if effect.parameters[0].null is None:
        raise UsageError(f"{what}: its strength, {effect.parameters[0].name}, has no null value")
