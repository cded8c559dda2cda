"""The catalogue of a task: which families take part, where they come from, and in which order."""

import numpy as np
import pytest
from measurements import BESIDE, WEEKS, entry

from avobench.effects import catalogue as module
from avobench.effects.catalogue import catalogue, chosen, families, of_domain
from avobench.effects.heaping import Heaping
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.decays import DECAYS
from avobench.tasks.errors import UsageError
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

ORDER = {
    "counts": "ZeroInflation Overdispersion DeadTime ThresholdLoss FlatBackground DoubleCounting ReadoutNoise "
    "Quantisation PileUp Inefficiency Spread Mixture AfterPulses Heaping Truncation Censoring",
    "continuous": "Resolution Offset Scale EdgeAcceptance ForwardBackwardAcceptance FlatBackground PeakBackground "
    "DeadRegion ChargeMisid Outliers Crosstalk Quantisation Saturation TurnOn Truncation Censoring AnalysisWindow "
    "RadiativeTail SecondExponential ConditionalResponse Correlation Spread Mixture Heaping",
    "images": "DeadCells NoisyCells Inefficiency RandomNoise PileUp Threshold TransverseOffset AxialTilt Gain "
    "Spread Mixture",
}
"""The streams of random numbers of a search follow it: another order would give other numbers for a seed."""

THEIRS = """
from avobench.effects import Effect, Parameter


class Echo(Effect):
    name = "echo"
    domains = ("counts", "continuous")
    parameters = (Parameter("chance", 0, 1, 0, "1"),)
    sentence = "Something is heard twice."
    source = "test"

    def apply(self, simulate, theta, phi, rng):
        return simulate(theta, rng)


class Anywhere(Echo):
    name = "anywhere"
    domains = ()
"""


@pytest.mark.parametrize("kind", ORDER)
def test_ours_keep_their_order(kind):
    assert [family.__name__ for family in of_domain(kind)] == ORDER[kind].split()


@pytest.mark.parametrize(
    "of", [Poisson(), Weinberg(), Carl(), Alignment(), DECAYS, WEEKS, BESIDE], ids=lambda each: each.name
)
def test_a_class_has_one_entry_a_feature_and_of_a_family_no_two_shapes_have_one_name(of):
    entries = catalogue(of)
    each = [(type(effect), effect.feature) for effect in entries]
    assert len(set(each)) == len(each)
    kinds = [kind for kind, _ in each]
    assert sorted(kinds, key=kinds.index) == kinds  # those of a class stand beside one another
    shapes = [(effect.key, shape.shape) for effect in entries for shape in effect.shapes()]
    assert len(set(shapes)) == len(shapes)


def test_shapes_that_the_data_show_have_names_of_their_own_too():
    """Two spikes at the end of steps: what reads limits and steps off the data has more shapes then."""
    x = np.round(Weinberg().simulate(np.tile([45.0, 1.0], (20_000, 1)), np.random.default_rng(0)), 2)
    x = np.where(x > 0.8, np.random.default_rng(1).choice([0.7, 0.8], x.shape), x)
    shapes = [(e.key, shape.shape) for e in catalogue(Weinberg(), x) for shape in e.adapted(x).shapes()]
    assert len(set(shapes)) == len(shapes)


def test_tails_and_lifetimes_are_where_they_can_be():
    def of(task, name):
        return [effect for effect in catalogue(task) if effect.name == name]

    def a_time_and_an_angle(theta, rng):
        return np.column_stack([rng.standard_exponential(len(theta)), rng.normal(theta[:, 0])])

    both = task(a_time_and_an_angle, prior={"mean": (0, 3)})
    assert of(DECAYS, "second_exponential")
    assert [effect.feature for effect in of(both, "second_exponential")] == [0]
    assert not any(of(other, "second_exponential") for other in (Weinberg(), Carl(), BESIDE))
    assert not of(Weinberg(), "radiative_tail"), "a cosine has no tail beyond its ends"
    time, angle = ({shape.shape for shape in effect.shapes()} for effect in of(both, "radiative_tail"))
    assert time - angle == {"radiator"}, "a negative value has no energy to lose a share of"


def test_a_rate_alone_has_no_spread_since_that_is_an_overdispersion():
    def two_parameters(theta, rng):
        return rng.poisson(np.exp(theta[:, :1]) + theta[:, 1:])

    assert "spread" not in {effect.name for effect in catalogue(Poisson())}
    of_two = catalogue(task(two_parameters, prior={"log_rate": (0, 3), "background": (0, 2)}))
    assert [effect.feature for effect in of_two if effect.name == "spread"] == ["log_rate", "background"]


