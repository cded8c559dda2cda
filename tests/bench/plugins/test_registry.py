"""What a spec may name, where it is found, and what of a user's file identifies a result."""

import subprocess
import sys

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from avobench.bench.cells.cell import Cell
from avobench.bench.plugins import registry, user_files
from avobench.bench.store.store import Store
from avobench.effects import Effect
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.function import task

FILE = '''
"""Two tasks, a method and an effect of a user's."""

from dataclasses import dataclass
from functools import partial

import numpy as np

import avobench
from avobench.effects import Effect, Parameter
from avobench.methods import Estimate, Method
from avobench.tasks import Box, Task

SHIFT = 0.5
WIDTH = {"first": 1.0}
WIDTH["first"] = 2.0
UNUSED = 3


def shifted(theta):
    return theta + offset()


def offset():
    return SHIFT


class Common(Task):
    parameter_names = ("location",)
    parameter_units = ("1",)
    source = "test"
    prior = Box((-1,), (1,))
    support = Box((-9,), (9,))
    num_features = 1

    def summary(self, x):
        return x.mean(axis=0)

    def floor(self, theta, num_observations, num_simulations):
        return np.nan


@dataclass(frozen=True)
class First(Common):
    name = "first"
    scale: float = 1.0

    def simulate(self, theta, rng):
        self.require_support(theta)
        return rng.normal(shifted(theta), self.scale * WIDTH["first"])


class Second(Common):
    name = "second"

    def simulate(self, theta, rng):
        return rng.exponential(np.exp(theta))


class Middle(Method):
    name = "middle"
    source = "test"

    def min_simulations(self, num_parameters):
        return 10

    def infer(self, problem, rng):
        problem.simulate(problem.prior.sample(10, rng))
        theta = problem.prior.center
        return Estimate(theta, "middle", "posterior", theta, np.full(len(theta), 0.5))


class Extra(Effect):
    name = "extra"
    parameters = (Parameter("rate", 0, 2, 0, "1"),)
    sentence = "Something is added."
    source = "test"

    def apply(self, simulate, theta, phi, rng):
        return simulate(theta, rng) + rng.exponential(phi)


def falling(theta, rng):
    return rng.exponential(offset() + np.exp(theta[:, 0]))


made = avobench.task(falling, prior={"log_rate": (0, 1)})
extra = Extra()
'''


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "of a user" / "their.tasks.py"
    path.parent.mkdir()
    path.write_text(FILE)
    return path


def test_tasks_methods_and_effects_are_found_in_a_file(file, monkeypatch):
    assert registry.build("task", f"{file}:First", {"scale": "3"}).scale == 3
    assert registry.load("method", f"{file}:Middle").name == "middle"
    assert isinstance(registry.effect(f"{file}:Extra"), Effect)
    monkeypatch.chdir(file.parent)
    assert registry.load("task", f"{file.name}:Second") is registry.load("task", f"{file}:Second")


def test_a_ready_made_task_is_taken_as_it_is(file):
    task = registry.build("task", f"{file}:made", {})
    assert (task.name, task.parameter_names) == ("falling", ("log_rate",))
    with pytest.raises(UsageError, match="is ready-made; its settings are in"):
        registry.build("task", f"{file}:made", {"scale": 2})


def test_files_of_one_name_in_two_folders_are_two_modules(file, tmp_path):
    other = tmp_path / file.name
    other.write_text(FILE.replace('name = "second"', 'name = "other"'))
    names = [registry.load("task", f"{path}:Second").name for path in (file, other)]
    assert names == ["second", "other"]


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("{file}:Frist", "their.tasks.py has no 'Frist'; did you mean First"),
        ("{file}:nq", "their.tasks.py has no 'nq'$"),
        ("{file}:falling", r"is a function; write NAME = avobench.task\(falling, prior"),
        ("{file}:Middle", "is not a subclass of avobench.tasks.Task, nor an instance of one"),
        ("{file}:UNUSED", "is not a subclass of avobench.tasks.Task"),
        ("{file.parent}/none.py:First", "there is no file '.*none.py', for task"),
        ("{file}:Common", "does not define name, simulate"),
    ],
)
def test_what_is_not_there_is_said_in_a_line(file, spec, said):
    with pytest.raises(UsageError, match=said) as raised:
        registry.load("task", spec.format(file=file))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("kind", "name"), [("task", "First"), ("task", "made"), ("effect", "Extra"), ("effect", "extra")]
)
def test_an_object_of_a_file_tells_where_it_is_found(file, kind, name):
    spec = f"{file}:{name}"
    instance = registry.effect(spec) if kind == "effect" else registry.build(kind, spec, {})
    assert registry.spec_of(kind, instance) == spec
    assert registry.spec_of("task", registry.build("task", "poisson", {})) == "poisson"


