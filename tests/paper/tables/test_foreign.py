"""What is said of cases of others is judged by what was written down before."""

import pytest

from avobench.diagnosis.schema import Verdict
from paper.tables.foreign import judged, of_truth


def effect(label, *tied):
    name, _, feature = label.partition(" on ")
    return {"name": name, "feature": feature or None, "tied_with": [effect(other) for other in tied]}


def record(right, effects=(), verdict=Verdict.NAMED, models=()):
    models = [{"effects": [effect(label) for label in labels], "probability": share} for labels, share in models]
    diagnosis = {"verdict": verdict, "effects": list(effects), "models": models}
    return {"right": right, "defensible": ["mixture"], "diagnosis": diagnosis}


@pytest.mark.parametrize(
    ("right", "effects", "verdict", "answer"),
    [
        ([], [], Verdict.NOTHING, "no alarm"),
        ([], [], Verdict.UNEXPLAINED, "wrong"),
        (["offset"], [], Verdict.NOTHING, "not seen"),
        (["offset"], [], Verdict.UNEXPLAINED, "no name"),
        (["offset"], [effect("offset on mz")], Verdict.NAMED, "right"),
        (["offset on mz"], [effect("offset on mz")], Verdict.NAMED, "right"),
        (["offset on mz"], [effect("offset on time")], Verdict.NAMED, "wrong"),
        (["offset"], [effect("scale"), effect("offset")], Verdict.NAMED, "defensible"),
        (["offset"], [effect("scale", "offset on mz")], Verdict.NAMED, "defensible"),
        (["offset"], [effect("mixture")], Verdict.NAMED, "defensible"),
        (["offset"], [effect("scale"), effect("mixture")], Verdict.NAMED, "wrong"),
    ],
)
def test_a_diagnosis_is_judged(right, effects, verdict, answer):
    assert judged(record(right, effects, verdict)) == answer


def test_only_the_right_effect_alone_is_the_truth():
    models = [(["scale"], 0.4), (["offset", "scale"], 0.3), (["offset"], 0.15), (["shift"], 0.1)]
    assert of_truth(record(["offset", "shift"], models=models)) == pytest.approx(0.25)
    assert of_truth(record(["saturation"], models=models)) is None
