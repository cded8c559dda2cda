"""The tables of ALEPH are of what the events of the example have."""

import aleph
import numpy as np
import pytest


def test_an_event_has_an_entry_in_each_shape_and_one_a_particle_in_each_spectrum():
    """Two events, of three and four particles within the bins of all tables."""
    momentum = np.random.default_rng(1).normal(scale=[2, 2, 8], size=(7, 3))
    events = aleph.Events(np.array([3, 4]), momentum, np.full(7, 0.14))
    tables = aleph.aleph_tables()
    sums = {t.name.split()[0]: t.entries(events).sum(axis=1).tolist() for t in tables}
    assert len(sums) == 15
    assert {name for name, found in sums.items() if found == [3, 4]} >= {"10", "11", "12", "19"}
    assert all(found == [1, 1] for name, found in sums.items() if name in ("1", "2", "3", "4", "6", "7", "8"))
    multiplicity = next(t for t in tables if t.name.startswith("18 "))
    assert multiplicity.entries(events).toarray()[:, 0].tolist() == [1, 1]
    assert tables.predict(aleph.Reduced.of(tables, events).mean)[-1] == pytest.approx(3.5)
