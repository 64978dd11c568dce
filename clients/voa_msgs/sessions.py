"""Sessions, and the observations that change their beliefs: scans, outcomes of grasps, replaced beliefs."""

from datetime import datetime
from typing import Annotated, Literal

from annotated_types import Ge, Le, Len
from pydantic import Field, JsonValue

from voa_msgs import examples
from voa_msgs.base import Distribution, Free, Id, Message, Name, NotNegative, Page, Ranges, Real
from voa_msgs.bounds import LimitedBy, OneMistake
from voa_msgs.examples import exemplified
from voa_msgs.looks import AnnouncedLook, AtPlace, Place
from voa_msgs.priors import Prior
from voa_msgs.warnings import ProbableMistake


def _is_none(value: object) -> bool:
    """True for a field that a response leaves out."""
    return value is None


MOST_ROBOTS = 1_000
"""Most robots that one session can claim when it is opened."""


class SessionRequest(Message):
    """Request to open a session on a scenario."""

    model_config = exemplified(examples.SESSION)

    scenario: Id
    """Identifier of the scenario."""
    prior: Prior | None = None
    """Belief before the first observation: probabilities, or a model of them; null: the scenario's prior."""
    robots: Annotated[list[Name], OneMistake(), Len(0, MOST_ROBOTS)] | None = Field(
        default=None, exclude_if=lambda robots: robots is None
    )
    """Names of mapped robots whose scans are applied to this session from now on; absent or null: none."""


class Estimate(Message):
    """Estimate: the belief over the poses, and the grasp that is best under it."""

    scenario: str
    """Identifier of the scenario."""
    version: int | None
    """Version: the number of accepted observations and replaced beliefs; null: nothing is stored."""
    poses: list[str]
    """Names of the poses, in the order of `belief`."""
    belief: list[float]
    """Belief: one probability per pose, in the order of `poses`."""
    best_grasp: str | None
    """Grasp with the largest expected score; null: every grasp scores 0."""
    expected_score: float
    """Expected score of the best grasp, the probability that it succeeds, 0 to 1."""
    entropy_nats: float
    """Entropy of the belief, nats; 0: the pose is certain."""
    absent: float | None = None
    """Probability that the object lies at none of the poses, 0 to 1; belief and expected score hold where it lies at
    one of them; null: that is taken for certain."""
    last_fit_rmsd_mm: float | None
    """Root mean square difference of the newest accepted scan to its best-fitting pose, mm; null: no scan yet."""
    warnings: list[ProbableMistake] = Field(default=[])
    """Probable mistakes in the scenario and, in the response to a scan, in the scan; empty: none."""


class Session(Estimate):
    """Session: the current estimate of a scenario."""

    id: str
    """Identifier of the session."""
    places: list[Place] = Field(default=[])
    """Places from which looks were taken since the belief was last replaced, also by `nearest` and `object_moved`; the
    oldest first."""
    under_way: list[AnnouncedLook] = Field(default=[])
    """Announced looks whose scans have not arrived yet, the oldest first."""
    created_at: datetime
    """Time at which the session was opened, UTC."""
    updated_at: datetime
    """Time of the newest version, UTC."""


class SessionSummary(Message):
    """Summary of a session without its belief, for a list."""

    id: str
    """Identifier of the session."""
    scenario: str
    """Identifier of the scenario."""
    version: int
    """Version: the number of accepted observations and replaced beliefs."""
    best_grasp: str | None
    """Grasp with the largest expected score; null: every grasp scores 0."""
    expected_score: float
    """Expected score of the best grasp, the probability that it succeeds, 0 to 1."""
    entropy_nats: float
    """Entropy of the belief, nats; 0: the pose is certain."""
    absent: float | None = None
    """Probability that the object lies at none of the poses, 0 to 1; null: that it lies at one is taken for certain."""
    last_fit_rmsd_mm: float | None
    """Root mean square difference of the newest accepted scan to its best-fitting pose, mm; null: no scan yet."""
    created_at: datetime
    """Time at which the session was opened, UTC."""
    updated_at: datetime
    """Time of the newest version, UTC."""


class SessionPage(Page):
    """Page of the list of sessions."""

    items: list[SessionSummary]
    """Summaries of sessions, oldest first."""


class Scan(Message):
    """Scan: the ranges of one revolution of a lidar, as its driver reports them."""

    ranges: Ranges
    """Range of each beam, metres; null: the beam is missing, which is no evidence."""
    no_return: Annotated[list[Annotated[int, Ge(0)]], LimitedBy("beams")] = Field(default=[])
    """Indices of the beams on which nothing was in range, which is evidence; `ranges` is ignored at these indices."""
    angle_min: Real | None = None
    """Angle of the first beam, radians, counter-clockwise from the sensor's +x; null: the angle of the lidar."""
    angle_increment: Real | None = None
    """Angle between neighbouring beams, radians; null: the increment of the lidar."""
    range_min: NotNegative | None = None
    """Shortest range, metres: a beam with a shorter measurement is missing; null: the limit of the lidar."""
    range_max: NotNegative | None = None
    """Longest range, metres: a beam with a longer measurement is a no-return; null: the limit of the lidar."""
    stamp: Free = None
    """Any JSON of the user's own, such as the time of the scan; the service stores it and returns it unchanged."""


