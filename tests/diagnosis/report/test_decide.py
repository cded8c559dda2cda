"""How many events tell models apart, where the number is known."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

import avobench
from avobench.api.diagnosis import Diagnosed
from avobench.diagnosis.fit.fit import fit_at
from avobench.diagnosis.fit.surrogate import Design, surrogate
from avobench.diagnosis.report.decide import Pair, Rivals, Separation
from avobench.diagnosis.settings import TEST
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.joint import JointPart
from avobench.diagnosis.summary.target import target_of
from avobench.effects import Effect, Parameter
from avobench.effects.bank import Bank
from avobench.effects.model import Model
from avobench.tasks.errors import BudgetExhausted, UsageError
from avobench.tasks.joint import JointTask
from avobench.tasks.meter import Meter

NEEDED = (2 * norm.ppf(0.95)) ** 2
N, SHARE, LOW, HIGH = 4000, 0.015, 1.0, 1.5


@dataclass(frozen=True)
class Cluster(Effect):
    """A share of the events lies evenly between `low` and `high`, whatever the simulator makes."""

    name: str = "cluster"
    low: float = LOW
    high: float = HIGH
    feature: int | None = 0
    parameters = (Parameter("share", 0, 0.2, 0, "1"),)
    stage = 4
    sentence = source = "test"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        x[:, 0] = np.where(rng.random(len(x)) < phi[:, 0], rng.uniform(self.low, self.high, len(x)), x[:, 0])
        return x


def gaussian(mean=0.0):
    return avobench.task(lambda theta, rng: mean + rng.normal(theta), prior={"mu": (-4, 4)}, name="normal")


def fit_of(model, target, share):
    """A fit at a mean of 0 and given shares of clusters: nothing is minimised."""
    point = model.to_cube(np.r_[0.0, [share] * len(model.effects)])
    s = surrogate(model, target, Design(point, np.eye(model.dim) * 0.02), 20 * N, np.random.default_rng(1))
    return fit_at(model, s, target, point)


def known(share, edges, mean=0.0, free=True):
    """Chi-squared of one event in bins between N(mean, 1), its mean `free` or not, and the same with a cluster.

    By the variance of events without a cluster or, where nothing is free, with one.
    """
    ends = np.r_[-np.inf, edges, np.inf]
    p, along = np.diff(norm.cdf(ends - mean)), -np.diff(norm.pdf(ends - mean))
    change = share * (np.diff(np.clip((ends - LOW) / (HIGH - LOW), 0, 1)) - p)
    p = p if free else p + change
    absorbed = free * (change @ (along / p)) ** 2 / (along @ (along / p))
    return change @ (change / p) - absorbed


@pytest.fixture(scope="module")
def normal():
    """Events of N(0, 1), a bank of such, and their fit with given effects."""
    bank, rng = Bank(gaussian(), Meter(), 0), np.random.default_rng(0)
    bank.resolve(np.array([0.01]))
    bank.session()(np.zeros((80 * N, 1)), rng)
    x = gaussian().simulate(np.zeros((N, 1)), rng)
    target = target_of(x, bins_of(x, x), x)

    def fitted(*effects):
        return fit_of(Model(bank.task, effects, bank), target, SHARE)

    return SimpleNamespace(x=x, target=target, bank=bank, fitted=fitted)


def decided(pair, x, **how):
    spans = pair.target.summary.view(x).spans
    return pair.decision(Rivals([[pair]], spans, ("x",)), **how)


@given(delta=st.floats(0.01, 1), turned=st.floats(0, 1), seed=st.integers(0, 100))
def test_two_gaussians_whose_means_differ(delta, turned, seed):
    """Of one event chi-squared is the squared difference, and what the rival imitates of that does not count."""
    noise = 0.05 * delta * np.random.default_rng(seed).standard_normal((40, 3))
    difference = delta * np.array([np.cos(turned), np.sin(turned), 0]) + noise
    seen = Separation(difference, np.empty((3, 0)), np.array([[0.0], [1.0], [0.0]]))
    value, error = seen.noncentrality()
    assert value == pytest.approx((delta * np.cos(turned)) ** 2, abs=5 * error)
    assert error < 0.2 * delta**2


def test_noise_of_simulation_is_no_difference():
    rng = np.random.default_rng(0)
    values, errors = np.transpose(
        [
            Separation(rng.standard_normal((20, 30)), np.empty((30, 0)), np.empty((30, 0))).noncentrality()
            for _ in range(300)
        ]
    )
    assert abs(values.mean()) < 4 * values.std() / np.sqrt(300)
    assert values.std() < errors.mean() < 2 * values.std()


def total(events):
    """Events that are fitted, of so many measured ones beside those of the fixture."""
    return N + (1 - TEST.held_out_share) * events


def test_conditions_with_unequal_numbers_of_pieces_add_up():
    rng = np.random.default_rng(5)
    some, more = (Separation(rng.normal(1, 0.3, (g, 1)), np.empty((1, 0)), np.empty((1, 0))) for g in (50, 64))
    for one, other in ((some, more), (more, some)):
        value, error = one.beside(other, 2, 3).noncentrality()
        assert abs(value - 5) < 4 * error < 2


def test_the_number_of_events_and_the_interval_are_those_that_are_known(normal):
    pair = Pair.of(normal.fitted(Cluster()), normal.fitted(), normal.target)
    used = normal.bank.meter.used
    decision = decided(pair, normal.x)
    per_event = known(SHARE, normal.target.summary.edges[0])
    # That the share is known with an error adds 1 to the chi-squared of all.
    assert total(decision.events) == pytest.approx(NEEDED / (per_event - 1 / N), rel=0.2)
    assert decision.low < decision.events < decision.high
    assert (decision.where.kind, decision.where.feature) == ("excess", "x")
    assert decision.where.low == pytest.approx(LOW, abs=0.15)
    assert decision.where.high == pytest.approx(HIGH, abs=0.15)
    assert decision.share > 0.7
    assert normal.bank.meter.used == used  # nothing was simulated


def test_the_same_effect_by_another_name_is_never_told(normal):
    pair = Pair.of(normal.fitted(Cluster()), normal.fitted(Cluster("other")), normal.target)
    decision = decided(pair, normal.x)
    assert decision.events is decision.high is None
    assert decision.low is None or decision.low > 3 * N


def test_of_two_sets_the_one_in_which_the_effect_is_tells():
    """And with a set of the other kind alone nothing is ever told: the sets add up to the whole."""
    tasks, rng = {"near": gaussian(), "far": gaussian(1.0)}, np.random.default_rng(0)
    joint = JointTask(tasks)
    sets = tuple(task.simulate(np.zeros((n, 1)), rng) for task, n in zip(tasks.values(), (N, N // 2), strict=True))
    bank = Bank(joint, Meter(), 0)
    bank.resolve(np.array([0.01]))
    bank.session()(np.zeros((40 * N, 1)), rng)
    target = JointPart(joint, sets).target(joint.simulate(np.zeros((N, 1)), rng))
    fits = (fit_of(Model(joint, effects, bank), target, 2 * SHARE) for effects in ((Cluster(),), ()))
    pair = Pair.of(*fits, target)
    near, far = pair.sets().values()
    both = near.beside(far, N, N // 2).noncentrality()[0]
    assert both == pytest.approx(target.num_events * pair.now.noncentrality()[0], rel=0.02)
    assert far.noncentrality()[0] < 0.01 * near.noncentrality()[0]


@pytest.mark.parametrize("chosen", [True, False])
def test_a_run_where_the_effect_is_plainer_takes_fewer_events(normal, chosen):
    """At a mean of 3 few events are where the cluster is, whether mu is set to that or the simulator is another."""
    pair = Pair.of(normal.fitted(Cluster()), normal.fitted(), normal.target)
    bank = Bank(gaussian(0.0 if chosen else 3.0), Meter(400_000), 0)
    seen = pair.under(bank, {"mu": 3.0} if chosen else {}, 500)
    value, error = replace(
        seen, slopes=np.empty((len(seen.slopes), 0)), rival=np.zeros_like(seen.rival)
    ).noncentrality()
    fine = norm.ppf(np.linspace(0.001, 0.999, 60), 3.0)
    assert value == pytest.approx(known(SHARE, fine, 3.0, free=False), abs=4 * error)
    assert not chosen or not seen.rival.any()  # what is chosen is known
    assert decided(pair, normal.x, adds=seen).events < 0.7 * decided(pair, normal.x).events
    assert bank.meter.used <= 400_000
    with pytest.raises(BudgetExhausted):
        pair.under(Bank(gaussian(3.0), Meter(1000), 0), {}, 1000)


@pytest.fixture(scope="module")
def found(normal):
    """A diagnosis as far as what would decide needs one."""
    rivals = Rivals([[Pair.of(normal.fitted(Cluster()), normal.fitted(), normal.target)]], [], ())
    said = SimpleNamespace(decisions=rivals.decisions())
    return Diagnosed(SimpleNamespace(task=normal.bank.task, diagnosis=said, rivals=rivals))


def test_runs_that_might_be_made_stand_beside_more_of_the_same(found):
    table = found.decide({"far": {"mu": 3.0}, "other": gaussian(3.0)}, simulations=300_000)
    assert table.condition.tolist() == ["more of the same", "far", "other"]
    assert table.events.idxmax() == 0
    assert found.decide().equals(table[:1])


@pytest.mark.parametrize(
    ("condition", "word"),
    [
        ({"nu": 3.0}, "it has mu"),
        ({"mu": 9.0}, "between -4 and 4"),
        ("weinberg", "other parameters"),
        ({"mu": 3.0}, "allow 8000"),
    ],
)
def test_a_run_that_cannot_be_compared_is_told_in_one_line(found, condition, word):
    with pytest.raises(UsageError, match=word):
        found.decide({"run": condition}, simulations=2000)


def test_without_fits_a_run_cannot_be_compared(found):
    read = Diagnosed(SimpleNamespace(**{**vars(found.result), "rivals": None}))
    assert read.decide().equals(found.decide())
    with pytest.raises(UsageError, match="no fitted models"):
        read.decide({"far": {"mu": 3.0}})
