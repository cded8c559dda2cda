"""Which family events look like."""

import numpy as np
import pytest

from avobench.bench.plugins import registry
from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.experience.recogniser import LEAST, Recogniser, compressed, forward, kind_of, resemblance
from avobench.diagnosis.fit.null import fit_null
from avobench.effects.catalogue import catalogue, domain, of_domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted
from avobench.tasks.meter import Meter
from paper.studies.experience import Examples, trained
from paper.studies.simulators import SIMULATORS

TASKS = {"count": "poisson", "real": "weinberg", "reals": "carl"}


def named(task):
    return SIMULATORS[task] if task in SIMULATORS else registry.build("task", task, {})


@pytest.mark.parametrize("kind", TASKS)
def test_it_knows_families_of_the_catalogue_by_their_names(kind):
    assert kind_of(named(TASKS[kind])) == kind
    known = {each.name for each in of_domain("counts" if kind == "count" else "continuous")}
    assert set(Recogniser.of(kind).families) <= known


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
    assert sum(np.exp(each) - LEAST for each in like.values()) == pytest.approx(1)


def test_only_families_that_may_be_missing_share_the_probability():
    task = named("poisson")
    x, simulated = of_strength(task, [np.log(9)], "zero_inflation", 0.3)
    few = [effect for effect in catalogue(task) if effect.name in ("dead_time", "pile_up")]
    like = resemblance(task, few, x, simulated)
    assert set(like) == {"dead_time", "pile_up"}
    assert sum(np.exp(each) - LEAST for each in like.values()) == pytest.approx(1)


def test_of_images_there_is_no_experience():
    task = registry.build("task", "alignment", {})
    assert resemblance(task, catalogue(task), np.zeros((10, 1024)), np.zeros((10, 1024))) == {}


def test_with_small_counts_there_is_no_experience():
    task, rng = named("poisson"), np.random.default_rng(0)
    assert resemblance(task, catalogue(task), rng.poisson(4, (500, 1)), rng.poisson(4, (1000, 1))) == {}
    assert resemblance(task, catalogue(task), rng.poisson(6, (500, 1)), rng.poisson(6, (1000, 1))) != {}


def test_a_trained_network_says_the_same_with_its_scale_in_its_weights():
    rng = np.random.default_rng(0)
    portraits = 10 * rng.normal(size=(600, 7)) + 5
    names = np.array(["first", "second", "third"])[portraits[:, :3].argmax(axis=1)]
    families, networks = trained(Examples(portraits.astype(np.float32), np.stack([names, names], 1)))
    told = np.array([np.mean([forward(each, row) for each in networks], axis=0) for row in compressed(portraits)])
    assert (np.array(families)[told.argmax(axis=1)] == names).mean() > 0.9
