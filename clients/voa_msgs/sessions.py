"""Sessions: one running estimate each; and the scans that move them."""

from datetime import datetime
from typing import Annotated, Literal, Self

from annotated_types import Ge, Len
from pydantic import Field, JsonValue, model_validator

from voa_msgs import examples
from voa_msgs.base import Distribution, Free, Id, Message, Name, NotNegative, Page, Ranges, Real
from voa_msgs.bounds import LimitedBy, OneMistake
from voa_msgs.examples import exemplified
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.priors import Prior
from voa_msgs.warnings import ProbableMistake

MOST_ROBOTS = 1_000


class SessionRequest(Message):
    """Open a session on a scenario."""

    model_config = exemplified(examples.SESSION)

    scenario: Id
    prior: Prior | None = None
    """Null: the scenario's."""
    robots: Annotated[list[Name], OneMistake(), Len(0, MOST_ROBOTS)] | None = Field(
        default=None, exclude_if=lambda robots: robots is None
    )
    """Mapped robots whose scans go to this session from now on, by name; absent or null: none is claimed."""


class Estimate(Message):
    """What is believed, and which grasp follows from it."""

    scenario: str
    version: int | None
    """Counts accepted observations and replaced beliefs; null where nothing is stored."""
    poses: list[str]
    belief: list[float]
    """One probability per pose, in the order of `poses`."""
    best_grasp: str | None
    """Null where every grasp scores 0."""
    expected_score: float
    entropy_nats: float
    last_fit_rmsd_mm: float | None
    """Fit of the newest accepted scan."""
    warnings: list[ProbableMistake] = Field(default=[])
    """Probable mistakes in the scenario; in the answer to a scan, also those in the scan."""


class Session(Estimate):
    """A session as it stands."""

    id: str
    created_at: datetime
    updated_at: datetime


class SessionSummary(Message):
    """A session in a list."""

    id: str
    scenario: str
    version: int
    best_grasp: str | None
    expected_score: float
    entropy_nats: float
    last_fit_rmsd_mm: float | None
    created_at: datetime
    updated_at: datetime


class SessionPage(Page):
    """Sessions without their beliefs, oldest first."""

    items: list[SessionSummary]


class Scan(Message):
    """One revolution as the driver gave it. Null is a missing beam: no evidence."""

    ranges: Ranges
    no_return: Annotated[list[Annotated[int, Ge(0)]], LimitedBy("beams")] = Field(default=[])
    """Indices of beams in whose direction nothing was in range: evidence. What `ranges` has there is ignored."""
    angle_min: Real | None = None
    """Radians; null: the lidar's, as the following."""
    angle_increment: Real | None = None
    range_min: NotNegative | None = None
    range_max: NotNegative | None = None
    stamp: Free = None
    """The user's own; kept and returned."""


class ScanRequest(Message):
    """A raw scan, and where it was taken: exactly one of `sensor` and `sensor_pose`."""

    model_config = exemplified(examples.SCAN)

    sensor: Name | None = None
    """A sensor configuration of the scenario."""
    sensor_pose: UncertainSensorPose | None = None
    scan: Scan

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.sensor is None) == (self.sensor_pose is None):
            raise ValueError("exactly one of 'sensor' and 'sensor_pose' is expected")
        return self


class UpdateRequest(ScanRequest):
    """A scan applied to the belief in the request; nothing is stored."""

    model_config = exemplified(examples.UPDATE)

    scenario: Id
    belief: Distribution | None
    """Null: the scenario's prior."""


Reason = Literal["no_beams", "nothing_seen", "bad_fit", "no_match", "nearest"]


class UpdateReport(Message):
    """What one observation did."""

    accepted: bool
    reason: Reason | None
    """Why it was not accepted; `nearest` where no pose explained it and the nearest ones share the belief."""
    log_evidence: float | None
    """ln sum_p b[p] w[p] with the weights as used."""
    fit_rmsd_mm: float | None
    """RMSD of `best_fit_pose` over all compared beams."""
    fit_hit_rmsd_mm: float | None
    """RMSD of `best_fit_pose` over the beams on which scan and prediction both return; null where there are none."""
    best_fit_pose: str | None
    """The pose with the largest weight under the update rule, the first listed of equals."""
    beams_compared: int


class BeliefRequest(Message):
    """Replace a session's belief."""

    model_config = exemplified(examples.BELIEF)

    belief: Distribution | None
    """Null: back to the session's prior."""


class OutcomeRequest(Message):
    """What came of a grasp attempt that left the object where it was."""

    model_config = exemplified(examples.OUTCOME)

    grasp: Name
    success: bool


class HistoryEntry(Message):
    """One version of a session and what made it."""

    version: int
    kind: Literal["prior", "scan", "outcome", "belief"]
    at: datetime
    request: JsonValue
    """The body as it was received."""
    update: UpdateReport | None
    """What an observation did; null for a prior or a replaced belief."""


class HistoryPage(Page):
    """Versions of a session, ascending, the prior first."""

    items: list[HistoryEntry]


class UpdatedSession(Session):
    """A session after an observation."""

    update: UpdateReport


class UpdatedEstimate(Estimate):
    """An estimate after an observation; nothing is stored."""

    update: UpdateReport