class ScanRequest(AtPlace):
    """Request to update a belief by a scan, with the place of the lidar: exactly one of `sensor` and `sensor_pose`."""

    model_config = exemplified(examples.SCAN)

    scan: Scan
    """Scan, as the driver of the lidar reports it."""


class UpdateRequest(ScanRequest):
    """Request to update a belief that the request states by a scan; nothing is stored."""

    model_config = exemplified(examples.UPDATE)

    scenario: Id
    """Identifier of the scenario."""
    belief: Distribution | None
    """Belief before the scan: one probability per pose, in the order of the scenario; null: the scenario's prior."""
    absent: Annotated[float, Ge(0.0), Le(1.0)] | None = None
    """Probability, before the scan, that the object lies at none of the poses; null: the scenario's `absent`."""


Reason = Literal["no_beams", "nothing_seen", "bad_fit", "no_match", "nearest"]
"""Reason why a scan was not accepted, or does not count for the poses.

`nearest`: no pose explains the scan, and the nearest poses share the belief. `nothing_seen` and `no_match` with an
accepted scan: it moved `absent` alone.
"""


class UpdateReport(Message):
    """Effect of an observation on the belief."""

    accepted: bool
    """True if the observation changed the belief or `absent`, and the version; false: it changed nothing."""
    reason: Reason | None
    """Reason why the observation was not accepted; or, where it was accepted, `nearest`: no pose explains it, and the
    nearest poses share the belief; `nothing_seen` or `no_match`: it moved `absent` alone; null: accepted as usual."""
    log_evidence: float | None
    """Logarithm of the evidence: ln sum_p b[p] w[p], with belief b and weights w, which for a further look from one
    place are relative to the earlier ones; null: not computed."""
    fit_rmsd_mm: float | None
    """Root mean square difference of scan and prediction of `best_fit_pose` over all compared beams, mm."""
    fit_hit_rmsd_mm: float | None
    """Root mean square difference over the beams on which scan and prediction both return, mm; null: no such beam."""
    best_fit_pose: str | None
    """Pose with the largest weight under the update rule, the first listed of equals; null: no beam was compared."""
    beams_compared: int
    """Number of beams that are not missing and were compared with the predictions."""


class BeliefRequest(Message):
    """Request to replace the belief of a session."""

    model_config = exemplified(examples.BELIEF)

    belief: Distribution | None
    """Belief: one probability per pose, in the order of the session's `poses`; null: the session's prior."""


class OutcomeRequest(Message):
    """Request to update the belief by the outcome of a grasp attempt."""

    model_config = exemplified(examples.OUTCOME)

    grasp: Name
    """Name of the grasp that was attempted."""
    success: bool
    """True if the grasp succeeded."""
    object_moved: Annotated[float, Ge(0.0), Le(1.0)] = Field(default=0.0, exclude_if=lambda moved: moved == 0.0)
    """Probability that the attempt moved the object. Above 0, the session's prior is mixed into the belief with this
    share, and earlier looks and outcomes no longer count."""


class HistoryEntry(Message):
    """Version of a session, with the request that caused it."""

    version: int
    """Number of the version; 0: the prior."""
    kind: Literal["prior", "scan", "outcome", "belief"]
    """Kind of the request: opening the session, a scan, an outcome of a grasp, or a replaced belief."""
    at: datetime
    """Time at which the version was stored, UTC."""
    request: JsonValue
    """Body of the request, as it was received."""
    update: UpdateReport | None
    """Effect of a scan or an outcome; null for a prior or a replaced belief."""
    absent: float | None = None
    """Probability, at this version, that the object lies at none of the poses; null: that it lies at one is taken for
    certain."""
    belief: list[float] | None = Field(default=None, exclude_if=_is_none)
    """Belief: one probability per pose, in the order of the session's `poses`; only with `beliefs=true`."""
    best_grasp: str | None = Field(default=None, exclude_if=_is_none)
    """Grasp with the largest expected score, where there is a `belief`; absent: every grasp scores 0."""
    expected_score: float | None = Field(default=None, exclude_if=_is_none)
    """Expected score of that grasp, 0 to 1; only where there is a `belief`."""
    entropy_nats: float | None = Field(default=None, exclude_if=_is_none)
    """Entropy of the belief, nats; only where there is a `belief`."""


class HistoryPage(Page):
    """Page of the history of a session."""

    items: list[HistoryEntry]
    """Versions in ascending order, the prior first."""


class UpdatedSession(Session):
    """Session after an observation."""

    update: UpdateReport
    """Effect of the observation on the belief."""


class UpdatedEstimate(Estimate):
    """Estimate after an observation; nothing is stored."""

    update: UpdateReport
    """Effect of the observation on the belief."""
