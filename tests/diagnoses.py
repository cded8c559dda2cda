"""A diagnosis with some fields given, for tests of what is made of one."""

from avobench.diagnosis.schema import Diagnosis, Verdict

GAP = {"value": 1.1, "low": 0.6, "high": 1.6}


def diagnosis(verdict=Verdict.NOTHING, **given):
    """What no field is given of is empty; with a verdict that names effects there is an agreement after them."""
    added = verdict in (Verdict.NAMED, Verdict.FAMILY)
    content = {
        "verdict": verdict,
        "alpha": 0.05,
        "p_value_before": 1e-9,
        "p_value_after": 0.4 if added else None,
        "gates": {},
        "gap_before": GAP,
        "gap_after": GAP if added else None,
        "theta_before": {},
        "theta_after": None,
        "identified_before": [],
        "identified_after": [] if added else None,
        **{name: [] for name in ("effects", "regions", "candidates", "identifiability", "notes")},
        "num_events": 1000,
        "num_simulations": 1000,
        "seconds": 1.0,
        "seed": 0,
        "versions": {},
    }
    return Diagnosis.model_validate({**content, **given})
