from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
from measurements import Own, entry
from pydantic.errors import PydanticSchemaGenerationError

from avobench.bench.plugins import registry
from avobench.diagnosis.report.model_file import describe, kept
from avobench.effects.catalogue import catalogue, chosen
from avobench.effects.model import Model
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.errors import UsageError
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg


def reread(model, params, path, name):
    """The task that is read from the model file of a fit at these parameters."""
    fit = SimpleNamespace(model=model, params=np.array(params))
    path.write_text(describe(fit, np.full(model.dim, 0.1), name, {}).model_dump_json())
    return registry.read_model(str(path))


def require_kept(task, shape, path):
    model = Model(task, (shape,))
    assert reread(model, model.from_cube(np.full(model.dim, 0.5)), path, task.name).model.effects == (shape,)


@pytest.mark.parametrize("task", [Poisson(), Weinberg(), Carl(), Alignment()], ids=lambda task: task.name)
def test_a_model_file_keeps_what_the_data_decided_of_an_effect(task, tmp_path):
    if task.event_shape:
        x = np.zeros((400, 32 * 32), bool)
        x[:, :40] = x[:, 64:94] = True  # rows, some cells of which are dead, or alone alive
    else:
        x = task.simulate(
            np.tile(np.mean([task.prior.low, task.prior.high], axis=0), (2000, 1)), np.random.default_rng(0)
        )
        x[:1200] = np.round(x[:1200], 1)  # of which some effects read steps and limits
    for effect in {type(effect): effect for effect in reversed(catalogue(task))}.values():  # the first of each class
        for shape in effect.adapted(x).shapes():
            require_kept(task, shape, tmp_path / "model.json")


@pytest.mark.parametrize("name", ["truncation", "censoring", "analysis_window"])
def test_a_model_file_keeps_where_the_data_end(name, tmp_path):
    task = Weinberg()
    x = task.simulate(np.tile(task.prior.center, (9000, 1)), np.random.default_rng(0))
    x = np.minimum(x[x[:, 0] > -0.7], 0.8) if name == "censoring" else x[np.abs(x[:, 0]) < 0.7]
    adapted = chosen(catalogue(task), [name], task.name)[0].adapted(x)
    assert adapted != adapted.adapted(np.random.default_rng(0).standard_normal((9000, 1)))  # that shows no ends
    for shape in adapted.shapes():
        require_kept(task, shape, tmp_path / "model.json")


def test_a_file_of_an_effect_that_does_not_exist_or_of_no_model_is_refused(tmp_path):
    path, model = tmp_path / "model.json", Model(Poisson(), (catalogue(Poisson())[0],))
    content = describe(SimpleNamespace(model=model, params=model.low), model.high, "poisson", {})
    for change in ({"shape": "round"}, {"name": "gremlins"}, {"settings": {"colour": "red"}}):
        effects = [content.effects[0].model_copy(update=change)]
        path.write_text(content.model_copy(update={"effects": effects}).model_dump_json())
        with pytest.raises(UsageError, match="does not apply to poisson"):
            registry.build("task", str(path), {})
    path.write_text("{}")
    with pytest.raises(UsageError, match="is not a model"):
        registry.build("task", str(path), {})


def test_the_model_of_a_model_makes_the_events_that_were_fitted(tmp_path):
    """An effect that was found later comes after all of the model before, and one may be found again."""
    task, at = Weinberg(), [45.5, 1.0]
    for name, phi in (("quantisation", [0.3]), ("resolution", [0.2]), ("resolution", [0.1])):
        effect = entry(task, name)
        model, at = Model(task, (effect,)), [*at, *phi, *(p.high for p in effect.parameters[1:])]
        task = reread(model, at, tmp_path / "model.json", "weinberg")
    assert len(set(task.parameter_names)) == len(at)
    fitted, kept = (each.simulate(np.tile(at, (500, 1)), np.random.default_rng(0)) for each in (model, task))
    np.testing.assert_array_equal(fitted, kept)
    assert len(np.unique(kept)) == 500


@dataclass(frozen=True)
class Table(Own):
    """Of an unusual type, as a user's field may be."""

    table: np.ndarray = field(default_factory=lambda: np.zeros(3))


def test_a_file_keeps_what_follows_the_data_or_says_that_it_cannot(monkeypatch):
    monkeypatch.setattr(registry, "effect", lambda source: Table())
    assert kept(Table(), Poisson(), "mod:Table", Table()).settings == {}
    with pytest.raises(PydanticSchemaGenerationError, match="ndarray"):
        kept(Table(np.ones(3)), Poisson(), "mod:Table", Table())
