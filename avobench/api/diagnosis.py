"""A diagnosis of a user's own events, from Python as from the command line."""

import base64
import html
import io
import json
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.api.described import Described, array, description, plain
from avobench.api.joint import Joint, require_measured, tables_in
from avobench.api.progress import Progress, limited, shown
from avobench.bench.events.checks import NUM_REFERENCE, require_order, valid, with_times
from avobench.bench.plugins import registry
from avobench.bench.plugins.source import CODE, as_module
from avobench.bench.store.files import require_folder, write_atomically
from avobench.effects import Effect
from avobench.effects.contract import Simulate
from avobench.tables.table import Table, Tables
from avobench.tasks import Task
from avobench.tasks.arguments import checked
from avobench.tasks.errors import BudgetExhausted, UsageError, whole
from avobench.tasks.function import FunctionTask
from avobench.tasks.interpolation import apart
from avobench.tasks.joint import JointTask
from avobench.tasks.missing import missing_in_both
from avobench.tasks.region import beside, failures
from avobench.tasks.sample import SampleTask, require_enough
from avobench.tasks.sample import bank as sample_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from avobench.diagnosis import Diagnosis, Result
    from avobench.diagnosis.checks import Checks
    from avobench.diagnosis.report.model_file import ModelFile

TRIED = 50
"""Events on which an effect of the user's is tried before anything is fitted."""
WEIGHT = "avobench weight"
"""The column of simulated.parquet that holds the weight of each event."""
HERE = "__main__:"
"""The prefix of an effect of a script or a notebook, which another process does not find by its name."""


def _no_model() -> Task:
    raise UsageError("the folder of this diagnosis has no model.json")


