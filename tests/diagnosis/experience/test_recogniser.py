"""What events look like beside simulated ones, and which family that is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avobench.diagnosis.experience.recogniser import OUTSIDE, Recogniser, kind_of, portrait, resemblance
from avobench.diagnosis.settings import RECOGNITION
from avobench.effects.catalogue import catalogue, of_domain
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg
from paper.studies.experience import examples


def events(n, d, seed=0, shift=0.0):
    return np.random.default_rng(seed).normal(shift, 1, (n, d))


@given(power=st.integers(-20, 20), seed=st.integers(0, 99))
@settings(max_examples=20)
def test_units_do_not_matter(power, seed):
    x, simulated = events(800, 1, seed, shift=0.1), events(2000, 1, seed + 100)
    factor = 2.0**power
    np.testing.assert_allclose(portrait(factor * x, factor * simulated, False), portrait(x, simulated, False))


def test_the_order_of_features_does_not_matter():
    x, simulated = events(3000, 4), events(6000, 4, seed=1)
    x[:, 2] += 0.3 * x[:, 0] ** 2
    order = [2, 0, 3, 1]
    seen, other = portrait(x[:, order], simulated[:, order], False), portrait(x, simulated, False)
    np.testing.assert_allclose(seen, other, rtol=0.01, atol=0.02)  # a simulated event's place among them is random


def test_where_nothing_differs_bins_scatter_by_their_errors():
    bins = len(RECOGNITION.bin_shares) - 1
    pulls = np.array([portrait(events(2000, 1, k), events(4000, 1, 1000 + k), False)[:bins] for k in range(100)])
    # 5 events in the variance make little of bins that expect few
    assert 0.7 < pulls[:, 5:-5].var() < 1.05
    assert abs(pulls.mean()) < 0.05


def test_remainders_show_in_which_steps_counts_were_rounded():
    rng = np.random.default_rng(2)
    counts, simulated = rng.poisson(40, (5000, 1)), rng.poisson(40, (10_000, 1))
    first = -6 - len(RECOGNITION.steps)  # before spikes and variances
    remainders = portrait(5 * (counts // 5), simulated, True)[first:-6]
    assert set(np.array(RECOGNITION.steps)[np.argsort(remainders)[-2:]]) == {5, 10}
    assert portrait(counts, simulated, True)[first:-6].max() < 3


@pytest.mark.parametrize("counts", [True, False])
@pytest.mark.parametrize("values", [0, 7, 10**12])
def test_values_all_alike_have_a_portrait(counts, values):
    x = np.full((100, 1), values)
    seen = portrait(x if counts else x.astype(float), np.arange(200)[:, None] * (1 if counts else 1.0), counts)
    assert np.isfinite(seen).all()


TASKS = {"count": Poisson(), "real": Weinberg(), "reals": Carl()}


@pytest.mark.parametrize("kind", TASKS)
def test_it_knows_families_of_the_catalogue_by_their_names(kind):
    assert kind_of(TASKS[kind]) == kind
    known = {each.name for each in of_domain("counts" if kind == "count" else "continuous")}
    assert set(Recogniser.of(kind).families) <= known | {OUTSIDE}


@pytest.mark.parametrize("kind", ["count", "real"])
def test_families_are_recognised_in_draws_that_the_networks_have_not_seen(kind):
    drawn, networks = examples(kind, np.random.default_rng(12345), 100), Recogniser.of(kind)
    told = [networks.probabilities(marks) for marks in drawn.portraits.astype(float)]
    right = [max(shares, key=shares.get) in families for shares, families in zip(told, drawn.families, strict=True)]
    assert len(right) > 20
    assert np.mean(right) > 0.3  # of fifteen names and more


def test_only_families_that_may_be_missing_share_the_probability():
    task, rng = Poisson(), np.random.default_rng(0)
    x, simulated = rng.poisson(9, (2000, 1)) * (rng.random((2000, 1)) < 0.9), rng.poisson(8, (4000, 1))
    few = [effect for effect in catalogue(task) if effect.name in ("dead_time", "pile_up")]
    like = resemblance(task, few, x, lambda n: simulated[:n])
    assert set(like) == {"dead_time", "pile_up", OUTSIDE}
    assert sum(np.exp(each) - RECOGNITION.floor for each in like.values()) == pytest.approx(1)


def test_without_experience_of_such_events_all_families_are_alike():
    images, task, rng = Alignment(), Poisson(), np.random.default_rng(0)
    assert len(set(resemblance(images, catalogue(images), np.zeros((10, 1024)), None).values())) == 1
    for mean, some in ((4, False), (6, True)):
        x, simulated = rng.poisson(mean, (500, 1)), rng.poisson(mean, (1000, 1))
        like = resemblance(task, catalogue(task), x, lambda n, simulated=simulated: simulated[:n])
        assert (len(set(like.values())) > 1) == some
