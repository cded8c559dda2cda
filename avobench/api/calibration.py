"""Whether a method's errors hold on a task of one's own: many fits of events whose parameters are known."""

import html
import json
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import joblib
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import kstest, norm

from avobench.api.inference import Inference, infer
from avobench.api.load import load
from avobench.api.progress import Progress, shown
from avobench.bench.cells.streams import stream
from avobench.bench.plugins import registry
from avobench.bench.store.files import require_folder, write_file
from avobench.tasks import Task
from avobench.tasks.arguments import checked
from avobench.tasks.checked import checked_events
from avobench.tasks.errors import AvobenchError, UsageError, text_of, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEVELS = (0.5, 0.68, 0.95)
"""The nominal coverages of the table."""
SHOWN = "{:.2g}".format
"""How the table writes a number."""
IDENTITY = "calibration.json"
"""The file in a folder of fits that says what they are fits of."""


@dataclass(frozen=True, repr=False)
class Calibration:
    """Fits of events at parameters that were drawn from the prior, and where these lie in what was quoted.

    It shows itself in a notebook.
    """

    fits: tuple[Inference, ...]
    truth: pd.DataFrame
    """The parameters behind the events of each fit: one row per fit."""
    failed: tuple[str, ...] = ()
    """What went wrong with those that gave no answer, a line each."""

    @property
    def num_simulations(self) -> int:
        """Simulated events of these fits, with those that stand for measured ones."""
        return sum(fit.num_simulations + fit.num_events for fit in self.fits)

    @property
    def ranks(self) -> pd.DataFrame:
        """The share of what was quoted that lies below the true value, one row per fit: uniform if the errors hold.

        Of a posterior it is that of its points (S. Talts and others, arXiv:1804.06788), else that of a Gaussian with
        the quoted standard deviation.
        """
        rows = []
        for fit, true in zip(self.fits, self.truth.to_numpy(), strict=True):
            if (sample := fit.estimate.sample) is not None:
                rows.append(sample.weights @ (sample.theta < true) / sample.weights.sum())
            else:
                value, std = np.array(list(fit.theta.values())), np.array(list(fit.std.values()))
                rows.append(norm.cdf(np.divide(true - value, std, out=np.zeros_like(std), where=true != value)))
        return pd.DataFrame(np.array(rows), columns=self.truth.columns)

    def to_frame(self) -> pd.DataFrame:
        """One row per parameter: how often the central interval of each nominal level held the true value.

        `uniform` is the p-value of the ranks being uniform (Kolmogorov-Smirnov).
        """
        ranks = self.ranks
        columns = {f"in {level:.0%}": ((2 * ranks - 1).abs() <= level).mean() for level in LEVELS}
        return pd.DataFrame({**columns, "uniform": [kstest(ranks[name], "uniform").pvalue for name in ranks]})

    def plot(self) -> "Figure":
        """The ranks of each parameter, and how many true values each central interval held."""
        from avobench.reports.fits import calibration

        return calibration(self.ranks)

    @property
    def _head(self) -> str:
        doubted = sum(bool(fit.doubt) for fit in self.fits)
        head = f"{len(self.fits)} fits by {self.fits[0].method}, {doubted} of them doubtful, {len(self.failed)} failed"
        return f"{head}; {self.num_simulations} simulated events"

    def __str__(self) -> str:
        """How many fits there are, how many were doubted, and the table."""
        return "\n".join([self._head, self.to_frame().to_string(float_format=SHOWN), *self.failed[:1]])

    __repr__ = __str__  # what a prompt shows; of all fields it would be pages

    def _repr_html_(self) -> str:
        table = self.to_frame().to_html(float_format=SHOWN, border=0)
        failed = "".join(f"<p>{html.escape(line)}</p>" for line in self.failed[:1])
        return f"<p>{html.escape(self._head)}</p>{table}{failed}"


