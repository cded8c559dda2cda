"""What every seen shape keeps: size, type and seed of events, whatever it does not act on; and it changes something."""

import numpy as np
import pytest

from avobench.challenge.shape import Place
from avobench.effects.catalogue import catalogue
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.decays import DECAYS
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg
from shapes.counts import COUNTS
from shapes.images import IMAGES
from shapes.response import RESPONSE
from shapes.selection import SELECTION


def place(task, theta, feature, n=2_000):
    at = np.tile(np.array(theta, float), (n, 1))
    return Place(task, feature, task.simulate(at, np.random.default_rng(99))), at


WHERE = {
    "few counts": place(Poisson(), [np.log(1.5)], 0),
    "many counts": place(Poisson(), [np.log(6.0)], 0),
    "a cosine": place(Weinberg(), [44, 1], 0),
    "one feature": place(Carl(), [0.5, -0.5], 1),
    "a time": place(DECAYS, [2.0], 0),
    "all features": place(Carl(), [0.5, -0.5], "all"),
    "the event": place(Carl(), [0.5, -0.5], None),
    "a parameter": place(Carl(), [0.5, -0.5], "beta"),
    "images": place(Alignment(), [0.4], None, 100),
}
LIBRARIES = {"counts": COUNTS, "images": IMAGES, "continuous": RESPONSE, "selected": SELECTION}
EVERY = [
    pytest.param(where, shape, id=f"{shape.name} of {where}")
    for library in LIBRARIES.values()
    for where, (there, _) in WHERE.items()
    for shape in library.shapes
    if shape.suits(there)
]


@pytest.mark.parametrize(("name", "shape"), EVERY)
def test_a_shape_keeps_size_type_and_seed_and_changes_something(request, name, shape):
    where, at = WHERE[name]
    if where.kind == "images":
        where = request.getfixturevalue("tracker")
    injection = shape.draw(where, np.random.default_rng(3)).stronger(1e9)
    x, same, other = (injection.measure(where.task.simulate, at, np.random.default_rng(seed)) for seed in (1, 1, 2))
    before = where.task.simulate(at, np.random.default_rng(1))
    assert (x.shape, x.dtype) == (before.shape, where.task.dtype)
    np.testing.assert_array_equal(x, same)
    assert np.isfinite(x).all()
    assert not any(np.allclose(x, each) for each in (other, before))
    assert np.abs(x).max() <= 1 or not (where.cosine or where.kind == "images")
    assert x.min() >= 0 or where.kind not in ("counts", "images")
    none = injection.measure(lambda theta, rng: before[:0].copy(), at[:0], np.random.default_rng(1))
    assert none.shape == before[:0].shape
    if shape.stage != 3:  # a selection exchanges whole events
        np.testing.assert_array_equal(*(np.delete(each, where.columns, axis=1) for each in (x, before)))


@pytest.mark.parametrize("name", LIBRARIES)
def test_shapes_have_names_of_their_own_families_of_the_catalogue_and_a_place_among_their_kind_of_events(name):
    shapes, tasks = LIBRARIES[name].shapes, {each.task.name: each.task for each, _ in WHERE.values()}
    suited = [where for where, _ in WHERE.values() if any(shape.suits(where) for shape in shapes)]
    assert {where.kind for where in suited} == {"continuous" if name == "selected" else name}
    assert all(any(shape.suits(where) for where in suited) for shape in shapes)
    assert {shape.family for shape in shapes} <= {effect.name for task in tasks.values() for effect in catalogue(task)}
    assert len({shape.name for shape in shapes}) == len({shape.sentence for shape in shapes}) == len(shapes)
    assert all(shape.sentence.endswith(".") for shape in shapes)
