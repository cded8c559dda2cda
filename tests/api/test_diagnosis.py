"""What a diagnosis shows and keeps."""

import numpy as np
import pytest

import avobench


def simulate(theta, rng):
    phase = rng.uniform(0, 1, len(theta))
    return np.stack([phase, rng.normal(theta[:, 0], 1)], axis=1)


@pytest.fixture(scope="module")
def found():
    """An excess in the second of two features."""
    task = avobench.task(simulate, prior={"mean": (-1, 1)}, features=["phase", "log_energy"], name="burst")
    x = simulate(np.full((4000, 1), 0.2), np.random.default_rng(3))
    x[:400, 1] = np.random.default_rng(4).normal(2.5, 0.1, 400)
    return avobench.diagnose(task, x, simulations=3_000_000, effects=["peak_background"])


def test_the_picture_is_of_the_feature_on_which_the_effect_is(found):
    assert found.diagnosis.effects[0].feature == "log_energy"
    assert "log_energy" in [axis.get_xlabel().split(" ")[0] for axis in found.plot().axes]


def test_a_title_that_is_no_text_is_written_all_the_same(found, tmp_path):
    with pytest.warns(UserWarning, match=r"no model\.json"):
        found.save(tmp_path, title=b"caf\xe9.csv".decode(errors="surrogateescape"))
    assert "caf?.csv" in (tmp_path / "report.html").read_text()
    assert (tmp_path / "diagnosis.json").exists()
