from paper.tables.decide import column


def test_what_was_said_to_decide_is_counted_by_what_was_found_anew():
    pair = {"true": ["a"], "rival": ["b"], "events": 1000}
    anew = {**pair, "named": ["b"], "best": ["a"], "models": [["a"], ["b"]]}
    asked = [pair | {"events": 0}, pair | {"events": None}, pair, anew, anew | {"named": ["a"], "models": [["a"]]}]
    said = column([{"truth": "a", "num_events": 2000, "asked": asked}])
    counts = {name.strip(): text.split(" (")[0] for name, text in said.items()}
    assert counts["pairs with the hidden family"] == "5"
    assert counts["no number is known"] == counts["enough are measured"] == "1"
    assert counts["the hidden one is first"] == "1 of 1"
    assert counts["times as many events, median"] == "1.5"
    assert [counts[f"{what}"] for what in ("the hidden one is named", "it has more evidence")] == ["1 of 2", "2 of 2"]
    assert counts["it is alone in the 95 % set"] == "1 of 2"
