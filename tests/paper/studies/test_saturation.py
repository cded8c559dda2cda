"""The study of saturation looks at each discriminator when it says so."""

from paper.studies import saturation as study


def test_a_discriminator_is_looked_at_on_its_way(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "NUM_OBSERVATIONS", 1000)
    record = study.made(tmp_path / study.FILE.name, iterations=(0, 2), num_targets=1)
    assert study.read(tmp_path) == record
    for run in record["runs"]:
        assert 0 < run["largest"][0] < run["largest"][1]  # an untrained network says next to nothing
        assert run["share"][0] == 0
    assert study.table([record])["no gradient"].tolist()[::2] == [0, 0]
