"""A record: its fields, what makes sense in them, and its form as a line of JSON with a checksum."""

import hashlib
import json
import math
import re
from datetime import datetime
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from avobench.bench.store.status import ESTIMATED, LOST, Status
from avobench.tasks.contract import NAME
from avobench.tasks.errors import UsageError, first_fault

SCHEMA_VERSION = 1
"""The version of the schema is raised when a field changes its meaning."""
UNREAD = "cannot be read"
"""The fault of a file that the disk does not give begins so: its content may be sound, and is never made again."""
NEWER = f"{UNREAD} by this version of avobench"
"""The fault of a record that a newer version wrote begins so."""
TOLERANCE = 1e-12
"""A relative difference: a sum over many parameters depends on its order, by about 1e-16 a term."""
DEPTH = 50
"""Lists and objects may lie in one another so deep: far more than any setting needs, and no reader comes to its end."""
IDENTITY = (
    *("task", "task_version", "task_settings", "task_source_sha256"),
    *("method", "method_version", "method_settings", "method_source_sha256"),
    *("theta_true", "target", "repetition", "budget", "num_observations", "seed"),
)
"""The fields that determine a result, as far as a record has them; `id` is their hash."""
SECONDS = ("observation_seconds", "simulator_seconds", "method_seconds", "harness_seconds")
"""The fields that share out the time which a cell took."""

Count = Annotated[int, Field(ge=0, lt=2**63)]
"""A whole number that a table of 64-bit integers holds."""
Positive = Annotated[int, Field(ge=1, lt=2**63)]
Seconds = Annotated[float, Field(ge=0)]
Name = Annotated[str, Field(pattern=f"^{NAME}$")]
Sha256 = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
Vector = list[float]
PartlyKnown = list[float | None]
"""A vector in which what was not finite is null."""


class Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)


class TracePoint(Strict):
    """The estimate after so many simulated events."""

    simulations: Count
    theta: PartlyKnown
    std: PartlyKnown | None


