import numpy as np
import pytest
from scipy import stats
from scipy.linalg import block_diag
from scipy.stats import qmc

import avobench
from avobench.tables.comparison import Reduced
from avobench.tasks.errors import UsageError

EDGES = np.linspace(-3, 3, 13)
BOX = [(-0.4, 0.4), (0.8, 1.2)]
THETAS = qmc.scale(qmc.LatinHypercube(2, rng=3).random(20), *np.transpose(BOX))
NARROW = np.mean(BOX, axis=1) + (THETAS - np.mean(BOX, axis=1)) / 4
"""Where a quadratic does."""


def exact(theta):
    """What endless simulation gives: as if of 10^9 events."""
    shares = np.diff(stats.norm.cdf(EDGES, *theta))
    return Reduced(shares, np.diag(shares) - np.outer(shares, shares), 10**9)


def both(r, theta):
    """The same twice, once with a bin that bends."""
    bent = r.mean + 0.02 * np.eye(12)[6] * np.sin(20 * theta[0])
    return Reduced(np.concatenate([r.mean, bent]), block_diag(r.covariance, r.covariance), r.num_events)


def table_at(theta, **more):
    return avobench.Table(EDGES, exact(theta).mean, errors=np.full(12, 0.001), name="normal", **more)


def test_theta_and_its_errors_are_those_of_the_information_of_the_table():
    truth = np.array([0.05, 1.02])
    how = {"names": ["mean", "width"], "default": [-0.05, 0.97]}
    fit = avobench.fit_tables(table_at(truth), NARROW, map(exact, NARROW), **how)
    step = 1e-5 * np.eye(2)
    slopes = np.transpose([(exact(truth + d).mean - exact(truth - d).mean) / 2e-5 for d in step])
    errors = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes))) * 0.001
    assert fit.std == pytest.approx(errors, rel=0.02)
    assert np.abs(fit.theta - truth).max() < 0.1 * errors.min()
    assert fit.before.chi_squared > 100 > fit.after.chi_squared
    assert (fit.dof, fit.num_fitted, fit.after.num_simulations) == (10, 2, 20 * 10**9)
    assert all(said in str(fit) for said in ("mean = 0.05", "default"))


def test_errors_cover_the_truth_with_the_noise_of_the_bank():
    """Most of the variance is the bank's, which has few events."""
    rng, truth, pulls = np.random.default_rng(2), np.array([0.05, 1.0]), []
    for _ in range(16):
        counts = np.histogram(rng.normal(*truth, 4000), EDGES)[0]
        simulated = (rng.normal(*theta, (500, 1)) for theta in THETAS)
        fit = avobench.fit_tables(avobench.Table(EDGES, counts), THETAS, simulated)
        pulls.append((fit.theta - truth) / fit.std)
    assert np.std(pulls) == pytest.approx(1, abs=0.4)
    assert np.abs(np.mean(pulls, axis=0)).max() < 4 / np.sqrt(16)


@pytest.mark.parametrize("entries", [1, 10])
def test_theta_has_the_error_of_the_events_however_many_entries_each_has(entries):
    """Which share of 1 000 events is below 5, told once or ten times an event: binomially."""
    thetas = np.linspace(1.9, 2.1, 9)
    shares = stats.expon.cdf(5, scale=thetas)
    bank = [Reduced(np.array([entries * f]), np.array([[entries**2 * f * (1 - f)]]), 10**9) for f in shares]
    f = stats.expon.cdf(5, scale=2)
    counts = avobench.Table([0, 5], [entries * round(1000 * f)], num_events=1000, of=lambda events: events)
    fit = avobench.fit_tables(counts, thetas, bank, box=[(1.5, 2.5)])
    slope = (stats.expon.cdf(5, scale=2.01) - stats.expon.cdf(5, scale=1.99)) / 0.02
    assert fit.std[0] == pytest.approx(np.sqrt(f * (1 - f) / 1000) / abs(slope), rel=0.05)


def test_what_the_tables_do_not_tell_is_as_wide_as_the_box():
    """Only the mean is told by a table of two bins around it, whatever the width."""
    of = [Reduced(np.array([0.5 - t[0], 0.5 + t[0]]), np.eye(2) / 4, 10**6) for t in THETAS]
    fit = avobench.fit_tables(avobench.Table([0, 1, 2], [0.45, 0.55], errors=[0.01, 0.01]), THETAS, of, box=BOX)
    assert fit.num_fitted == 1
    assert fit.theta[0] == pytest.approx(0.05, abs=0.003)
    assert fit.std[1] == pytest.approx(0.4 / np.sqrt(12), rel=0.05)


def test_a_minimum_beyond_the_box_is_told():
    fit = avobench.fit_tables(table_at([0.6, 1.0]), THETAS, map(exact, THETAS), box=BOX)
    assert fit.at_bound.tolist() == [True, False]
    assert "end of the box" in str(fit)


def test_what_a_quadratic_misses_counts_as_noise_of_its_table():
    """A value that is no quadratic in theta makes its table weigh less; the other one still tells theta."""
    bank = [both(exact(t), t) for t in THETAS]
    fit = avobench.fit_tables([table_at([0.1, 1.0]), table_at([0.1, 1.0])], THETAS, bank)
    assert np.abs(fit.theta - [0.1, 1.0]).max() < 0.01
    assert fit.polynomial.misfit[1] > 3 * fit.polynomial.misfit[0]


@pytest.mark.parametrize(
    ("changed", "word"),
    [
        ({"theta": THETAS[:6], "simulated": THETAS[:6]}, "more than 6 thetas, got 6"),
        ({"simulated": THETAS[:3]}, "20 thetas, but simulated events of 3"),
        ({"theta": THETAS * np.nan}, "finite"),
        ({"theta": np.c_[THETAS[:, 0], THETAS[:, 0]]}, "spread"),
        ({"box": [(-1, 1)]}, "box"),
        ({"box": [(-0.1, 0.1), (0.8, 1.2)]}, "theta of the bank lies outside"),
        ({"default": [5, 1]}, "default lies outside"),
        ({"names": ["a"]}, "1 names for 2"),
    ],
)
def test_a_bank_that_does_not_do_is_told_in_one_line(changed, word):
    given = {"theta": THETAS, "simulated": THETAS, **changed}
    given["simulated"] = [exact([0, 1]) for _ in given["simulated"]]
    with pytest.raises(UsageError, match=word):
        avobench.fit_tables(table_at([0, 1.0]), **given)


def test_normalised_tables_lose_a_degree_of_freedom_in_the_fit_too():
    table = table_at([0.05, 1.0], normalised=True)
    fit = avobench.fit_tables([table, table], THETAS, [both(exact(t), t) for t in THETAS])
    assert (fit.after.dof, fit.dof) == (22, 20)
