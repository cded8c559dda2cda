"""The simplest rival of the search for names: a classifier that has seen the shapes of earlier series.

`python -m avobench.studies.recognised FOLDER ...`, of challenges with one count or one cosine. It fits no model: from a
portrait of the measured events beside the nearest simulated ones it tells the family, as it has learned from random
examples of all hidden shapes of the series before. Records in `results/recognised`; `python -m
avobench.reports.recognised` compares them with what the search said of the same data.
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import poisson
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.neural_network import MLPClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from avobench.bench import registry
from avobench.bench.atomic import write_atomically
from avobench.bench.events import check_events, read_events
from avobench.challenge.hide import NUM_REFERENCE
from avobench.challenge.shapes import ONE_FAMILY, SERIES, Injection, Place, kind_of_events
from avobench.challenge.solve import read_json, read_manifest
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

RESULTS = Path("results/recognised")
EXAMPLES = 40
"""Of each shape, at random strengths and random theta."""
SHARES = np.r_[0, 1e-4, 1e-3, 3e-3, 0.01, 0.03, np.linspace(0.06, 0.94, 23), 0.97, 0.99, 0.997, 0.999, 0.9999, 1]
"""Of the nearest Poisson distribution, between which counts are counted: the tails finely."""
STEPS = (2, 3, 4, 5, 8, 10)
"""In which counts may have been rounded."""
RATES = 200
"""Around the median count, among which that of the nearest Poisson distribution is looked for."""
COSINES = np.linspace(-1, 1, 51)
"""Borders of the bins of a cosine."""
MOST = 60.0
"""Standard deviations beyond which a bin tells no more."""
SEEN = 5.0
"""Standard deviations by which chi-squared exceeds its degrees of freedom in an example that shows anything."""
NETWORKS = 3
"""Whose probabilities are averaged with those of the trees."""


def portrait(kind: str, x: NDArray) -> tuple[NDArray[np.float64], float]:
    """What a classifier sees of one feature (n,), and how many standard deviations chi-squared is too large."""
    return portrait_of_counts(x) if kind == "counts" else portrait_of_cosines(x)


def portrait_of_counts(x: NDArray) -> tuple[NDArray[np.float64], float]:
    """Beside the nearest Poisson distribution: its quantiles, moments, remainders of division, and spikes."""
    n, values = len(x), np.arange(max(int(x.max()), STEPS[-1]) + 2)
    number = np.bincount(x, minlength=len(values))
    rng = np.random.default_rng(0)

    median = np.median(x)
    rates = np.geomspace(0.85 * max(median - 1, 0.3), 1.15 * (median + 1), RATES)
    distances = [np.abs(np.cumsum(number) / n - poisson.cdf(values, rate)).mean() for rate in rates]
    rate = float(rates[np.argmin(distances)])
    below = poisson.cdf(values - 1, rate)[x]
    placed = np.histogram(below + rng.random(n) * poisson.pmf(values, rate)[x], SHARES)[0]
    pulls, ratios = compared(placed, n * np.diff(SHARES))
    beside = x + rng.integers(-STEPS[-1], STEPS[-1] + 1, n)
    remainders = [np.abs(np.bincount(x % k, minlength=k) - np.bincount(beside % k, minlength=k)).max() for k in STEPS]
    neighbours = np.convolve(number, [0.5, 0, 0.5], "same")
    spikes = (number - neighbours) / np.sqrt(number + neighbours + 5)
    moments = [np.log(rate), (x == 0).mean(), np.log1p(x.max() / rate), x.mean() / rate, x.var() / rate]
    places = [spikes.max(), spikes.min(), spikes.argmax() / rate, spikes.argmin() / rate]
    return np.r_[pulls, ratios, moments, np.array(remainders) / np.sqrt(n), places], excess(pulls)


def portrait_of_cosines(x: NDArray) -> tuple[NDArray[np.float64], float]:
    """Beside the nearest density 1 + c^2 + a c: shares of bins, values that repeat, and what lies at the ends."""
    n, centres = len(x), (COSINES[1:] + COSINES[:-1]) / 2
    number = np.histogram(x, COSINES)[0]
    even, odd = (n * np.diff(COSINES) * each for each in (3 / 8 * (1 + centres**2), centres))
    asymmetry = np.clip((odd * (number - even) / even).sum() / (odd**2 / even).sum(), -0.74, 0.74)
    pulls, ratios = compared(number, np.maximum(even + asymmetry * odd, 1))
    _, repeated = np.unique(x, return_counts=True)
    fine = np.histogram(x, 400, (-1, 1))[0]
    ends = [x.min(), x.max(), np.log1p(fine[:4].mean()), np.log1p(fine[-4:].mean())]
    equal = [len(repeated) / n, np.log(repeated.max()), np.log1p((repeated > 5).sum())]
    step = np.abs(np.diff(fine)).max() / np.sqrt(n / 400)
    return np.r_[pulls, ratios, asymmetry, (x > 0).mean(), ends, equal, step], excess(pulls)


def compared(number: NDArray, expected: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pulls of bins (k,), and logarithms of their ratios."""
    pulls = (number - expected) / np.sqrt(expected + 5)
    return np.clip(pulls, -MOST, MOST), np.log((number + 1) / (expected + 1))