@checked
def calibrate(
    task: Task | str,
    method: str = "smm",
    n: int = 100,
    *,
    events: int = 10_000,
    budget: int = 160_000,
    seed: int = 0,
    settings: Mapping[str, Any] | None = None,
    jobs: int = 1,
    folder: str | Path | None = None,
    progress: Progress | bool | None = None,
) -> Calibration:
    """Fit `n` sets of events, each made at other parameters of the prior, and count how often the errors hold.

    Parameters
    ----------
    task, method, settings
        As for `infer`, a method by its name.
    n
        Fits. With 100 a coverage is known to 5 %.
    events
        Observed events of each fit.
    budget
        Simulated events that each fit may use.
    seed
        Of all that is random; results do not depend on `jobs`.
    jobs
        Processes.
    folder
        Keeps each fit as soon as it is made; a call with the same arguments, or a larger `n`, makes what is lacking.
    progress
        Is told the method, the fits so far, and `n`; as for `infer` else.

    Raises
    ------
    UsageError
        If `infer` would refuse, or the folder holds fits of something else, such as a simulator of another source.
    AvobenchError
        What the first fit raised, if none gave an answer. Others that fail are counted.
    """
    task = registry.task_of(task)
    counts = {"n": n, "events": events, "budget": budget, "jobs": jobs}
    n, events, budget, jobs = (whole(name, value, 1) for name, value in counts.items())
    seed = whole("seed", seed, 0)
    streams = [stream(seed, "calibrate", task.name, i) for i in range(n)]
    truth = np.concatenate([task.at_whole(task.prior.sample(1, rng), rng) for rng in streams])
    truth = task.quoted(truth, np.zeros_like(truth))[0]
    identity = {"method": method, "settings": dict(settings or {}), "events": events, "budget": budget, "seed": seed}
    if folder is not None:
        identity |= registry.identity("task", task.name, task) | {"prior": repr(task.prior)}
    with _opened(folder, identity) as path, shown(progress) as tell:
        files = [path / f"fit-{i}.json" for i in range(n)]
        lacking = [i for i in range(n) if _read(files[i]) is None]
        how = {"budget": budget, "settings": dict(settings or {})}
        calls = (joblib.delayed(_fit)(task, method, truth[i], events, seed, i, files[i], how) for i in lacking)
        failed = []
        for done, error in enumerate(joblib.Parallel(n_jobs=jobs, return_as="generator_unordered")(calls), 1):
            failed += [error] if error else []
            tell(method, n - len(lacking) + done, n)
        fits = {i: fit for i, file in enumerate(files) if (fit := _read(file)) is not None}
    if not fits:
        raise failed[0]
    names = list(task.parameter_names)
    return Calibration(
        tuple(fits.values()), pd.DataFrame(truth[list(fits)], columns=names), tuple(map(text_of, failed))
    )


def _fit(
    task: Task, method: str, theta: NDArray[np.float64], events: int, seed: int, i: int, file: Path, how: dict[str, Any]
) -> AvobenchError | None:
    """Fit the events of one theta (p,), and keep the fit in a file; what goes wrong is returned."""
    try:
        x = checked_events(task, np.tile(theta, (events, 1)), stream(seed, "calibrated", task.name, i))
        fit_seed = int(stream(seed, "fit", task.name, i).integers(2**31))
        infer(task, x, method, seed=fit_seed, progress=False, **how).save(file)
    except AvobenchError as error:
        return error
    return None


def _read(file: Path) -> Inference | None:
    try:
        return load(file)
    except UsageError:
        return None


@contextmanager
def _opened(folder: str | Path | None, identity: dict[str, Any]) -> Iterator[Path]:
    """The folder of the fits, made where there is none; one that goes again where none is named."""
    if folder is None:
        with tempfile.TemporaryDirectory() as temporary:
            yield Path(temporary)
        return
    require_folder(path := Path(folder))
    file, content = path / IDENTITY, (json.dumps(identity, indent=1, default=repr) + "\n").encode()
    if file.exists() and file.read_bytes() != content:
        raise UsageError(
            f"{path} holds fits of another task or with other arguments ({file} has them); choose another folder"
        )
    write_file(file, content)
    yield path
