"""The grammar of what may be wrong: functions, primitives, labels and simulators."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avobench.effects.catalogue import of_domain
from paper.grammar import counts, reals
from paper.grammar.counts import COUNTS
from paper.grammar.functions import GRID, Function, draw, gaussian_process
from paper.grammar.reals import REALS
from paper.grammar.sentences import OUTSIDE, Place, Words
from paper.grammar.simulators import simulator, task

N = 40_000
CONSTANT = Function("constant", np.ones_like(GRID))
GRAMMARS = {"count": COUNTS, "real": REALS, "reals": REALS}
normal = task("normal", ["location"], lambda theta, rng: rng.normal(theta, 1), 1)
even = task("even", ["location"], lambda theta, rng: rng.random((len(theta), 1)), 1)
pair = task("pair", ["location"], lambda theta, rng: rng.normal(0, 1, (len(theta), 2)), 2)
poisson = task("poisson", ["scale"], lambda theta, rng: rng.poisson(20 * np.exp(theta)), 1, counts=True)


def done(grammar, name, on, strength, f=CONSTANT, r=0.0):
    """Events of a simulator with what a primitive does to them, and those without: (n, d), (n, d)."""
    primitive = next(each for each in grammar.primitives if each.name == name)
    theta, rng = np.zeros((N, 1)), np.random.default_rng(0)
    reference = on.simulate(theta, np.random.default_rng(1))
    places = [Place(on, reference, j) for j in range(on.num_features)]
    act = primitive.acts(places, "value", Words(f, strength, 1, np.full(5, r)), rng)
    return act(on.simulate, theta, rng), reference


@pytest.mark.parametrize("kind", ["linear", "monotone", "smooth", "stepped", "local", "periodic"])
@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_a_function_is_of_its_class(kind, seed):
    f = draw(kind, np.random.default_rng(seed))
    assert (f.values.min(), f.values.max()) == (0, 1)
    right = {"linear": f.turns == 0, "monotone": f.turns == 0, "local": f.turns <= 1, "periodic": f.turns > 2}
    assert right.get(kind, True)


def test_gaussian_processes_have_the_covariance_that_they_are_named_for():
    samples = np.array([gaussian_process(0.2, np.random.default_rng(seed))[[0, 200, 500]] for seed in range(600)])
    expected = np.exp(-((GRID[[0, 200, 500], None] - GRID[[0, 200, 500]]) ** 2) / 2 / 0.2**2)
    np.testing.assert_allclose(np.cov(samples.T), expected, atol=0.2)


@pytest.mark.parametrize(
    ("name", "strength", "mean", "std"),
    [
        ("shifted", 0.5, 0.5, 1),
        ("stretched", 0.5, 0, 1.5),
        ("blurred", 0.5, 0, 1.25**0.5),
        ("flipped", 0.5, 0, 1),
        ("best", 1, np.pi**-0.5, (1 - 1 / np.pi) ** 0.5),
        ("average", 1, 0, 0.5**0.5),
    ],
)
def test_what_is_done_to_normal_events_has_the_moments_that_it_should(name, strength, mean, std):
    x, _ = done(REALS, name, normal, strength)
    np.testing.assert_allclose([x.mean(), x.std()], [mean, std], atol=0.02)


@pytest.mark.parametrize(
    ("name", "strength", "mean", "variance"),
    [
        ("thinned", 0.5, 10, 10),
        ("branched", 0.5, 30, 20 * (0.25 + 2.25)),
        ("merged", 1, 40, 40),
        ("emptied", 0.5, 10, 10 + 100),
        ("exposed_unequally", 0.3, 20, 20 + 36),
        ("blinded", 1e-9, 20, 20),
        ("differences", 1, 40**0.5 * (2 / np.pi) ** 0.5, 40 * (1 - 2 / np.pi)),
    ],
)
def test_what_is_done_to_poisson_counts_has_the_moments_that_it_should(name, strength, mean, variance):
    x, _ = done(COUNTS, name, poisson, strength, r=0.5 if name == "emptied" else 0.0)
    assert x.mean() == pytest.approx(mean, rel=0.02)
    assert x.var() == pytest.approx(variance, rel=0.04)


def test_events_are_lost_where_the_function_says():
    x, _ = done(REALS, "lost", even, 1, Function("linear", GRID))
    assert x.mean() == pytest.approx(1 / 3, abs=0.01)  # density 2 (1 - x)


def test_events_from_elsewhere_have_the_function_as_their_density():
    x, _ = done(REALS, "replaced", normal, 0.5, Function("local", 1.0 * (np.abs(GRID - 0.9) < 0.02)))
    low, high = np.quantile(normal.simulate(np.zeros((N, 1)), np.random.default_rng(1)), [0.005, 0.995])
    inside = (np.abs((x - low) / (high - low) - 0.9) < 0.022).mean()
    assert inside == pytest.approx(0.5, abs=0.02)


def test_steps_and_limits_leave_values_that_repeat():
    assert len(np.unique(done(REALS, "stepped", normal, 1, r=0.5)[0])) < 1000
    clipped, free = done(REALS, "clipped", even, 1, r=0.5)
    assert (clipped == clipped.max()).mean() == pytest.approx((free > clipped.max()).mean(), abs=0.01)


def test_features_go_together_where_they_share_something():
    for name, f in (("leaked", Function("linear", GRID)), ("shared", CONSTANT)):
        x, reference = done(REALS, name, pair, 0.5, f, 0.4)
        assert np.corrcoef(x.T)[0, 1] > 0.15 > abs(np.corrcoef(reference.T)[0, 1])


def at(place, width=0.02):
    return Function("local", np.exp(-(((GRID - place) / width) ** 2)))


@pytest.mark.parametrize(
    ("rule", "values", "family"),
    [
        (reals.on_a_side, GRID, "forward_backward_acceptance"),
        (reals.on_a_side, GRID > 0.5, "forward_backward_acceptance"),
        (reals.on_a_side, GRID > 0.9, "edge_acceptance"),
        (reals.on_a_side, GRID < 0.1, "edge_acceptance"),
        (reals.on_a_side, GRID > 0.1, None),  # hardly anything is kept
        (reals.inside, at(0.5).values, "dead_region"),
        (reals.inside, at(0.99).values, None),
        (reals.wavy, np.cos(20 * GRID), OUTSIDE),
        (counts.at_an_end, GRID < 0.1, "threshold_loss"),
        (counts.at_an_end, GRID > 0.8, "truncation"),
        (counts.inside, at(0.5).values, OUTSIDE),
        (counts.of_many, GRID**2, "dead_time"),
        (counts.of_many, 1 - GRID, None),
    ],
)
def test_the_catalogue_claims_what_its_sentences_say(rule, values, family):
    assert rule(Words(Function("any", np.asarray(values, float)), 0.5, 1, np.zeros(5))) == family


@pytest.mark.parametrize("kind", GRAMMARS)
def test_every_family_of_the_catalogue_is_told_and_nothing_else(kind):
    known = {each.name for each in of_domain("counts" if kind == "count" else "continuous")}
    alone = {"crosstalk", "conditional_response", "correlation"} if kind == "real" else set()
    assert set(GRAMMARS[kind].claims(2 if kind == "reals" else 1)) == known - alone | {OUTSIDE}


@pytest.mark.parametrize("kind", GRAMMARS)
def test_draws_are_those_of_their_seed_and_events_of_their_simulator(kind):
    for seed in range(12):
        made = []
        for _ in range(2):
            rng = np.random.default_rng(seed)
            on = simulator(kind, rng)
            theta = np.tile(on.prior.sample(1, rng), (500, 1))
            said = GRAMMARS[kind].sentence(on, on.simulate(theta, rng), rng)
            made.append((on.name, said[:4], said.act(on.simulate, theta, rng)))
        assert made[0][:2] == made[1][:2]
        np.testing.assert_array_equal(made[0][2], made[1][2])
        assert made[0][2].shape == (500, on.num_features)
        assert np.isfinite(made[0][2]).all()
        assert kind != "count" or (made[0][2] >= 0).all()