def excess(pulls: NDArray[np.float64]) -> float:
    """By how many standard deviations the square of pulls (k,) is too large."""
    return float((pulls @ pulls - len(pulls)) / np.sqrt(2 * len(pulls)))


def examples(
    task: Task, series: Sequence[int], num_events: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], list[str]]:
    """Portraits (m, f) of random data sets with a shape of these series, where they show anything, and its family."""
    kind, found, families = kind_of_events(task), [], []
    for shape in (shape for each in series for shape in SERIES[each][kind]):
        for _ in range(EXAMPLES):
            theta = np.tile(task.prior.sample(1, rng), (num_events, 1))
            place = Place(task, 0, task.simulate(theta[:NUM_REFERENCE], rng))
            if not shape.suits(place):
                break
            seen, by = portrait(kind, drawn(shape, place, theta, rng))
            if by > SEEN:
                found.append(seen)
                families.append(shape.name)
    return np.array(found), families


def drawn(
    shape: type[Injection], place: Place, theta: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """One feature (n,) of events with this shape, of random strength."""
    return shape.draw(place, rng).measure(place.task.simulate, theta, rng)[:, 0]


def trained(portraits: NDArray[np.float64], families: list[str]) -> list:
    """Classifiers of two kinds, whose probabilities are averaged."""
    networks = [
        make_pipeline(StandardScaler(), MLPClassifier((128, 64), alpha=0.01, early_stopping=True, random_state=k))
        for k in range(NETWORKS)
    ]
    trees = HistGradientBoostingClassifier(learning_rate=0.07, l2_regularization=1.0, random_state=0)
    return [each.fit(portraits, families) for each in (trees, *networks)]


def told(classifiers: list, seen: NDArray[np.float64]) -> dict[str, float]:
    """Probabilities of families by a portrait (f,)."""
    mean = np.mean([each.predict_proba(seen[None])[0] for each in classifiers], axis=0)
    return dict(zip(classifiers[0].classes_.tolist(), mean.tolist(), strict=True))


def study(folder: Path) -> Path:
    """Tell the family of each data set of a challenge that has one hidden effect; the path of its records."""
    manifest = read_manifest(folder)
    spec = registry.named_in(folder / "manifest.json", "task", manifest["task"], trust=False)
    task = registry.build("task", spec, {})
    kind = kind_of_events(task)
    if task.num_features != 1 or kind == "images":
        raise UsageError(f"{folder} has events of several features; a portrait is of one count or one cosine")
    answers = read_json(folder / "answers.json")["cases"]
    last = max(effect["series"] for each in answers for effect in each["effects"] if effect.get("series"))
    before = [series for series in SERIES if series < last]
    rng = np.random.default_rng(last)
    classifiers = trained(*examples(task, before, manifest["num_events"], rng))
    lines = [{"task": manifest["task"], "series": last, "trained_on": before}]
    for answer in answers:
        if len(answer["effects"]) != 1:
            continue
        x, _ = check_events(task, read_events(str(folder / "data" / f"{answer['case']}.npz")))
        seen, _ = portrait(kind, x[:, 0])
        name = answer["effects"][0]["name"]
        hidden = ONE_FAMILY.get((kind, name), name)
        line = {"case": answer["case"], "kind": answer["kind"], "hidden": hidden}
        lines.append({**line, "probabilities": told(classifiers, seen)})
    path = RESULTS / f"{folder.name}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, "".join(json.dumps(line) + "\n" for line in lines).encode())
    return path


if __name__ == "__main__":
    for given in sys.argv[1:]:
        print(study(Path(given)))
