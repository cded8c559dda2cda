"""The catalogue of a task: which families take part, where they come from, and in which order."""

import numpy as np
import pytest

from avobench.effects import catalogue as module
from avobench.effects.catalogue import catalogue, chosen, families, of_domain
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.errors import UsageError
from avobench.tasks.function import task
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg

ORDER = {
    "counts": "zero_inflation overdispersion dead_time threshold_loss flat_background double_counting readout_noise "
    "quantisation pile_up inefficiency spread mixture after_pulses heaping truncation censoring",
    "continuous": "resolution offset scale edge_acceptance forward_backward_acceptance flat_background peak_background "
    "dead_region charge_misid outliers crosstalk quantisation saturation turn_on truncation censoring analysis_window "
    "radiative_tail second_exponential conditional_response correlation spread mixture heaping",
    "images": "dead_cells noisy_cells inefficiency random_noise pile_up threshold transverse_offset axial_tilt gain "
    "spread mixture",
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
    assert [family.name for family in of_domain(kind)] == ORDER[kind].split()


@pytest.mark.parametrize("task", [Poisson(), Weinberg(), Carl(), Alignment()], ids=lambda task: task.name)
def test_a_name_has_an_entry_for_each_feature_beside_one_another(task):
    keys = [effect.key for effect in catalogue(task)]
    assert len(set(keys)) == len(keys)
    names = [name for name, _ in keys]
    assert sorted(names, key=names.index) == names


def weeks(theta, rng):
    return rng.poisson(np.exp(theta[:, [0]]) * [1, 2, 3])


def test_each_of_several_counts_has_its_entries_beside_all_alike():
    entries = catalogue(task(weeks, prior={"log_rate": (0, 3)}))
    assert [effect.feature for effect in entries if effect.name == "dead_time"] == [0, 1, 2, "all"]
    assert [effect.feature for effect in entries if effect.name in ("spread", "mixture")] == ["log_rate", None]
    assert {effect.name for effect in entries} == set(ORDER["counts"].split())


def test_counts_beside_real_numbers_have_the_effects_of_each():
    def both(theta, rng):
        return np.column_stack([rng.normal(theta[:, 0]), rng.poisson(7, len(theta))])

    keys = [effect.key for effect in catalogue(task(both, prior={"mean": (0, 3)}, kinds={"x2": "count"}))]
    assert {("resolution", 0), ("dead_time", 1), ("heaping", 0), ("heaping", 1)} <= set(keys)
    assert not {("resolution", 1), ("dead_time", 0), ("flat_background", "all")} & set(keys)
    assert len(set(keys)) == len(keys)


def test_effects_on_particles_are_for_tasks_that_generate_them():
    class InOneStep(Alignment):
        generates = ""

    particles = {"transverse_offset", "axial_tilt"}
    assert particles <= {effect.name for effect in catalogue(Alignment())}
    assert not particles & {effect.name for effect in catalogue(InOneStep())}
    shapes = [
        [shape.shape for effect in catalogue(task) if effect.name == "inefficiency" for shape in effect.shapes()]
        for task in (Alignment(), InOneStep())
    ]
    assert shapes == [["", "soft"], [""]]


def test_every_entry_point_says_domain_and_name():
    for point, family in families().items():
        domain, name = point.split(".")
        assert family.name == name
        assert domain in family.domains


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
    installed(echo="Echo")
    assert [effect.name for effect in catalogue(Poisson())] == [*ORDER["counts"].split(), "echo"]
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
