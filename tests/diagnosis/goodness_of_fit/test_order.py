"""The order of events: silent where any order is as probable, and each kind of disorder told where it is."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

from avobench.diagnosis.goodness_of_fit.order import bursts, order, projections

N = 4000


def told(x, position=None, along="index", seed=1, **features):
    """What is found in one feature, and others."""
    position = np.arange(len(x), dtype=float) if position is None else position
    return order({"x": x, **features}, position, along, 0.01, np.random.default_rng(seed))


@pytest.mark.parametrize(
    "events",
    [
        lambda rng, n: rng.standard_cauchy(n),
        lambda rng, n: rng.poisson(0.5, n),
        lambda rng, n: rng.poisson(0.02, n),
        lambda rng, n: np.where(rng.random(n) < 0.02, rng.choice([-1.0, 1.0], n), 0),
        lambda rng, n: np.full(n, 3.0),
    ],
    ids=["heavy tails", "counts", "rare counts", "rare on both sides", "all alike"],
)
@pytest.mark.parametrize("along", ["index", "time"])
def test_any_order_is_as_probable(events, along):
    """At 20 % for all tests together, of 150 repeats no more than chance allows once in a thousand times."""
    repeats, n, alarms = 150, 300, 0
    for seed in range(repeats):
        rng = np.random.default_rng([2, seed])
        position = np.arange(n, dtype=float) if along == "index" else rng.integers(0, 500, n).astype(float)
        alarms += bool(order({"x": events(rng, n)}, position, along, 0.2, rng))
    assert alarms <= binom.isf(1e-3, repeats, 0.2)


def test_the_bound_on_false_alarms_is_not_far_too_high():
    """Else nothing weak would be seen: at 50 % at least a tenth of exchangeable data sets alarm."""
    streams = [np.random.default_rng([3, seed]) for seed in range(150)]
    assert sum(bool(order({"x": rng.normal(size=300)}, np.arange(300.0), "index", 0.5, rng)) for rng in streams) >= 15


@pytest.mark.parametrize("tail", [False, True])
def test_a_drift_has_its_size_in_the_features_unit(tail):
    rng = np.random.default_rng(0)
    noise = rng.standard_t(3, N) if tail else rng.normal(size=N)
    (found,) = told(noise + np.linspace(0, 0.5, N))  # and what a drift explains is not told again as another kind
    assert (found.kind, found.feature, found.of, found.at) == ("drift", "x", "level", None)
    assert found.size == pytest.approx(0.5, abs=5 * np.sqrt(12 * 2.5 / N))
    assert found.p_value < 1e-4


MADE = {
    "a higher rate": lambda rng: np.r_[rng.poisson(7, 1500), rng.poisson(7.6, 2500)],
    "a worse resolution": lambda rng: np.r_[rng.normal(0, 1, 2000), rng.normal(0, 1.3, 2000)],
    "eight channels": lambda rng: rng.normal(size=N) + 0.5 * (np.arange(N) % 8 < 4),
    "a memory": lambda rng: lfilter([1], [1, -0.3], rng.normal(size=N)),
}
KINDS = [  # the kind, of what, where, and how large, each within an error
    ("a higher rate", "change point", "level", (1500, 300), (0.6, 5 * np.sqrt(7 * (1 / 1500 + 1 / 2500)))),
    ("a worse resolution", "change point", "spread", (2000, 200), (0.26, 0.06)),
    ("eight channels", "season", "level", (8, 0.01), (1 / np.pi, 5 * np.sqrt(2 / N))),
    ("a memory", "clustering", "level", (1, 0), (0.3, 5 / np.sqrt(N))),
]
"""The size of a change of the spread is one of the mean of both, 0.3 of 1.15, and the first harmonic of a square wave
of 0.5 has an amplitude of 1 / pi."""


@pytest.mark.parametrize(("made", "kind", "of", "at", "size"), KINDS)
def test_what_happens_along_the_index_is_told_where_it_is(made, kind, of, at, size):
    found, *_ = told(MADE[made](np.random.default_rng(0)))
    assert (found.kind, found.of, found.along) == (kind, of, "index")
    assert found.at == pytest.approx(at[0], abs=at[1])
    assert found.size == pytest.approx(size[0], abs=size[1])


def test_a_season_along_uneven_times():
    """Half of the year nothing is measured; the period is the day."""
    rng = np.random.default_rng(0)
    time = rng.uniform(0, 60, 3 * N)
    time = time[(time % 20) < 10]
    found = told(rng.normal(size=len(time)) + 0.4 * np.sin(2 * np.pi * time + 1), time, "time")
    season, *_ = (one for one in found if one.feature == "x")
    assert (season.kind, season.of) == ("season", "level")
    assert season.at == pytest.approx(1, abs=0.002)
    assert season.size == pytest.approx(0.4, abs=5 * np.sqrt(2 / len(time)))
    assert all(one.of == "rate" for one in found if one is not season)  # events do come in blocks


def test_times_that_come_in_bursts_are_told_and_a_rate_that_changes_slowly_is_no_burst():
    rng = np.random.default_rng(0)
    time = np.repeat(rng.uniform(0, 1000, N // 4), 4) + rng.exponential(1e-3, N)
    found = told(rng.normal(size=N), time, "time")
    assert {(one.kind, one.of) for one in found} == {("clustering", "rate")}
    assert found[0].size == pytest.approx(3, rel=0.2)  # a compound Poisson process of four: variance 4 means
    counts = rng.poisson(10 * np.linspace(0.5, 1.5, 1000)).astype(float)
    assert bursts(counts).p_value > 1e-3


def test_the_same_times_may_be_in_any_order():
    """Rows of one day that are sorted by their value are no drift within the day."""
    rng = np.random.default_rng(0)
    x, day = rng.normal(size=N), np.sort(rng.integers(0, 40, N)).astype(float)
    rows = np.lexsort([x, day])
    assert told(x[rows], day[rows], "time") == []
    assert told(x[rows])[0].p_value < 1e-6  # by the index they are not in any order


def test_images_are_followed_by_their_hits_and_where_these_are():
    x = np.zeros((3, 12), int)  # three rows of four
    x[0, [0, 11]] = 1
    x[1, 6] = 5
    found = projections(x, (), (3, 4))
    assert found["hits"].tolist() == [2, 1, 0]
    assert found["row"].tolist() == [1.0, 1.0, 1.0]  # an image without hits is in the middle of the others
    assert found["column"].tolist() == [1.5, 2.0, 1.75]


def test_an_image_in_which_hits_move():
    rng = np.random.default_rng(0)
    x = rng.random((N, 5, 6)) < 0.1
    x[N // 2 :, :, 5] = False
    found = order(projections(x.reshape(N, 30), (), (5, 6)), np.arange(N, dtype=float), "index", 0.01, rng)
    levels = {(one.kind, one.feature) for one in found if one.of == "level"}
    assert levels == {("change point", "hits"), ("change point", "column")}