@dataclass(frozen=True, repr=False)
class Diagnosed:
    """What a simulator lacks, by measured events; shows itself in a notebook, and is kept by `save`."""

    result: "Result"
    content: "ModelFile | None" = None
    """What model.json holds; its task is "" where only this process has it. None where a folder has no such file."""
    build: Callable[[], Task] = _no_model
    """What makes the model."""

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
        """One row per parameter of the task: value and standard error without effects, and with the named ones."""
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
        return self.build()

    def plot(self, name: str | None = None) -> "Figure":
        """A figure by its name; by default the measured events against the simulation before and after.

        The default is of the feature that the first effect acts on, or else in which the events disagree most. Names
        are distribution-1, distribution-2, ... (or maps, for images) and theta. Raises UsageError for another name.
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

        `avobench.load` reads the folder again, and commands accept `model.json` as a task. A task that has no name by
        which another process finds it, such as one that was made in a script or a notebook, is kept in `task.py`: its
        function or class, and what that uses of its module. So are effects in `effects.py`. There is no model.json, and
        a warning says why, where that cannot be. Of a sample of simulated events there is `simulated.parquet` in its
        place: events with the effects that were added. Each file is written whole or not at all, and diagnosis.json
        last: a folder that has it has all. Raises UsageError where the folder cannot be used, or has another `task.py`
        or `effects.py`.
        """
        from avobench.reports import diagnosis as report

        folder = Path(folder)
        require_folder(folder)
        # All that may fail is made before anything of another run is removed, to which this does not belong.
        if self.result.fit is None:
            raise UsageError("this diagnosis was read from a folder; copy that folder")
        sample, joint = isinstance(self.task, SampleTask), isinstance(self.task, JointTask)
        content, code, lost = self.content, {}, []
        if not sample and not joint:
            content, code, lost = _with_code(self.content, self.task, folder.resolve())
        for path in code:
            if path.exists() and not path.read_bytes().startswith(CODE.encode()):
                raise UsageError(f"{path} is not of a diagnosis and would be replaced; choose another folder")
        pictures = json.dumps({"task": description(self.task), **asdict(self.result.pictures)}, default=plain)
        record = json.dumps(self.diagnosis.model_dump(mode="json"), indent=1)
        for name in ("diagnosis.json", "correction.npz", "model.json", "simulated.parquet"):
            (folder / name).unlink(missing_ok=True)
        paths = report.write(self.task, self.result, folder, title or self.task.name)
        if sample:
            paths.append(write_atomically(folder / "simulated.parquet", self._simulated()))
        elif joint:
            warnings.warn("no model.json: it holds one simulator, and this diagnosis has several", stacklevel=2)
        elif lost:
            warnings.warn(
                f"no model.json: another process does not find {lost[0]}; define it by `def` or `class` at the top of "
                "a file or of a cell",
                stacklevel=2,
            )
        else:
            paths += [write_atomically(path, text.encode()) for path, text in code.items()]
            paths.append(write_atomically(folder / "model.json", f"{content.model_dump_json(indent=1)}\n".encode()))
        paths.append(write_atomically(folder / "figures.json", f"{pictures}\n".encode()))
        if (weights := self.result.correction) is not None:
            buffer = io.BytesIO()
            np.savez_compressed(buffer, x=weights.x, weights=weights.weights)
            paths.append(write_atomically(folder / "correction.npz", buffer.getvalue()))
        return [*paths, write_atomically(folder / "diagnosis.json", f"{record}\n".encode())]

    def _simulated(self) -> bytes:
        """The content of a Parquet file: as many events as the sample has, with the effects that were added.

        Their weights are alike, and add up to those of the sample.
        """
        fit = self.result.fit
        x = fit.model.simulate(np.tile(fit.params, (len(self.task.events), 1)), np.random.default_rng(0))
        table = pd.DataFrame(x, columns=list(self.task.labels))
        return table.assign(**{WEIGHT: self.task.total / len(x)}).to_parquet(index=False)

    @classmethod
    def read(cls, folder: Path, trust: bool = False) -> "Diagnosed":
        """The diagnosis that `save` wrote to a folder; `trust` as for `avobench.load`.

        Raises OSError, AttributeError, KeyError, TypeError or ValueError where it is none.
        """
        from avobench.diagnosis import Diagnosis, Result
        from avobench.diagnosis.report.result import Maps, Pictures, Spectrum
        from avobench.effects.model_file import ModelFile

        def arrays(record: dict[str, Any]) -> dict[str, Any]:
            return {name: array(value) if isinstance(value, list) else value for name, value in record.items()}

        diagnosis = Diagnosis.model_validate_json((folder / "diagnosis.json").read_bytes())
        drawn = json.loads((folder / "figures.json").read_bytes())
        spectra, maps = (Spectrum(**arrays(each)) for each in drawn["spectra"]), drawn["maps"]
        pictures = Pictures(tuple(spectra), None if maps is None else Maps(**arrays(maps)))
        result, file = Result(Described(drawn["task"]), diagnosis, None, pictures, None), folder / "model.json"
        if not file.exists():
            return cls(result)
        spec = registry.trusted(str(file), trust)
        content = ModelFile.model_validate_json(file.read_bytes())
        return cls(result, content, partial(registry.build, "task", spec, {}))

    def details(self) -> str:
        """All that a screen of text holds: tests, probabilities, regions and notes beside what `print` shows."""
        from avobench.reports.diagnosis.text import details

        return details(self.diagnosis)

    def decide(
        self, conditions: Mapping[str, Task | str | Mapping[str, float]] | None = None, *, simulations: int = 200_000
    ) -> pd.DataFrame:
        """How many more measured events would tell the models of the 95 % set apart, and under which condition.

        Parameters
        ----------
        conditions
            By a name for each, a run that might be made: a task with the same parameters and features under other
            conditions, or values of parameters that can be chosen, which are then known. None simulates nothing.
        simulations
            Simulated events for each condition, at most.

        Returns
        -------
        A row for each other model of the set and each condition, that of more events of the same kind first: `events`
        to be measured beside the present ones, with `low` and `high` one standard error away, and where most of the
        difference is. `events` is 0 where the present ones are enough, and missing where no number is known to be.

        Raises
        ------
        UsageError
            If a condition has other parameters or features, too few simulated events, or nothing is to be decided.
        """
        from avobench.diagnosis.checks import bank_of
        from avobench.reports.diagnosis.text import model, where
        from avobench.tasks.meter import Meter

        decisions, rivals = list(self.diagnosis.decisions), self.result.rivals
        if conditions and rivals is None:
            raise UsageError("there are no fitted models to decide between: there is one alone, or a folder was read")
        for name, given in (conditions or {}).items():
            chosen = given if isinstance(given, Mapping) else {}
            task = self.task if isinstance(given, Mapping) else registry.task_of(given)
            require_condition(name, task, self.task, chosen)
            bank = bank_of(task, Meter(whole("simulations", simulations, 1)))
            try:
                decisions += rivals.under(name, bank, chosen, simulations)
            except BudgetExhausted as error:
                raise UsageError(
                    f"{name}: {simulations} simulated events are too few; allow {4 * simulations}"
                ) from error
        rows = [
            {
                "true": model(each.true),
                "rival": model(each.rival),
                "condition": each.condition or "more of the same",
                "where": each.where and where(each.where),
                **each.model_dump(include={"events", "low", "high", "share"}),
            }
            for each in decisions
        ]
        columns = ["true", "rival", "condition", "events", "low", "high", "where", "share"]
        numbers = dict.fromkeys(["events", "low", "high"], "Int64")
        return pd.DataFrame(rows, columns=columns).astype(numbers)

    def __str__(self) -> str:
        from avobench.reports.diagnosis.text import summary

        return summary(self.diagnosis)

    __repr__ = __str__  # what a prompt shows; of all fields it would be pages

    def _repr_html_(self) -> str:
        content = io.BytesIO()
        self.plot().savefig(content, format="png", dpi=100)
        image = base64.b64encode(content.getvalue()).decode()
        picture = f'<img src="data:image/png;base64,{image}" alt="measured and simulated events">'
        return f"<pre>{html.escape(str(self))}</pre>{picture}"


