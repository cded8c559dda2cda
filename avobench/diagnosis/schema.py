"""What a diagnosis says: the content of `diagnosis.json`, described in docs/diagnosis.md."""

from enum import StrEnum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

SCHEMA_VERSION = 3
"""Raised when a field of `diagnosis.json` changes its meaning."""


class Verdict(StrEnum):
    NOTHING = "no significant disagreement"
    NAMED = "missing effect named"
    FAMILY = "missing effect of a known family, in a shape that the catalogue lacks"
    UNEXPLAINED = "disagreement not explained by the catalogue"


Feature = str | None
"""The name of a feature, or of the parameter of the task that an effect acts on. It is "all" where an effect acts on
all alike, and None where events have no features to choose from."""


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class GateResult(Strict):
    """A test of the simulator against the measurement, theta fitted."""

    statistic: float
    dof: int | None
    p_value: float
    share: float = 1.0
    """The share of alpha with which the p-value is compared."""
    sides: Literal[1, 2] = 1
    """One if only a large statistic speaks against the model, two if a small one does as well."""

    @property
    def corrected(self) -> float:
        """The p-value over its share of alpha, which is compared with alpha itself."""
        return min(self.p_value / self.share, 1.0)


class Gap(Strict):
    """The distance of simulation from measurement, on held-out events."""

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
    """The coefficient of each parameter; the combination is the sum of their products with theta."""
    value: float
    std: float


class EffectValue(Value):
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
    probability: float | None = None
    """The probability of being in the model; None where the search gives none."""


class Probable(Named):
    probability: float
    """The probability of being in the model."""


class ProbableModel(Strict):
    """A set of effects, none for the simulator as it is, and how probable it is that it is the model."""

    effects: list[Named]
    probability: float


class Place(Strict):
    """An interval of a feature, or how features go together."""

    feature: Feature
    """That of a dependence is "a and b" for two features, and "all" for what all have in common."""
    low: float | None
    """None, as `high` is, for a dependence, and for events that lack the feature."""
    high: float | None
    kind: Literal["excess", "deficit", "dependence"]
    unit: str = "1"


class Region(Place):
    """Where measurement and simulation disagree."""

    z: float
    """Of a dependence it is positive where features go together more than in the simulation."""
    p_global: float
    """Two-sided: of a region that disagrees as much, anywhere."""


class Decision(Strict):
    """How many more measured events would tell two models of the 95 % set apart, if one of them is true."""

    true: list[Named]
    """The effects of the model that is taken as true: the first of the set, or one that has more effects."""
    rival: list[Named]
    condition: str = ""
    """Which events: of one of several data sets, or of a condition that was asked for; empty for more of the same."""
    chi_squared: float
    """By how much that of the rival exceeds that of the true model, by the measured events."""
    events: int | None
    """0 if the measured ones are enough; None if no number is known to be, as of models that are the same."""
    low: int | None
    """As `high`, one standard error away; also given where no number is known."""
    high: int | None
    where: Place | None = None
    """Where most of the difference is: an excess is one of the true model. None of another condition."""
    share: float | None = None
    """Share of the difference that is there."""


class Candidate(Named):
    score: float
    p_value: float
    held_out_gap: float | None


class Identifiable(Named):
    """What these data could show of an effect."""

    retained: float | None
    """Share of its signal that is left once theta is fitted, with the strength `theta_bias_at`; None where no signal
    stands out of the noise of simulation."""
    minimum_detectable: float | None
    """The smallest strength seen with 90 % probability; None where none is up to `theta_bias_at`."""
    theta_bias: dict[str, float]
    """The shift of theta if the effect is there unnoticed, with the strength `theta_bias_at`."""
    theta_bias_at: float | None = None
    """The smallest strength seen, or else the largest one up to which theta was followed; None where simulated events
    did not suffice to tell."""
    rivals: list[Named]


class TableGap(Strict):
    """How far a table, or one of several data sets, is from the simulator with theta fitted, in the fitted bins."""

    name: str
    kind: Literal["table", "events"] = "table"
    dof: int
    """The degrees of freedom of the table, without those that the fit takes up."""
    chi_squared_before: float
    chi_squared_after: float | None
    """Chi-squared with the effects; None where none was added."""


class Disorder(Strict):
    """Something that contradicts that the measured events are exchangeable."""

    kind: Literal["drift", "change point", "season", "clustering"]
    feature: Feature
    of: Literal["level", "spread", "rate"]
    """What changes: the feature's values, how far they lie from their median, or how often events come."""
    at: float | None
    """The index (from 0) or time of the first event after a change, a season's period in events or in time, a
    clustering's lag in events; of a rate, in intervals of ten events on average."""
    along: Literal["index", "time"]
    size: float
    """The drift from first to last, the step of a change, or the amplitude of a season. The size of a clustering is the
    correlation, or the excess of the variance of counts over their mean."""
    unit: str
    """The unit of the size."""
    p_value: float
    """The p-value with all tests of the order counted."""


class Diagnosis(Strict):
    schema_version: int = SCHEMA_VERSION
    verdict: Verdict
    alpha: float
    p_value_before: float
    p_value_after: float | None
    gates: dict[str, GateResult]
    gates_after: dict[str, GateResult] | None = None
    """The tests of the model with the effects; None where none was added."""
    gap_before: Gap
    gap_after: Gap | None
    theta_before: dict[str, Value]
    theta_after: dict[str, Value] | None
    identified_before: list[Combination]
    identified_after: list[Combination] | None
    effects: list[FoundEffect]
    probabilities: list[Probable] = []
    """The probability of every name that was considered; empty where the search gives none."""
    outside: float | None = None
    """Probability that what is missing is outside the catalogue, by what the best model leaves."""
    others: float | None = None
    """Probability of a set of effects of the catalogue that is none of those that were weighed."""
    models: list[ProbableModel] = []
    """The smallest set of models that holds 95 % of what all that were weighed have, the most probable first."""
    decisions: list[Decision] = []
    """What would decide between the first model and each other one of the set; empty where there is nothing to."""
    regions: list[Region]
    candidates: list[Candidate]
    identifiability: list[Identifiable]
    order: list[Disorder] | None = None
    """What contradicts that events are exchangeable, the surest first; None where it was not asked."""
    tables: list[TableGap] = []
    """The tables, where they were measured in place of events, and each of several data sets."""
    doubt: str = ""
    """Why theta and what disagrees may be wrong: the thetas of a bank are too few, or too far apart."""
    notes: list[str]
    """Sentences for a person: fits that ended at a bound, what so few events cannot show, a wide AVO proposal."""
    num_events: int | None
    """The number of measured events; None where tables or several data sets were measured."""
    num_simulations: int
    seconds: float
    seed: int
    versions: dict[str, Any]
