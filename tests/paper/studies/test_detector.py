"""The average response of the detector."""

import numpy as np
import pytest

from paper.studies import detector


def test_the_response_is_made_once(tmp_path, monkeypatch):
    path = tmp_path / detector.FILE.name
    record = detector.made(path, num_events=60)
    for response in record["responses"]:
        mean = np.array(response["mean"])
        assert mean.shape == (1024,)
        np.testing.assert_allclose(mean * 60, np.round(mean * 60))
        assert [bool(event) for event in response["events"]] == [True] * 3
        assert (mean[np.unique(np.concatenate(response["events"]))] > 0).all()
    assert record["responses"][0]["events"] != record["responses"][1]["events"]
    monkeypatch.setattr(detector.Alignment, "simulate", None)
    assert detector.made(path, num_events=60) == record == detector.read(tmp_path)
    with pytest.raises(TypeError):  # other events would have to be simulated
        detector.made(path, num_events=61)