@checked
@limited
def diagnose(
    task: Task | str | ArrayLike | pd.DataFrame | Joint,
    x: ArrayLike | pd.DataFrame | Table | Tables | Sequence[Table] | None = None,
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
    progress: Progress | bool | None = None,
    bank: str | Path | None = None,
    seconds: float | None = None,
) -> Diagnosed:
    """Say whether measured events disagree with a simulator, where, which effect is missing, and add it.

    The simulator runs in this process, and what ends it ends all, unless `seconds` is given; the command
    `avobench diagnose` has a process for it.

    Parameters
    ----------
    task
        A task, or its name, `module:Class`, `path/to/file.py:Class`, or the path of a model.json; or simulated events
        that were made before, (M, d) or (M,), which `avobench.bank` takes with their parameters and weights; or several
        data sets with what was measured, by `avobench.joint`, without `x`.
    x
        Measured events (N, d), or (N,) where an event is one number; or published tables, `Table` or several, by the
        features of the task or by functions of its events.
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
        Is told now and then the phase, the simulated events so far, and about how many there will be. By default a bar
        on a terminal, or a line in a notebook, shows them; False shows nothing.
    bank
        Folder in which simulated events are kept; those that it has of this simulator are used before any is made.
    seconds
        Works in a process of its own, with one thread, and ends it after so long; the task is sent there. `progress`
        is called there too, so a notebook shows none.

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

    seed, max_effects, jobs = whole("seed", seed, 0), whole("max_effects", max_effects, 0), whole("jobs", jobs, 1)
    simulations = None if simulations is None else whole("simulations", simulations, 1)
    effects = [effects] if isinstance(effects, str) else effects
    require_measured(task, x)
    joint = task if isinstance(task, Joint) else None
    task, spec = (joint.task, None) if joint else _named(task, x)
    calls = len(joint.sets) if joint else 1  # of simulators, for an event of each data set
    simulations = simulations and simulations // calls
    sample = isinstance(task, SampleTask)
    if sample and (simulations is not None or bank is not None):
        raise UsageError("simulated events that were made before are all there are: leave simulations and bank out")
    registry.require_packages("task", task)
    folder, before = None if bank is None else Path(bank), beside(task)
    tables, part = tables_in(x), None
    size = NUM_REFERENCE if joint or tables or not hasattr(x, "__len__") else len(x)
    checks = Checks(task, size, simulations, seed=seed, jobs=jobs, folder=folder)
    possible = registry.blamed(checks.entries, f"task {task.name}")
    tried = list(possible) if effects is None else chosen(possible, effects, spec or task.name)
    user_effects = _user_effects(own, possible, task, checks.simulate)
    if joint or tables:
        if ordered or time is not None or fit != "surrogate" or (tables and drop_invalid):
            raise UsageError("tables and several data sets are no single sample: leave ordered, time and fit out")
        part, remarks = checks.joint(joint.sets, drop_invalid=drop_invalid) if joint else (checks.tables(tables), [])
    else:
        x, time, remarks = _timed(checks, x, time, drop_invalid)
    measured: Any = x if part is None else part
    if not task.parameter_names:
        require_enough(task, np.empty(0), len(measured))
    tried_on = (
        checks.simulate(task.prior.sample(TRIED, rng := np.random.default_rng(0)), rng) if part and user_effects else x
    )
    for each in user_effects.values():  # what no file can keep would else show when all is done
        registry.blamed(partial(_keepable, each, tried_on, task), f"effect {each.effect.name}")
    with shown(progress) as tell:
        result = diagnosed(
            task,
            measured,
            seed=seed,
            alpha=alpha,
            max_effects=max_effects,
            fit=fit,
            effects=[*tried, *(each.effect for each in user_effects.values())],
            jobs=jobs,
            ordered=ordered,
            time=time,
            progress=tell,
            bank=checks.bank,
        )
    diagnosis = result.diagnosis
    p = len(task.parameter_names)
    require_enough(task, result.fit.params[:p], len(measured))
    remarks += failures(task, result.fit.params[:p], result.fit.std[:p])
    update = {
        "notes": remarks + diagnosis.notes,
        "num_simulations": calls * (diagnosis.num_simulations - checks.bank.meter.failed) + beside(task) - before,
    }
    diagnosis = with_shift(diagnosis.model_copy(update=update), task)
    return _diagnosed(replace(result, diagnosis=diagnosis), spec, user_effects, possible)


def with_shift(diagnosis: "Diagnosis", task: Task) -> "Diagnosis":
    """The diagnosis with errors of theta that cover the shift by a bank of few thetas; a larger shift is a doubt."""
    update: dict[str, Any] = {}

    def wider(of: Any, by: float) -> Any:
        return of.model_copy(update={"std": None if of.std is None else float(np.hypot(of.std, by))})

    for when in ("after", "before"):
        if values := getattr(diagnosis, f"theta_{when}"):
            theta, std = np.array([(each.value, each.std) for each in values.values()], float).T
            moved, update["doubt"] = apart(task, theta, std / 2)  # a mixture is also wider, which tests see
            by = dict(zip(values, moved, strict=True))
            update[f"theta_{when}"] = {name: wider(each, by[name]) for name, each in values.items()}
            update[f"identified_{when}"] = [
                wider(each, sum(c * by[name] for name, c in each.coefficients.items()))
                for each in getattr(diagnosis, f"identified_{when}")
            ]
    return diagnosis.model_copy(update=update)


def require_condition(name: str, task: Task, measured: Task, chosen: Mapping[str, float]) -> None:
    """Raise UsageError unless a task may stand for another condition of one that was measured."""
    if isinstance(measured, JointTask | SampleTask):
        raise UsageError(f"{name}: a condition is of one simulator; of several data sets each is a condition already")
    if (task.parameter_names, task.num_features) != (measured.parameter_names, measured.num_features):
        raise UsageError(f"{name}: {task.name} has other parameters or features than {measured.name}")
    for parameter, value in chosen.items():
        if parameter not in task.parameter_names:
            raise UsageError(
                f"{name}: {task.name} has no parameter {parameter}; it has {', '.join(task.parameter_names)}"
            )
        k = task.parameter_names.index(parameter)
        if not task.support.low[k] <= value <= task.support.high[k]:
            low, high = task.support.low[k], task.support.high[k]
            raise UsageError(f"{name}: {parameter} lies between {low:g} and {high:g}, got {value:g}")


def _timed(
    checks: "Checks", x: ArrayLike | pd.DataFrame, time: ArrayLike | None, drop_invalid: bool
) -> tuple[NDArray, NDArray[np.float64] | None, list[str]]:
    """The measured events (n, d), when each was (n,) where that is told, and warnings. Raises UsageError."""
    if time is None:
        x, warnings = checks.events(x, drop_invalid=drop_invalid)
        return x, None, warnings
    given, when, warnings = with_times(x, time, drop_invalid=drop_invalid)
    x, more = checks.events(given, drop_invalid=drop_invalid)
    if len(x) < len(when):
        require_order(when := when[valid(checks.task, given)])
    return x, when, warnings + more


def _named(task: Task | str | ArrayLike | pd.DataFrame, x: Any) -> tuple[Task, str | None]:
    """The task that is meant, and the name by which it is loaded again; None where it has none.

    What holds NaN in a sample and in the measured events x may be missing.
    """
    if not isinstance(task, Task | str | type) and not callable(task):
        task = sample_of(task, missing=[] if tables_in(x) else missing_in_both(task, x))
    if isinstance(task, SampleTask):
        return task, None
    loaded = registry.task_of(task)
    return loaded, task if isinstance(task, str) else registry.spec_of("task", task)


def _diagnosed(
    result: "Result", spec: str | None, user_effects: Mapping[str, "UserEffect"], entries: Sequence[Effect]
) -> Diagnosed:
    """What is shown and kept of a result.

    `spec` loads the task again, `user_effects` are those of the user by name, `entries` those of the catalogue. The
    model is made of the objects that this process has.
    """
    from avobench.diagnosis.report.model_file import describe
    from avobench.diagnosis.report.uncertainties import QuotedFit
    from avobench.effects.model_file import AugmentedTask

    fit, theta = result.fit, result.diagnosis.theta_after or result.diagnosis.theta_before
    std = QuotedFit(fit).std
    std[: fit.model.num_theta] = [value.std for value in theta.values()]
    content = describe(fit, std, spec or "", {name: (each.source, each.loaded) for name, each in user_effects.items()})
    loaded = {registry.absolute(each.source or name): each.loaded for name, each in user_effects.items()}
    build = partial(AugmentedTask.of, content, result.task, loaded.__getitem__, entries=list(entries))
    return Diagnosed(result, content, build)


def _with_code(content: "ModelFile", task: Task, folder: Path) -> tuple["ModelFile", dict[Path, str], list[str]]:
    """What model.json says once code that has no name elsewhere is kept in `folder`; these files; and what is lost."""
    levels = [content]
    while not isinstance(levels[-1].task, str):  # the effects were added to a model
        levels.append(levels[-1].task)
        task = task.model.task
    sources = [each.source for level in levels for each in level.effects if each.source is not None]
    lost = [f"the effect {source}" for source in sources if ":" not in source]
    code, kept = {}, levels[-1].task
    if here := {source.removeprefix(HERE) for source in sources if source.startswith(HERE)}:
        code["effects.py"] = as_module("__main__", here)
        lost += [] if code["effects.py"] else [f"the effect {', '.join(sorted(here))}"]
    if not kept:
        name, code["task.py"] = _code(task)
        lost += [] if code["task.py"] else [f"the simulator of {task.name}"]
        kept = f"{folder / 'task.py'}:{name}"
    for level in reversed(levels):
        effects = [
            each.model_copy(update={"source": each.source and each.source.replace(HERE, f"{folder / 'effects.py'}:")})
            for each in level.effects
        ]
        kept = level.model_copy(update={"task": kept, "effects": effects})
    return kept, {folder / name: text for name, text in code.items() if text}, lost


def _code(task: Task) -> tuple[str, str | None]:
    """The name of a task in a module of its own, and the text of that module; None where it cannot be read."""
    if not isinstance(task, FunctionTask):
        module, name = [("", ""), *registry.places_of("task", task)][-1]
        return name, as_module(module, {name})
    name = getattr(task.function, "__qualname__", "")
    text = as_module(getattr(task.function, "__module__", ""), {name})
    made = f"task = avobench.task({name}, **{task.arguments!r})"
    return "task", text and f"{text}\nimport scipy.stats\n\nimport avobench\n\n{made}\n"


def _user_effects(
    given: Sequence[Effect | type[Effect] | str], possible: Sequence[Effect], task: Task, simulate: Simulate
) -> dict[str, "UserEffect"]:
    """The user's effects by name; each is tried on a few events."""
    by_name = {each.effect.name: each for each in map(UserEffect.of, given)}
    if len(by_name) < len(given) or set(by_name) & {effect.name for effect in possible}:
        raise UsageError(f"two effects have the same name; your own are {', '.join(by_name)}: give them other names")
    for each in by_name.values():
        require_events(each.effect, task, simulate)
    return by_name


