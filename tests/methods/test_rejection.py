"""ABC by rejection from a bank, beside a posterior that is known."""

import numpy as np
import pytest
from scipy.stats import chi2, expon, norm

import avobench
from avobench.methods import rejection
from avobench.tasks.errors import UsageError

PRIOR = (1.0, 3.0)


def bank(rng, per, nodes=17):
    lifetime = np.repeat(np.linspace(*PRIOR, nodes), per)
    return avobench.bank(rng.exponential(lifetime), theta={"lifetime": lifetime}, features=["time"])


def exact(x):
    """Mean and standard deviation of the posterior of an exponential's mean by a uniform prior."""
    grid = np.linspace(*PRIOR, 20_001)
    log = -len(x) * np.log(grid) - x.sum() / grid
    share = np.exp(log - log.max()) / np.exp(log - log.max()).sum()
    return share @ grid, np.sqrt(share @ (grid - share @ grid) ** 2)


@pytest.mark.parametrize(("num", "per", "widest"), [(300, 10_000, 1.3), (1000, 1250, 2.2)])
def test_its_posterior_is_the_known_one_with_the_noise_of_the_bank(num, per, widest, monkeypatch):
    monkeypatch.setattr(rejection, "SETS", 300)
    monkeypatch.setattr(rejection, "KEPT", 75)
    rng, pulls, ratios = np.random.default_rng(0), [], []
    for truth in np.linspace(1.2, 2.8, 12):
        known, x = bank(rng, per), rng.exponential(truth, (num, 1))
        found = rejection.rejection(known, known, x, rng, lambda made: None)
        pulls.append((found.mean[0] - truth) / found.std[0])
        ratios.append(found.std[0] / exact(x[:, 0])[1])
    assert chi2.ppf(1e-3, 12) / widest**2 < np.sum(np.square(pulls)) < chi2.ppf(1 - 1e-3, 12)
    assert 0.9 < np.mean(ratios) < widest


def test_it_is_asked_for_by_its_name_and_of_a_bank_alone():
    rng = np.random.default_rng(1)
    known, x = bank(rng, 2000), expon.ppf((np.arange(500) + 0.5) / 500, scale=2.0)
    fit = avobench.infer(known, x, "abc", progress=False)
    mean, std = exact(x)
    assert abs(fit.theta["lifetime"] - mean) < 1.5 * std < 2 * fit.std["lifetime"]
    assert fit.num_simulations == len(known.events)
    assert fit.samples_of == "posterior"
    assert not fit.estimate.doubt
    assert fit.samples()["lifetime"].between(*PRIOR).all()
    assert avobench.infer(known, x, "abc", progress=False).theta == fit.theta
    for task, settings, said in (
        ("poisson", None, "take abc-smc"),
        (known, {"sets": 3}, "without settings"),
        (avobench.bank(x), None, "no theta"),
    ):
        with pytest.raises(UsageError, match=said):
            avobench.infer(task, x, "abc", settings=settings)


def test_a_prior_that_is_not_uniform_counts_in_every_round():
    """Twenty events know a lifetime ten times worse than its prior; its ends alone would give twice its width."""
    rng = np.random.default_rng(2)
    lifetime = np.repeat(np.linspace(1.85, 2.15, 9), 2000)
    known = avobench.bank(rng.exponential(lifetime), theta={"lifetime": lifetime}, prior={"lifetime": norm(2, 0.05)})
    fit = avobench.infer(known, rng.exponential(2.0, 20), "abc", progress=False)
    assert fit.std["lifetime"] == pytest.approx(0.05, rel=0.3)
    assert fit.theta["lifetime"] == pytest.approx(2, abs=0.03)