class Record(Strict):
    """One inference and how it ended. Raises ValidationError where a field, or two together, make no sense."""

    schema_version: Annotated[int, Field(ge=SCHEMA_VERSION, le=SCHEMA_VERSION)] = Field(description="of this schema")
    id: str = Field(description="hash of everything that determines the result: the fields from `task` down to `seed`")
    task: Name = Field(description="what was simulated")
    task_version: str = Field(description="raised when the task's events, summary or floor change their meaning")
    task_settings: dict[str, Any] = Field(description="the task's settings")
    task_source_sha256: Sha256 = Field(
        None,
        description="checksum of the source of a task outside this package, and of the values that its functions and "
        "objects hold; no such field for one within it",
    )
    method: Name = Field(description="how θ was inferred")
    method_version: str = Field(description="raised when the same settings and seed would give another estimate")
    method_settings: dict[str, Any] = Field(
        description="the method's settings; `device` and `step` of AVO are left out at their defaults: "
        "they came later, and change a result by rounding alone"
    )
    method_source_sha256: Sha256 = Field(
        None, description="likewise for the method, over the modules of its class and bases"
    )
    amortised: Literal[True] = Field(
        None,
        description="true where the simulated events are the same for all targets, so that `budget` is one for them "
        "all; no such field elsewhere",
    )
    theta_true: Vector = Field(min_length=1, description="the target: the parameters of the observed events")
    target: Count = Field(description="index of the target; targets belong to the task and do not depend on the seed")
    repetition: Count = Field(description="index of the repetition: the same observation, other random streams")
    budget: Positive = Field(description="simulated events that the method may use")
    num_observations: Positive = Field(description="observed events")
    seed: Count = Field(description="root of all random streams")
    parameter_names: list[str] = Field(description="names of the parameters, in the order of all lists over them")
    status: Annotated[Status, Field(strict=False)] = Field(description="how the inference ended, see below")
    message: str = Field(description="reason of a failure, or a remark such as why budget was left over")
    theta_hat: Vector | None = Field(
        description="the estimate, whole numbers of integers; null unless `status` is `ok` or `doubtful`, as the "
        "fields to `std`"
    )
    squared_error: Annotated[float, Field(ge=0)] | None = Field(
        description="squared distance of the estimate to `theta_true`"
    )
    floor: Annotated[float, Field(ge=0)] | None = Field(
        description="expected squared error of the best estimator that knows the model only through `budget` simulated "
        "events; null where it is not finite or not known"
    )
    floor_likelihood: Annotated[float, Field(ge=0)] | None = Field(
        description="the same for an estimator that knows the likelihood"
    )
    how: str | None = Field(description="how the estimate was taken")
    spread_of: Literal["posterior", "proposal"] | None = Field(
        description="what `mean` and `std` are of: the posterior or the proposal"
    )
    mean: PartlyKnown | None = Field(description="mean of the posterior or proposal")
    std: PartlyKnown | None = Field(description="standard deviation of the posterior or proposal")
    standard_error: PartlyKnown = Field(
        None, description="of `theta_hat`, where the method tells one; no such field elsewhere"
    )
    trace: list[TracePoint] = Field(
        description="list of `simulations`, `theta`, `std`: the estimate after so many simulated events, in their order"
    )
    simulations_requested: Count | None = Field(
        description="events asked for: used plus refused; null, as the next three, where the worker process was lost"
    )
    simulations_used: Count | None = Field(
        description="events simulated, never above `budget`; pilot and calibration events count too"
    )
    simulations_discarded: Count | None = Field(description="of those used, the events that did not enter the estimate")
    simulations_refused: Count | None = Field(
        description="events that would have exceeded the budget and were not simulated"
    )
    observation_seconds: Seconds = Field(description="making the observed events")
    simulator_seconds: Seconds = Field(description="in the simulator, for the method")
    method_seconds: float = Field(
        description="in the method outside of the simulator, the first use of its package included. Of cells carried "
        "out together, as `message` says, it is an equal share. It is the difference of two clocks, so below 0 where a "
        "method calls the simulator from several threads"
    )
    harness_seconds: Seconds = Field(description="the rest of the cell")
    peak_memory_mib: Annotated[float, Field(gt=0)] | None = Field(
        description="highest resident memory of the worker process during the cell (Linux; null elsewhere)"
    )
    started: str | None = Field(description="when, in UTC; null where the worker process was lost")
    versions: dict[str, str | None] = Field(
        description="of Python, avobench, NumPy, SciPy, PyTorch, pyABC, ELFI, GPy, Pythia, the packages that the task "
        "and method name, and the commit of the source. They do not identify a cell: after an upgrade, finished cells "
        "stay finished"
    )

    @model_validator(mode="after")
    def _agrees(self) -> "Record":
        """Raise ValueError where fields that are sound by themselves contradict each other."""
        self._lengths_agree()
        self._events_add_up()
        self._estimate_is_there_if_ok()
        self._trace_is_in_order()
        if self.started is not None and datetime.fromisoformat(self.started).tzinfo is None:
            raise ValueError(f"started says no time zone: {self.started}")
        return self

    def _lengths_agree(self) -> None:
        p = len(self.theta_true)
        if len(self.parameter_names) != p or len(set(self.parameter_names)) != p:
            raise ValueError(f"parameter_names are not {p} different names, as theta_true has numbers")
        vectors = [(name, getattr(self, name)) for name in ("theta_hat", "mean", "std", "standard_error")]
        vectors += [("theta of the trace", point.theta) for point in self.trace]
        vectors += [("std of the trace", point.std) for point in self.trace]
        for name, vector in vectors:
            if vector is not None and len(vector) != p:
                raise ValueError(f"{name} has {len(vector)} numbers, theta_true has {p}")
            if name.startswith(("std", "standard_error")) and any((value or 0) < 0 for value in vector or ()):
                raise ValueError(f"{name} is negative")

    def _events_add_up(self) -> None:
        names = [f"simulations_{what}" for what in ("requested", "used", "discarded", "refused")]
        counts = [getattr(self, name) for name in names]
        if (self.status in LOST) != (None in counts) or len({count is None for count in counts}) > 1:
            raise ValueError("the numbers of simulations are known exactly where the worker process was not lost")
        if None in counts:
            return
        requested, used, discarded, refused = counts
        if requested != used + refused:
            raise ValueError(f"simulations_requested is {requested}, not {used} used plus {refused} refused")
        if used > self.budget:
            raise ValueError(f"simulations_used is {used}, more than the budget of {self.budget}")
        if discarded > used:
            raise ValueError(f"simulations_discarded is {discarded}, more than the {used} used")

    def _estimate_is_there_if_ok(self) -> None:
        ok = self.status in ESTIMATED
        for name in ("theta_hat", "squared_error", "how", "spread_of", "mean", "std"):
            if (getattr(self, name) is not None) != ok:
                raise ValueError(f"{name} is {'null' if ok else 'given'} though the status is {self.status}")
        if not ok:
            if self.standard_error is not None:
                raise ValueError(f"standard_error is given though the status is {self.status}")
            return
        differences = [estimate - true for estimate, true in zip(self.theta_hat, self.theta_true, strict=True)]
        distance = sum(difference * difference for difference in differences)
        if not math.isclose(self.squared_error, distance, rel_tol=TOLERANCE):
            raise ValueError(f"squared_error is {self.squared_error}, theta_hat is {distance} from theta_true")

    def _trace_is_in_order(self) -> None:
        simulations = [point.simulations for point in self.trace]
        if simulations and self.status not in ESTIMATED:
            raise ValueError(f"there is a trace though the status is {self.status}")
        if any(later < earlier for earlier, later in pairwise(simulations)):
            raise ValueError("the trace is not in the order of its simulations")
        if simulations and simulations[-1] > self.simulations_used:
            raise ValueError(f"the trace goes to {simulations[-1]} of {self.simulations_used} simulations used")