class UserEffect(NamedTuple):
    """A user's effect, and the name that loads it again."""

    effect: Effect
    source: str | None
    """Its name, as for `registry.effect`; with HERE in front where it is of a script or a notebook."""
    loaded: Effect
    """What this name loads: a file keeps the settings in which the effect differs from it."""

    @classmethod
    def of(cls, given: Effect | type[Effect] | str) -> "UserEffect":
        if isinstance(given, str):
            effect = registry.effect(given)
            return cls(effect, given, effect)
        effect = given() if isinstance(given, type) else given
        here = [name for module, name in registry.places_of("effect", effect) if f"{module}:" == HERE]
        source = f"{HERE}{here[-1]}" if here else registry.spec_of("effect", effect)
        by_class = source is not None and source.endswith(f":{type(effect).__name__}")
        return cls(effect, source, type(effect)() if by_class else effect)


def _keepable(given: UserEffect, x: NDArray, task: Task) -> None:
    from avobench.diagnosis.report.model_file import kept

    kept(given.effect.adapted(x), task, given.source, given.loaded)


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
    if x.dtype != np.dtype(task.dtype) or task.broken(x).any():
        raise UsageError(f"{what} must make finite events of {np.dtype(task.dtype)}, and makes {x.dtype}: {x[0]}")
    if effect.parameters[0].null is None:
        raise UsageError(f"{what}: its strength, {effect.parameters[0].name}, has no null value")
