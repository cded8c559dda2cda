"""What events look like beside simulated ones, and which family that is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import avobench
from avobench.bench.plugins import registry
from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.experience.recogniser import Recogniser, kind_of, portrait, resemblance
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.settings import RECOGNITION
from avobench.effects.catalogue import catalogue, domain, of_domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted
from avobench.tasks.meter import Meter
from paper.grammar.sentences import OUTSIDE


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


TASKS = {"count": "poisson", "real": "weinberg", "reals": "carl"}
SMALL = {
    "binomial": avobench.task(lambda t, rng: rng.binomial(20, t[:, 0]), prior={"p": (0.1, 0.9)}),
    "poissons": avobench.task(lambda t, rng: rng.poisson(t[:, 0]), prior={"rate": (0.3, 60)}),
    "exponential": avobench.task(lambda t, rng: rng.exponential(t[:, 0]), prior={"mean": (0.5, 5)}),
    "normal": avobench.task(lambda t, rng: rng.normal(t[:, 0], t[:, 1]), prior={"mean": (-2, 2), "std": (0.5, 2)}),
    "mixed": avobench.task(
        lambda t, rng: np.stack([rng.exponential(t[:, 0]), rng.normal(t[:, 1]), rng.gamma(2, t[:, 0])], axis=1),
        prior={"scale": (0.5, 3), "mean": (-1, 1)},
    ),
}


def named(task):
    return SMALL[task] if task in SMALL else registry.build("task", task, {})


@pytest.mark.parametrize("kind", TASKS)
def test_it_knows_families_of_the_catalogue_by_their_names(kind):
    assert kind_of(named(TASKS[kind])) == kind
    known = {each.name for each in of_domain("counts" if kind == "count" else "continuous")}
    assert set(Recogniser.of(kind).families) <= known | {OUTSIDE}


def of_strength(task, theta, name, share, n=20_000):
    """Events with an effect so far from its null value to its bound, and simulated ones without, with theta fitted."""
    effect = next(effect for effect in catalogue(task) if effect.name == name)
    middle = [(p.low * p.high) ** 0.5 if p.logarithmic else (p.low + p.high) / 2 for p in effect.parameters]
    strength = effect.parameters[0]
    middle[0] = strength.null + share * (strength.high - strength.null)
    rng = np.random.default_rng(1)
    x = effect.apply(task.simulate, np.tile(theta, (n, 1)), np.tile(middle, (n, 1)), rng)
    model = Model(task, events=Counted(task, Meter()))
    fit, _ = fit_null(model, x, rng, effort_for(task, domain(task), None, n), None)
    return x, task.simulate(np.tile(fit.params, (2 * n, 1)), rng)


@pytest.mark.parametrize(
    ("task", "theta", "name", "share"),
    [
        ("binomial", [0.5], "zero_inflation", 0.3),
        ("poissons", [50.0], "dead_time", 0.1),
        ("exponential", [2.0], "quantisation", 0.5),
        ("normal", [0.0, 1.0], "dead_region", 0.8),
        ("mixed", [1.0, 0.0], "correlation", 0.8),
    ],
)
def test_what_is_plain_to_see_is_recognised(task, theta, name, share):
    task = named(task)
    like = resemblance(task, catalogue(task), *of_strength(task, theta, name, share))
    assert max(like, key=like.get) == name
    assert sum(np.exp(each) - RECOGNITION.floor for each in like.values()) == pytest.approx(1)


def test_only_families_that_may_be_missing_share_the_probability():
    task = named("poisson")
    x, simulated = of_strength(task, [np.log(9)], "zero_inflation", 0.3)
    few = [effect for effect in catalogue(task) if effect.name in ("dead_time", "pile_up")]
    like = resemblance(task, few, x, simulated)
    assert set(like) == {"dead_time", "pile_up"}
    assert sum(np.exp(each) - RECOGNITION.floor for each in like.values()) == pytest.approx(1)


def test_there_is_no_experience_with_images_and_small_counts():
    images, task, rng = registry.build("task", "alignment", {}), named("poisson"), np.random.default_rng(0)
    assert resemblance(images, catalogue(images), np.zeros((10, 1024)), np.zeros((10, 1024))) == {}
    for mean, some in ((4, False), (6, True)):
        x, simulated = rng.poisson(mean, (500, 1)), rng.poisson(mean, (1000, 1))
        assert bool(resemblance(task, catalogue(task), x, simulated)) == some