def test_each_of_several_counts_has_its_entries_beside_all_alike():
    entries = catalogue(WEEKS)
    assert [effect.feature for effect in entries if effect.name == "dead_time"] == [0, 1, 2, "all"]
    assert [effect.feature for effect in entries if effect.name in ("spread", "mixture")] == ["log_rate", None]
    assert {type(effect).__name__ for effect in entries} == set(ORDER["counts"].split())


def test_counts_beside_real_numbers_have_the_effects_of_each():
    keys = {effect.key for effect in catalogue(BESIDE)}
    assert {("resolution", 0), ("dead_time", 1)} <= keys
    assert not {("resolution", 1), ("dead_time", 0), ("flat_background", "all")} & keys
    heaping = [effect for effect in catalogue(BESIDE) if isinstance(effect, Heaping)]
    assert [(effect.feature, effect.whole) for effect in heaping] == [(1, True), (0, False)]


def test_effects_on_particles_are_for_tasks_that_generate_them():
    class InOneStep(Alignment):
        generates = ""

    particles = {"transverse_offset", "axial_tilt"}
    assert particles <= {effect.name for effect in catalogue(Alignment())}
    assert not particles & {effect.name for effect in catalogue(InOneStep())}
    for each, shapes in ((Alignment(), ["", "soft"]), (InOneStep(), [""])):
        assert [shape.shape for shape in entry(each, "inefficiency").shapes()] == shapes


def test_every_entry_point_says_domain_and_class():
    for point, family in families().items():
        domain, name = point.split(".")
        assert family.__name__ == name.title().replace("_", "")
        assert domain in family.domains
        assert family.name in {other.rpartition(".")[2] for other in families()}  # by which it is asked for, too


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """What installing another distribution leaves behind: a function that gives it entry points."""

    def install(**points):
        folder = tmp_path / "theirs-1.0.dist-info"
        folder.mkdir()
        (tmp_path / "theirs_echo.py").write_text(THEIRS)
        (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: theirs\nVersion: 1.0\n")
        lines = [f"counts.{name} = theirs_echo:{value}" for name, value in points.items()]
        (folder / "entry_points.txt").write_text("\n".join([f"[{module.GROUP}]", *lines]) + "\n")
        monkeypatch.syspath_prepend(str(tmp_path))
        families.cache_clear()

    yield install
    families.cache_clear()


def test_a_family_of_another_distribution_takes_part_after_those_that_have_a_place(installed):
    before = catalogue(Poisson())
    installed(echo="Echo")
    assert [effect.name for effect in catalogue(Poisson())] == [effect.name for effect in before] + ["echo"]
    assert catalogue(Weinberg())[-1].name == "echo"
    assert "echo" not in {effect.name for effect in catalogue(Alignment())}


@pytest.mark.parametrize(("value", "said"), [("Anywhere", "states its domains"), ("Nothing", "AttributeError")])
def test_a_family_that_cannot_take_part_is_named(installed, value, said):
    installed(echo=value)
    with pytest.raises(UsageError, match=f"effect 'counts.echo'.*{said}"):
        catalogue(Poisson())


def test_a_misspelt_name_gives_those_near_it_and_where_all_are_listed():
    known = catalogue(Poisson())
    with pytest.raises(UsageError, match=r"no effect 'dead_tme' for poisson; did you mean dead_time\? `avobench list"):
        chosen(known, ["dead_tme"], "poisson")
    with pytest.raises(UsageError, match="no effect 'xyz' for poisson; `avobench list effects --task poisson`"):
        chosen(known, ["dead_time", "xyz"], "poisson")
    names = ["counts.inefficiency", "dead_time"]
    assert [effect.name for effect in chosen(known, names, "poisson")] == ["dead_time", "inefficiency"]


def test_the_name_of_a_family_chooses_all_its_classes_and_that_of_an_entry_point_one():
    def classes(*names):
        return [type(effect).__name__ for effect in chosen(catalogue(Weinberg()), names, "weinberg")]

    assert classes("edge_acceptance") == ["EdgeAcceptance", "TurnOn", "Truncation", "AnalysisWindow"]
    assert classes("continuous.truncation", "heaping") == ["Truncation", "Heaping"]
    assert classes("saturation", "quantisation") == ["Quantisation", "Saturation", "Censoring", "Heaping"]
    (of_counts,) = chosen(catalogue(Poisson()), ["truncation"], "poisson")
    assert type(of_counts).__name__ == "Truncation"
