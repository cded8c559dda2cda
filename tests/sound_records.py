"""Records as hypothesis makes them up: whatever a cell may leave behind, and nothing that it may not."""

import math
from collections.abc import Sequence
from typing import Any

from hypothesis import strategies as st

from avobench.bench.store.record import IDENTITY, identity_hash
from avobench.bench.store.status import ESTIMATED, LOST, Status

finite = st.floats(allow_nan=False, allow_infinity=False)
moderate = st.floats(-1e150, 1e150)  # so that a squared distance is finite
positive = st.floats(0, allow_infinity=False, exclude_min=True)
text = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
names = st.text("aZ09.-", min_size=1, max_size=20).map("x".__add__)
counts = st.integers(0, 2**62)
values = st.recursive(
    st.none() | st.booleans() | st.integers() | finite | text, lambda inner: st.lists(inner), max_leaves=4
)
settings = st.dictionaries(text, values, max_size=3)
sha256 = st.binary(min_size=32, max_size=32).map(bytes.hex)
spread = st.floats(0, allow_infinity=False) | st.none()
PLAIN = dict.fromkeys(("task", "method"), names) | dict.fromkeys(("task_settings", "method_settings"), settings)
PLAIN |= dict.fromkeys(("task_version", "method_version", "message"), text)
PLAIN |= dict.fromkeys(("target", "repetition"), st.integers(0, 200)) | {"seed": st.integers(0, 2**63 - 1)}
PLAIN |= {"num_observations": st.integers(1, 2**62), "floor": spread, "floor_likelihood": spread}
PLAIN |= {f"{part}_seconds": st.floats(0, 1e9) for part in ("observation", "simulator", "method", "harness")}
PLAIN |= {"peak_memory_mib": positive | st.none(), "started": st.none() | st.just("2026-11-21T20:40:54+00:00")}
PLAIN |= {"versions": st.dictionaries(text, text | st.none(), max_size=3)}
"""Fields that do not depend on each other."""
SELDOM = {"task_source_sha256": sha256, "method_source_sha256": sha256, "amortised": st.just(True)}


def vectors(p: int, of: st.SearchStrategy) -> st.SearchStrategy[list[Any]]:
    return st.lists(of, min_size=p, max_size=p)


@st.composite
def sound_records(draw: st.DrawFn, statuses: Sequence[Status] = tuple(Status)) -> dict[str, Any]:
    p, status, known = draw(st.integers(1, 3)), draw(st.sampled_from(statuses)), finite | st.none()
    budget = draw(st.integers(1, 2**62))
    used, refused = draw(st.integers(0, budget)), draw(counts)
    record = draw(st.fixed_dictionaries(PLAIN, optional=SELDOM)) | {
        "schema_version": 1,
        "status": str(status),
        "theta_true": draw(vectors(p, moderate)),
        "parameter_names": draw(st.lists(text, min_size=p, max_size=p, unique=True)),
        "budget": budget,
        **dict.fromkeys(["theta_hat", "squared_error", "how", "spread_of", "mean", "std"]),
        "trace": [],
        "simulations_requested": used + refused,
        "simulations_used": used,
        "simulations_discarded": draw(st.integers(0, used)),
        "simulations_refused": refused,
    }
    if status in LOST:
        record |= dict.fromkeys(name for name in record if name.startswith("simulations_"))
    if status in ESTIMATED:
        found = draw(vectors(p, moderate))
        differences = [a - b for a, b in zip(found, record["theta_true"], strict=True)]
        points = sorted(draw(st.lists(st.integers(0, used), max_size=3)))
        record |= {
            "theta_hat": found,
            "squared_error": math.fsum(difference**2 for difference in differences),
            "how": draw(text),
            "spread_of": draw(st.sampled_from(["posterior", "proposal"])),
            "mean": draw(vectors(p, known)),
            "std": draw(vectors(p, spread)),
            "trace": [
                {"simulations": n, "theta": draw(vectors(p, known)), "std": draw(st.none() | vectors(p, spread))}
                for n in points
            ],
        }
        if draw(st.booleans()):
            record["standard_error"] = draw(vectors(p, spread))
    return identified(record)


def identified(record):
    """The record with the id of the fields that it stands for."""
    return {**record, "id": identity_hash({name: record[name] for name in IDENTITY if name in record})}
