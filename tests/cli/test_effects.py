"""`avobench list`: every effect can be found."""

from avobench.effects.catalogue import catalogue, of_domain
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.decays import DECAYS
from avobench.tasks.poisson import Poisson

ENDED = 110
"""Columns that a line may take."""


def test_list_shows_every_effect_with_what_it_does_its_shapes_and_parameters(done):
    out = done("list", "effects")
    assert all(len(line) <= ENDED for line in out.splitlines())
    words = " ".join(out.split())
    for kind in ("counts", "continuous", "images"):
        for name in {family.name for family in of_domain(kind)}:  # of which the first class says what it is
            first = next(family for family in of_domain(kind) if family.name == name)
            assert f"{name}: {first.sentence}" in words
    for effect in (*catalogue(Poisson()), *catalogue(Carl()), *catalogue(DECAYS), *catalogue(Alignment())):
        for shape in effect.shapes():
            assert shape.shape in words
            assert all(parameter.name in words for parameter in shape.parameters)


def test_list_of_a_task_shows_the_bounds(done):
    out = done("list", "--task", "poisson")
    assert "hybrid: tau from 0 to 1 of the window, prolonging from 0 to 1" in out
    assert "resolution" not in out
    assert done("list", "effects", "--task", "poisson") == out
    out = done("list", "--task", "carl")
    assert "each acts on one of x1, x2, x3, x4, x5, or on all alike; bounds are those for x1" in out
    assert "shift from -5.75 to 5.75 of the feature, absent at 0" in out


def test_list_shows_one_kind_or_all(done):
    parts = [done("list", kind).strip() for kind in ("tasks", "methods", "effects")]
    assert [part.split()[0] for part in parts] == ["tasks", "methods", "effects"]
    whole = done("list")
    assert whole.strip() == "\n\n".join(parts)
    assert all(len(line) <= ENDED for line in whole.splitlines())


def test_an_effect_is_checked_by_the_name_of_its_entry_point(done):
    assert done("check", "effect", "counts.dead_time").startswith("pass  says what it is (poisson)\n")
