"""What a diagnosis says: the content of `diagnosis.json`, described in docs/diagnosis.md."""

from enum import StrEnum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

SCHEMA_VERSION = 1
"""Raised when a field of `diagnosis.json` changes its meaning."""


class Verdict(StrEnum):
    NOTHING = "no significant disagreement"
    NAMED = "missing effect named"
    REDUCED = "disagreement reduced, still significant"
    UNEXPLAINED = "disagreement not explained by the catalogue"


Feature = str | None
"""None where events have no features to choose from, "all" where an effect acts on all alike, else a feature's name, or
that of the parameter of the task that an effect acts on."""


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Gate(Strict):
    """A test of the simulator against the measurement, theta fitted."""

    statistic: float
    dof: int | None
    p_value: float


class Gap(Strict):
    """How far simulation is from measurement, on events that no fit has seen."""

    value: float
    low: float
    high: float
    unit: Literal["chi2/ndf"] = "chi2/ndf"


class Value(Strict):
    value: float
    std: float | None


class Combination(Strict):
    """A linear combination of theta, about its estimate, that the data determine."""

    coefficients: dict[str, float]
    """By parameter; the combination is the sum of their products with theta."""
    value: float
    std: float


class EffectValue(Strict):
    value: float
    std: float | None
    null: float | None
    unit: str


class Named(Strict):
    name: str
    feature: Feature


class FoundEffect(Named):
    shape: str = ""
    """Which of its shapes was fitted; empty where it has one."""
    parameters: dict[str, EffectValue]
    tied_with: list[Named]


class Region(Strict):
    feature: Feature
    low: float
    high: float
    kind: Literal["excess", "deficit"]
    z: float
    p_global: float


class Candidate(Named):
    score: float
    p_value: float
    held_out_gap: float | None


class Identifiable(Named):
    """What these data could show of an effect."""

    retained: float | None
    """Share of its signal that is left once theta is fitted."""
    minimum_detectable: float | None
    """The smallest strength seen with 90 % probability; None where no strength within its bounds is."""
    theta_bias: dict[str, float]
    """By how much theta moves if the effect is there, at that strength, and unseen."""
    rivals: list[Named]


class Diagnosis(Strict):
    schema_version: int = SCHEMA_VERSION
    verdict: Verdict
    alpha: float
    p_value_before: float
    p_value_after: float | None
    gates: dict[str, Gate]
    gap_before: Gap
    gap_after: Gap | None
    theta_before: dict[str, Value]
    theta_after: dict[str, Value] | None
    identified_before: list[Combination]
    identified_after: list[Combination] | None
    effects: list[FoundEffect]
    regions: list[Region]
    candidates: list[Candidate]
    identifiability: list[Identifiable]
    notes: list[str]
    """Sentences for a person: fits that ended at a bound, what so few events cannot show, a wide AVO proposal."""
    num_events: int
    num_simulations: int
    seconds: float
    seed: int
    versions: dict[str, Any]