def test_a_sweep_of_two_processes_runs_a_file_named_from_its_own_folder(file):
    command = [sys.executable, "-m", "avobench", "run", "--task", "their.tasks.py:First", "--task"]
    command += ["their.tasks.py:made", "--method", "their.tasks.py:Middle", "--targets", "0-1", "--budget", "20"]
    command += ["--observations", "100", "--jobs", "2", "--results", "r"]
    done = subprocess.run(command, cwd=file.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "4 of 4 cells ok" in done.stdout
    cell = Cell(f"{file}:First", {}, f"{file}:Middle", {}, 0, 0, 20, 100, 0)
    assert cell.id in {record["id"] for record in Store(file.parent / "r").read_all()}


@given(st.text(st.characters(exclude_characters="\0/", exclude_categories=["Cs"]), min_size=1))
def test_a_module_s_name_tells_its_path(name):
    path = f"/some where/{name}.py"
    module = user_files.module_name(path)
    assert "." not in module.removeprefix(user_files.PREFIX)
    assert user_files.file_of(module) == path
    assert user_files.file_of("avobench.bench.plugins.registry") is None


def test_specs_are_made_absolute_as_far_as_they_are_paths(file, monkeypatch):
    monkeypatch.chdir(file.parent)
    assert registry.absolute("their.tasks.py:First") == f"{file}:First"
    assert registry.absolute("model.json") == str(file.parent / "model.json")
    assert isinstance(registry.absolute(registry.trusted("model.json")), registry.Trusted)
    for spec in ("poisson", "toys:Normal"):
        assert registry.absolute(spec) == spec


# What identifies a class of a user's file.


def identity_of(folder, text, name="First", kind="task"):
    """The identity of a class in a new file with this text."""
    path = folder / f"variant_{len(list(folder.iterdir()))}.py"
    path.write_text(text)
    spec = f"{path}:{name}"
    return registry.identity(kind, spec, registry.build(kind, spec, {}))


ITS_OWN = (
    ("self.scale * WIDTH", "2 * self.scale * WIDTH"),  # the class itself
    ("return theta + offset()", "return theta - offset()"),  # a function that it uses
    ("return SHIFT", "return -SHIFT"),  # one that this uses
    ("SHIFT = 0.5", "SHIFT = 0.6"),  # a constant that this uses
    ('WIDTH["first"] = 2.0', 'WIDTH["first"] = 2.5'),  # one that is changed after it was made
    ("Box((-1,), (1,))", "Box((-1,), (2,))"),  # a base class
    ("@dataclass(frozen=True)\nclass First", "@dataclass(frozen=True, eq=False)\nclass First"),  # a decorator
)
NOT_ITS_OWN = (
    ("rng.exponential(np.exp(theta))", "rng.exponential(theta**2)"),  # another class
    ("UNUSED = 3", "UNUSED = 4"),
    ('"""Two tasks', '"""Some tasks'),
    ("rng.exponential(phi)", "rng.exponential(2 * phi)"),
    ("from functools import partial\n", ""),
    ("extra = Extra()\n", "extra = Extra()\nmore = print\n"),
)


@pytest.mark.parametrize(("old", "new"), ITS_OWN)
def test_an_edit_of_what_a_class_uses_is_another_identity(tmp_path, old, new):
    assert FILE.count(old) == 1
    assert identity_of(tmp_path, FILE) != identity_of(tmp_path, FILE.replace(old, new))


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(edits=st.lists(st.sampled_from(NOT_ITS_OWN), unique=True), place=st.sampled_from(["", "\n\n# a remark\n"]))
def test_edits_of_anything_else_in_the_file_are_none(tmp_path, edits, place):
    text = place + FILE
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    assert identity_of(tmp_path, FILE) == identity_of(tmp_path, text)


def test_a_task_of_a_function_is_identified_by_the_function_and_what_it_uses(tmp_path):
    plain = identity_of(tmp_path, FILE, "made")
    own = (("np.exp(theta[:, 0])", "theta[:, 0] ** 2"), ("SHIFT = 0.5", "SHIFT = 0.6"), ("(0, 1)}", "(0, 2)}"))
    for old, new in (*own, *NOT_ITS_OWN):
        assert FILE.count(old) == 1
        assert (identity_of(tmp_path, FILE.replace(old, new), "made") == plain) == ((old, new) not in own)


def test_a_base_class_of_another_file_of_the_user_s_counts(tmp_path):
    found = []
    for text in (FILE, FILE.replace("np.exp(theta))", "theta**2)"), FILE.replace("SHIFT = 0.5", "SHIFT = 0.6")):
        folder = tmp_path / str(len(found))
        folder.mkdir()
        (folder / "their_base.py").write_text(text)
        (folder / "derived.py").write_text("from their_base import Second\nclass Third(Second):\n    name = 'third'\n")
        spec = f"{folder / 'derived.py'}:Third"
        found.append(registry.identity("task", spec, registry.build("task", spec, {}))["task_source_sha256"])
        del sys.modules["their_base"]
        sys.path.remove(str(folder))
    assert found[0] == found[2] != found[1]


HOLDING = """
import functools, os, threading
from typing import NamedTuple
import numpy as np
import avobench
from avobench.methods import Method
from avobench.tasks import Box, Task

SIGMA = float(os.environ["SIGMA"])

def made(sigma):
    def simulate(theta, rng, times=sigma):
        return theta[:, 0] + times * sigma * rng.normal(size=len(theta))
    def again(theta, rng):
        return again.first(theta, rng) if theta is None else simulate(theta, rng)
    again.first = again
    return again

def narrow(theta, rng):
    return theta[:, 0] + rng.normal(size=len(theta))

def wide(theta, rng):
    return theta[:, 0] + 2 * rng.normal(size=len(theta))

def chosen(theta, rng, simulators, table=None):
    return simulators[0](theta, rng)

class Detector:
    def __init__(self, sigma):
        self.sigma, self.lock, self.itself = sigma, threading.Lock(), self

    @functools.cached_property
    def table(self):
        return np.zeros(3)

    def simulate(self, theta, rng):
        return theta[:, 0] + self.sigma * rng.normal(size=len(theta))

class Point(NamedTuple):
    sigma: float

    def __call__(self, theta, rng):
        return theta[:, 0] + self.sigma * rng.normal(size=len(theta))

class Own(Task):
    name, parameter_names, parameter_units, source, num_features = "own", ("mu",), ("1",), "x", 1
    prior = support = Box((-2.0,), (2.0,))

    def __init__(self, sigma):
        self.sigma = sigma

    def simulate(self, theta, rng):
        return theta + self.sigma * rng.normal(size=theta.shape)

    def summary(self, x):
        return x.mean(axis=0)

class Fixed(Method):
    name, source = "fixed", "x"

    def __init__(self, sigma):
        self.sigma = sigma

    def min_simulations(self, num_parameters):
        return 1

    def infer(self, problem, rng):
        raise NotImplementedError

task = functools.partial(avobench.task, prior={"mu": (-2, 2)}, name="it")
table = np.zeros(5000)
table[2500] = SIGMA
closure = task(made(SIGMA))
bound = task(Detector(SIGMA).simulate)
held = task(functools.partial(chosen, simulators=[Detector(SIGMA).simulate]))
code = task(functools.partial(chosen, simulators={0: narrow if SIGMA == 1 else wide}))
cached = task(functools.partial(chosen, simulators=[narrow, functools.cache(made(SIGMA))]))
point = task(Point(SIGMA))
array = task(functools.partial(chosen, simulators=[narrow], table=table))
loop = [task(lambda theta, rng, sigma=sigma: theta[:, 0] + sigma) for sigma in (SIGMA, 9.0)][0]
own, fixed = Own(SIGMA), Fixed(SIGMA)
detector = Detector(SIGMA)
lazy = task(detector.simulate)
"""
HOLDS = ("closure", "bound", "held", "code", "cached", "point", "array", "loop", "own", "fixed")


def test_values_that_functions_and_objects_hold_identify_them(tmp_path, monkeypatch):
    def found(sigma):
        monkeypatch.setenv("SIGMA", str(sigma))
        return [identity_of(tmp_path, HOLDING, name, "method" if name == "fixed" else "task") for name in HOLDS]

    first = found(1)
    assert found(1) == first
    assert [name for name, one, other in zip(HOLDS, first, found(2), strict=True) if one == other] == []
    specs = [f"{tmp_path / 'variant_0.py'}:{name}" for name in HOLDS[:-1]]
    code = "from avobench.bench.plugins import registry as r; "
    code += f"print([r.identity('task', spec, r.build('task', spec, {{}})) for spec in {specs}])"
    monkeypatch.setenv("SIGMA", "1")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == str(first[:-1]), done.stderr


def test_values_that_change_are_read_again_but_not_those_that_are_derived(tmp_path, monkeypatch):
    monkeypatch.setenv("SIGMA", "1")
    before = identity_of(tmp_path, HOLDING, "lazy")
    module = sys.modules[user_files.module_name(tmp_path / "variant_0.py")]
    detector, spec = module.detector, f"{tmp_path / 'variant_0.py'}:lazy"
    assert detector.table.sum() == 0
    assert registry.identity("task", spec, module.lazy) == before
    detector.sigma = 3.0
    assert registry.identity("task", spec, module.lazy) != before


TYPED = """
import linecache, sys, avobench
from avobench.bench.plugins import registry
code = f"shift = {sys.argv[1]}\\n\\ndef simulate(theta, rng):\\n    return rng.normal(theta[:, 0]) + shift\\n"
linecache.cache["<cell 1>"] = (len(code), None, code.splitlines(True), "<cell 1>")
exec(compile(code, "<cell 1>", "exec"))
print(registry.identity("task", "made", avobench.task(simulate, prior={"a": (0, 1)}))["task_source_sha256"])
"""
"""A function that is typed at a prompt, whose text IPython keeps like this."""


def test_what_has_no_file_is_identified_by_the_values_that_it_uses():
    one, again, other = (
        subprocess.run([sys.executable, "-c", TYPED, shift], capture_output=True, text=True, check=True).stdout
        for shift in "112"
    )
    assert one == again != other


@pytest.mark.parametrize("kind", ["task", "method", "effect"])
def test_our_own_names_are_those_of_the_classes(kind):
    """Or, where several effects are of one family and share its name, those of the classes themselves."""
    for name in registry.names(kind):
        loaded, last = registry.load(kind, name), name.rpartition(".")[2]
        assert last == loaded.name or last.replace("_", "") == loaded.__name__.lower()
    assert isinstance(registry.build("task", "poisson", {}), Task)


def test_a_class_is_no_name_of_what_it_does_not_make(file):
    """Else a model would be read with another effect than the one that was found."""
    made = registry.effect(f"{file}:Extra")
    made.centre = 3.0
    assert registry.spec_of("effect", made) is None


def test_a_task_of_a_function_that_no_module_knows_has_no_name_but_settings():
    """So it is at a prompt, where a function has no source either: its class alone would not make it again."""
    scope = {}
    exec("def simulate(theta, rng):\n    return rng.exponential(theta[:, 0])", scope)
    decay = task(scope["simulate"], prior={"lifetime": (1, 4)})
    assert registry.spec_of("task", decay) is None
    assert registry.settings_of(decay) == {}
