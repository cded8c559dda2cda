"""The notebooks of `examples/` run from top to bottom, and say what their text says they do."""

import ast
import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

FEWER = "import avobench, functools\navobench.infer = functools.partial(avobench.infer, budget={})"
"""Before a notebook: fewer events than its inferences would take."""
EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def run():
    """Executes a notebook by its name, then an expression, and gives its cells."""

    def cells(name, expression, budget):
        notebook = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
        notebook.cells.insert(0, nbformat.v4.new_code_cell(FEWER.format(budget)))
        notebook.cells.append(nbformat.v4.new_code_cell(expression))
        NotebookClient(notebook, timeout=None, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
        return notebook.cells

    return cells


def shown(cells, kind):
    """What the cells show in one form, such as "image/png" or "text/html"."""
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    return [output["data"][kind] for output in outputs if kind in output.get("data", {})]


def test_a_simulator_of_ones_own_is_fitted_and_shows_its_uncertainty(run):
    cells = run("fit-your-own-simulator", "fitted.theta", 52_000)
    theta = ast.literal_eval(shown(cells, "text/plain")[-1])
    assert theta["asymmetry"] == pytest.approx(0.25, abs=0.05)
    assert theta["steep"] == pytest.approx(0.4, abs=0.05)
    tables = [html for html in shown(cells, "text/html") if "asymmetry" in html]
    assert len(tables) == 2  # of each method one
    assert len(shown(cells, "image/png")) == 1


def test_the_effect_that_a_simulator_lacks_is_named_and_with_it_the_rate_is_right(run):
    cells = run("find-what-is-missing", "{'misled': misled.theta['rate'], 'mended': mended.theta['rate']}", 20_000)
    (text,) = [text for text in shown(cells, "text/plain") if text.startswith("missing effect named")]
    found = re.search(r"^missing: dead_time .*tau = (\S+) ± (\S+) of the window", text, re.M)
    tau, std = map(float, found.groups())
    assert abs(tau - 0.02) < 3 * std < tau
    rate = ast.literal_eval(shown(cells, "text/plain")[-1])
    assert rate["misled"] < 10
    assert rate["mended"] == pytest.approx(12, abs=0.6)
    assert len(shown(cells, "image/png")) == 1
