"""What the study of stillness counts."""

from paper.studies.stillness import row


def test_a_small_network_does_not_saturate_at_once():
    counted = row({"hidden": [8], "r1_of": "logit"}, iterations=5)
    assert counted["iterations"] == 5
    assert counted["largest logit at the end"] < 17
    assert [counted[name] for name in ("d saturated", "R1 of d is 0", "log(1 - d) is 0", "still")] == [0, 0, 0, 0]


def test_a_rate_far_too_high_saturates_and_is_told():
    counted = row({"hidden": [8], "learning_rate": 100.0}, iterations=5)
    assert counted["d saturated"] > 0
    assert counted["R1 of d is 0"] > 0
