"""Rankings of looks by Value of Assistance (VOA), and of grasps by expected score."""

from typing import Annotated, Literal

from annotated_types import Ge, Le, Len
from pydantic import Field
from pydantic.config import JsonDict

from voa_msgs import examples
from voa_msgs.base import Distribution, Id, Message, Name, NotNegative
from voa_msgs.bounds import LimitedBy
from voa_msgs.examples import exemplified
from voa_msgs.geometry import Candidate, Departure, PoseUncertainty
from voa_msgs.warnings import ProbableMistake

Definition = Literal["posterior", "executed"]
"""Definition of VOA: expected gain of the best expected score, or of the score of the grasp that is then executed."""

Scans = Literal["exact", "simulated"]
"""Predicted scans over which looks are valued: one exact scan of each pose, or noisy scans of displaced poses."""
Method = Literal["exact", "sampled"]
"""Method of a ranking: expectations over all poses, or over samples of them."""
_PREDICTED_SCANS: JsonDict = {"type": "integer", "x-limit": "predicted_scans"}
"""Schema in which the service states the most scans, places times poses, that a ranking may predict."""
MOST_PENDING = 64
"""Most looks under way that a ranking can take into account, and most that a session keeps."""
MOST_SAMPLES = 4_096
"""Most simulated scans of each pose and place."""


class VoaRequest(
    Message,
    serialize_by_alias=True,
    validate_by_name=True,
    json_schema_extra={"examples": [examples.VOA], "x-predicted-scans": _PREDICTED_SCANS},
):
    """Request for a ranking of looks by Value of Assistance."""

    sensors: Annotated[list[Candidate], Len(1), LimitedBy("sensors")] | None = None
    """Looks to rank: names of sensor configurations, or any sensor poses; null: all sensors of the scenario."""
    scans: Scans | None = None
    """Predicted scans: `exact`, one of each pose as in the papers; `simulated`, noisy scans of displaced poses, as the
    update will weigh them; null: `simulated` where the scenario has a mesh, and a spread, or `sensor_std` or the
    session's last sensor pose a standard deviation, else `exact`."""
    samples: Annotated[int, Ge(1), Le(MOST_SAMPLES)] | None = None
    """Number of simulated scans of each pose; null: as many as make 256 of all poses together, and at least 1."""
    method: Method | None = None
    """Method: `exact`, an expectation over all poses; `sampled`, over samples of them, larger ones for the looks that
    may be the best, over exact scans and without `outcomes`; null: `sampled` where it can be and there are more than
    320 million weights (places times squared poses), else `exact`."""
    definition: Definition | None = None
    """Definition of VOA: gain of the best expected score (`posterior`), or of the executed grasp's (`executed`); null:
    `posterior` over exact scans, `executed` over simulated ones."""
    sensor_std: PoseUncertainty | None = None
    """Standard deviations of the sensor poses at which the robot will arrive; null: those of the session's last sensor
    pose, and without one they are exact."""
    lookahead: Annotated[int, Ge(1), Le(2)] = 2
    """Number of looks that the recommendation plans: 1, or 2 where no single look is worth its cost."""
    from_: Departure | None = Field(default=None, alias="from")
    """Point from which the robot drives: the name of a sensor configuration, or x and y in metres; null: driving costs
    nothing."""
    cost_per_m: NotNegative = 0.0
    """Cost of driving one metre in a straight line, in units of success probability; it needs `from`."""
    pending: Annotated[list[Candidate], Len(0, MOST_PENDING), LimitedBy("sensors")] | None = None
    """Looks that are under way: the value of a look is what it adds to them; null: those announced in the session."""
    grasps: Annotated[list[Name], Len(1), LimitedBy("grasps")] | None = None
    """Names of the grasps that the arm can reach now; null: all of the scenario's."""
    sensor_belief: Distribution | None = None
    """Belief of the robot with the lidar, one probability per pose, where it differs; null: the belief itself."""
    min_gain: Annotated[float, Ge(0.0), Le(1.0)] | None = None
    """Net value, in success probability, that a look must exceed to be recommended, over simulated scans by two
    standard errors; null: the scenario's `min_gain`."""
    outcomes: bool = False
    """True to list, for each look, the expected result at each pose."""


class RankingRequest(VoaRequest):
    """Request for a ranking of looks for a belief that the request states; nothing is stored."""

    model_config = exemplified(examples.RANKING, **{"x-predicted-scans": _PREDICTED_SCANS})

    scenario: Id
    """Identifier of the scenario."""
    belief: Distribution | None
    """Belief: one probability per pose, in the order of the scenario; null: the scenario's prior."""
    absent: Annotated[float, Ge(0.0), Le(1.0)] | None = None
    """Probability that the object lies at none of the poses, for the warnings; null: the scenario's `absent`."""


