import numpy as np
import pytest

from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.alignment import Alignment
from avobench.tasks.poisson import Poisson
from paper import effect_pictures
from paper.effect_pictures import View, draw


@pytest.mark.parametrize(("task", "name"), [(Poisson(), "dead_time"), (Alignment(), "inefficiency")])
def test_each_effect_has_a_picture(task, name, tmp_path, monkeypatch):
    some = [effect for effect in catalogue(task) if effect.name == name]
    monkeypatch.setattr(effect_pictures, "catalogue", lambda *_: some)
    monkeypatch.setattr(effect_pictures, "NUM_EVENTS", 2000)
    monkeypatch.setattr(effect_pictures, "NUM_IMAGES", 200)
    (path,) = draw(task, tmp_path)
    assert path.name == f"{task.name}-{name.replace('_', '-')}.png"
    assert path.read_bytes().startswith(b"\x89PNG")


def test_an_effect_is_drawn_at_a_strength_at_which_it_is_seen_and_is_no_caricature():
    view = View(Model(Poisson()), 2000)
    for shape in [shape for effect in catalogue(Poisson())[:2] for shape in effect.shapes()]:
        (_, before), (_, after) = view.shares(view.plain, 0), view.shares(view.middling(shape).x, 0)
        assert 0.02 < np.abs(after - before).sum() / 2 < 0.5, shape