def require_keepable(value: Any, depth: int = DEPTH) -> None:
    """Raise ValueError where a value is JSON, and a table, a terminal or another reader would still fail over it."""
    if isinstance(value, str) and not value.isascii() and value != value.encode(errors="ignore").decode():
        raise ValueError("holds half of a surrogate pair, which is no text")
    if isinstance(value, dict | list):
        if not depth:
            raise ValueError(f"holds more than {DEPTH} lists and objects in one another")
        for inner in (*value, *value.values()) if isinstance(value, dict) else value:
            require_keepable(inner, depth - 1)


def check(record: dict[str, Any]) -> None:
    """Raise ValueError, saying why, unless a record makes sense by itself and its id is that of its identity."""
    try:
        Record.model_validate(record)
    except ValidationError as error:
        raise ValueError(f"makes no sense: {': '.join(filter(None, first_fault(error)))}") from error
    if record["id"] != identity_hash({name: record[name] for name in IDENTITY if name in record}):
        raise ValueError("makes no sense: id is not that of the fields which it stands for")


def identity_hash(identity: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]


def file_name(record: dict[str, Any]) -> str:
    """The name of the file of a record, from its cell and its id. Raises UsageError for a name that is none."""
    for kind in ("task", "method"):
        if not re.fullmatch(NAME, record[kind]):
            raise UsageError(f"the name of a {kind} must be letters, digits, dots and dashes, got '{record[kind]}'")
    return "{task}_{method}_t{target:02d}_r{repetition}_{id}.json".format(**record)


def encode(record: dict[str, Any]) -> bytes:
    """A record as one line of JSON with its checksum. Raises TypeError or ValueError for what no file can hold."""
    return (json.dumps({**record, "sha256": _checksum(record)}, allow_nan=False) + "\n").encode()


def decode(content: bytes) -> dict[str, Any]:
    """The record that `encode` was given, of whatever kind; raises ValueError saying what is wrong with `content`."""
    try:
        record = json.loads(content.decode())
        claimed = record.pop("sha256")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError("is truncated or not a record") from error
    version = record.get("schema_version")
    if isinstance(version, int) and version > SCHEMA_VERSION:
        raise ValueError(f"{NEWER}: it has schema version {version}, and {SCHEMA_VERSION} is known here")
    if version != SCHEMA_VERSION:
        raise ValueError(f"has schema version {record.get('schema_version')}, not {SCHEMA_VERSION}")
    if _checksum(record) != claimed:
        raise ValueError("was changed after it was written (its checksum does not match)")
    return record


def decode_record(content: bytes) -> dict[str, Any]:
    """The record of a cell in `content`; raises ValueError saying what is wrong, or makes no sense, in it."""
    record = decode(content)
    check(record)
    return record


def _checksum(record: dict[str, Any]) -> str:
    # The trace, which is most of a record, holds numbers alone, as `check` sees.
    require_keepable({name: value for name, value in record.items() if name != "trace"})
    try:
        text = json.dumps(record, sort_keys=True, allow_nan=False)
    except ValueError as error:
        raise ValueError("holds a number that is not finite") from error
    return hashlib.sha256(text.encode()).hexdigest()