class Outcome(Message):
    """Expected result of a look, if the object lies at `pose`."""

    pose: str
    """Name of the pose."""
    probability: float
    """Probability of the pose before the look."""
    best_grasp: str | None
    """Grasp with the largest expected score after the look; null: every grasp scores 0."""
    expected_score: float
    """Expected score of that grasp under the belief after the look, 0 to 1."""


class RankedSensor(Message):
    """Look in a ranking, with its Value of Assistance."""

    sensor: str
    """Name of the sensor configuration, or of the sensor pose in the request."""
    voa: float
    """Value of Assistance: expected gain in the probability of a successful grasp; it may be negative."""
    standard_error: float | None
    """Standard error of `voa` from the number of simulated scans or of sampled poses, in success probability; null:
    scans are exact, and of all poses."""
    score_standard_error: float | None = None
    """Standard error of `voa` from the number of attempts behind the grasp scores, in success probability; null: the
    scores are given probabilities."""
    cost: float
    """Cost of the look, the drive included, in units of success probability."""
    net_value: float
    """Net value, in success probability: `voa` - `cost`; the ranking is sorted by it."""
    expected_score_after: float
    """Expected probability of a successful grasp after the look, 0 to 1."""
    ties_with_first: bool
    """True if the net value does not surely differ from that of the first look: within two standard errors of the
    difference, and for exact scans of all poses within 1e-6; true for the first look."""
    looks_taken: int = 0
    """Number of accepted looks that the session has taken from this place; 0 without a session."""
    outcomes: list[Outcome] | None = None
    """Expected result at each pose with a probability above 0; null unless the request sets `outcomes`."""


class Look(Message):
    """Recommendation to look: the net value of the best look, or of the best pair, surely exceeds `min_gain`."""

    action: Literal["look"]
    """Always `look`."""
    sensor: str
    """Name of the sensor configuration, or of the sensor pose in the request, to look from."""
    net_value: float
    """Value of Assistance of the look less its cost, in success probability; with `then`, of both looks."""
    then: str | None = None
    """Second look, where no look is worth its cost alone and two are together; null: the look is worth it alone."""


class GraspNow(Message):
    """Recommendation to grasp: no look, and no pair of looks, has a net value that surely exceeds `min_gain`."""

    action: Literal["grasp"]
    """Always `grasp`."""
    grasp: str | None
    """Grasp with the largest expected score; null: every grasp scores 0."""
    expected_score: float
    """Expected score of that grasp, the probability that it succeeds, 0 to 1."""


class Ranking(Message):
    """Ranking of looks by Value of Assistance less cost, and the recommended action."""

    version: int | None
    """Version of the session whose belief was used; null: the belief was stated in the request."""
    definition: Definition
    """Definition of VOA: gain of the best expected score (`posterior`), or of the executed grasp's (`executed`)."""
    scans: Scans = "exact"
    """Predicted scans: `exact`, one of each pose; `simulated`, noisy scans of displaced poses."""
    samples: int | None = None
    """Number of simulated scans of each pose; null: scans are exact."""
    lookahead: int = 1
    """Number of looks that the recommendation plans where no single look is worth its cost; 1 for a single place, above
    64 places, where the weights of all places take more than 1 GiB, and for the method `sampled`."""
    value_of_perfect_information: float | None = None
    """Gain in success probability if the pose were known: the most that looks can be expected to gain."""
    method: Method
    """Method: an expectation over all poses (`exact`), or over a sample of them (`sampled`)."""
    precision: Literal["float64", "float32"]
    """Floating-point precision of the computation; `float32` where the weights of float64 exceed the memory limit."""
    expected_score_before: float
    """Expected score of the best grasp before any look, 0 to 1."""
    best_grasp_before: str | None
    """Grasp with the largest expected score before any look; null: every grasp scores 0."""
    ranking: list[RankedSensor]
    """Looks, the largest net value first. Over simulated scans the first has the figures of an evaluation of its own,
    on other and more scans; so do looks that were first before theirs."""
    recommendation: Annotated[Look | GraspNow, Field(discriminator="action")]
    """Recommended action: look from a place, or grasp now."""
    warnings: list[ProbableMistake] = Field(default=[])
    """Warnings about the recommendation, above all that the object is probably not there; empty: none."""


class RankedGrasp(Message):
    """Grasp with its expected score."""

    name: str
    """Name of the grasp."""
    expected_score: float
    """Probability that the grasp succeeds under the belief of the session, 0 to 1."""


class RankedGrasps(Message):
    """Ranking of grasps by expected score."""

    version: int
    """Version of the session whose belief was used."""
    grasps: list[RankedGrasp]
    """Grasps, the largest expected score first."""
