from avobench.speed.diagnosis import HIDDEN, measure


def test_a_row_tells_what_a_diagnosis_took_and_that_it_was_right():
    row = measure("poisson", 2000, 0.2)
    assert row["named"] == HIDDEN["poisson"][0]
    assert (row["events"], row["effects"]) == (2000, 2)
    assert row["seconds"] > 0
    assert row["simulated"] > 2000
