"""The test of an estimate with fresh events: right as often as it says, at any size, and what else fits as well."""

import numpy as np
import pytest

import avobench
from avobench.api.agreement import left_open, mirrored, two_sample


@pytest.mark.parametrize(("kind", "sizes"), [("normal", (150, 90)), ("poisson", (40, 190))])
def test_events_of_one_distribution_are_told_apart_as_rarely_as_the_p_value_says(kind, sizes):
    """More than four of twenty below 0.05 have a probability of 3e-3."""
    p_values = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        make = rng.standard_normal if kind == "normal" else lambda shape, rng=rng: rng.poisson(4, shape)
        p_values.append(two_sample(make((sizes[0], 2)), make((sizes[1], 2)), rng))
    assert sum(p < 0.05 for p in p_values) <= 4


def line(theta, rng):
    """Uniform, but for a fraction of a narrow peak."""
    n = len(theta)
    return np.where(rng.random(n) < theta[:, 0], rng.normal(0.5, 0.01, n), rng.uniform(0, 1, n))


def pairs(theta, rng):
    """Two numbers of a correlation, each of which is alike whatever that is."""
    a, b = rng.standard_normal((2, len(theta)))
    return np.stack([a, theta[:, 0] * a + np.sqrt(1 - theta[:, 0] ** 2) * b], axis=1)


def tails(theta, rng):
    """Student's t, whose tails change more than its middle."""
    return rng.standard_t(theta)


@pytest.mark.parametrize(
    ("make", "here", "there", "n"), [(line, 0.02, 0, 20_000), (pairs, 0.5, 0.2, 3000), (tails, 3, 6, 10_000)]
)
def test_a_narrow_peak_a_dependence_and_other_tails_are_seen(make, here, there, n):
    rng = np.random.default_rng(0)
    observed, simulated = (make(np.full((n, 1), theta), rng).reshape(n, -1) for theta in (here, there))
    assert two_sample(observed, simulated, rng) < 1e-6


def test_a_fit_of_few_events_is_tested_and_one_of_hardly_any_says_that_it_was_not():
    task = avobench.task(lambda theta, rng: rng.normal(theta[:, 0], 1), prior={"mean": (-3, 3)})
    rng = np.random.default_rng(0)
    sound, wrong = rng.normal(0.5, 1, 100), rng.exponential(1, 100) * rng.choice([-3, 3], 100)
    assert avobench.infer(task, sound, "smm", budget=1000).estimate.doubt == ""
    for x, budget, said in ((wrong, 1000, "p = "), (sound[:5], 1000, "at least 10"), (sound, 240, "at least 10")):
        assert said in avobench.infer(task, x, "smm", budget=budget).estimate.doubt


def mirrored_in_a(theta, rng):
    """Events that know only the size of the first parameter."""
    return rng.normal(np.stack([np.abs(theta[:, 0]), theta[:, 1]], axis=1), 1)


TASK = avobench.task(mirrored_in_a, prior={"a": (-2, 2), "b": (-2, 2)}, name="mirrored")
THETA = np.array([1.0, -0.4])


class Known(avobench.Method):
    """It answers THETA, whatever the events are."""

    name, source = "known", "none"

    def min_simulations(self, num_parameters):
        return 1

    def infer(self, problem, rng):
        problem.simulate(THETA[None])
        error = np.full(2, 0.02)
        return avobench.Estimate(THETA, "known", "proposal", THETA, error, error=error)


def test_a_mirror_image_that_fits_as_well_is_said_and_kept(tmp_path):
    x = mirrored_in_a(np.tile(THETA, (2500, 1)), np.random.default_rng(0))
    fit = avobench.infer(TASK, x, Known(), budget=20_000)
    assert fit.estimate.doubt == ""
    assert fit.others == ({"a": -1.0, "b": -0.4},)
    assert "as good: a = -1, b = -0.4" in str(fit)
    assert "a = -1" in fit._repr_html_()
    assert avobench.load(fit.save(tmp_path / "fit.json")).others == fit.others


def test_the_candidates_are_other_signs_and_places():
    told = {tuple(row) for row in mirrored(np.array([1.0, 2.0]))}
    assert told == {(-1, 2), (1, -2), (-1, -2), (2, 1), (-2, -1)}


def test_an_open_combination_is_named_by_its_ends():
    along = np.array([1, -1]) / np.sqrt(2)
    (said,) = left_open(TASK, np.zeros(2), np.outer(along, along) + 1e-4 * np.eye(2))
    assert "a = 0.707, b = -0.707" in said.replace("from a = -0.707, b = 0.707", "")
    assert left_open(TASK, np.zeros(2), 1e-4 * np.eye(2)) == []
