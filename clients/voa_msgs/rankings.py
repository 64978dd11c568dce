"""Rankings of looks by Value of Assistance (VOA), and of grasps by expected score."""

from typing import Annotated, Literal

from annotated_types import Ge, Le, Len
from pydantic import Field

from voa_msgs import examples
from voa_msgs.base import Distribution, Id, Message, Name
from voa_msgs.bounds import LimitedBy
from voa_msgs.examples import exemplified
from voa_msgs.geometry import Candidate

Definition = Literal["posterior", "executed"]
"""Definition of VOA: expected gain of the best expected score, or of the score of the grasp that is then executed."""


class VoaRequest(Message):
    """Request for a ranking of looks by Value of Assistance."""

    model_config = exemplified(examples.VOA)

    sensors: Annotated[list[Candidate], Len(1), LimitedBy("sensors")] | None = None
    """Looks to rank: names of sensor configurations, or any sensor poses; null: all sensors of the scenario."""
    definition: Definition = "posterior"
    """Definition of VOA: gain of the best expected score (`posterior`), or of the executed grasp's (`executed`)."""
    grasps: Annotated[list[Name], Len(1), LimitedBy("grasps")] | None = None
    """Names of the grasps that the arm can reach now; null: all of the scenario's."""
    sensor_belief: Distribution | None = None
    """Belief of the robot with the lidar, one probability per pose, where it differs; null: the belief itself."""
    min_gain: Annotated[float, Ge(0.0), Le(1.0)] | None = None
    """Net value, in success probability, above which a look is recommended; null: the scenario's `min_gain`."""
    outcomes: bool = False
    """True to list, for each look, the expected result at each pose."""


class RankingRequest(VoaRequest):
    """Request for a ranking of looks for a belief that the request states; nothing is stored."""

    model_config = exemplified(examples.RANKING)

    scenario: Id
    """Identifier of the scenario."""
    belief: Distribution | None
    """Belief: one probability per pose, in the order of the scenario; null: the scenario's prior."""


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
    """Standard error of `voa`, in success probability; null: `voa` is exact."""
    cost: float
    """Cost of the look, in units of success probability."""
    net_value: float
    """Net value, in success probability: `voa` - `cost`; the ranking is sorted by it."""
    expected_score_after: float
    """Expected probability of a successful grasp after the look, 0 to 1."""
    ties_with_first: bool
    """True if the net value equals that of the first look in the ranking within 1e-6; true for the first look."""
    outcomes: list[Outcome] | None = None
    """Expected result at each pose with a probability above 0; null unless the request sets `outcomes`."""


class Look(Message):
    """Recommendation to look: the net value of the best look exceeds `min_gain`."""

    action: Literal["look"]
    """Always `look`."""
    sensor: str
    """Name of the sensor configuration, or of the sensor pose in the request, to look from."""
    net_value: float
    """Value of Assistance of the look less its cost, in success probability."""


class GraspNow(Message):
    """Recommendation to grasp: no look has a net value above `min_gain`."""

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
    method: Literal["exact", "sampled"]
    """Method: an expectation over all poses (`exact`), or over a sample of them (`sampled`)."""
    precision: Literal["float64", "float32"]
    """Floating-point precision of the computation; `float32` where the weights of float64 exceed the memory limit."""
    expected_score_before: float
    """Expected score of the best grasp before any look, 0 to 1."""
    best_grasp_before: str | None
    """Grasp with the largest expected score before any look; null: every grasp scores 0."""
    ranking: list[RankedSensor]
    """Looks, the largest net value first."""
    recommendation: Annotated[Look | GraspNow, Field(discriminator="action")]
    """Recommended action: look from a place, or grasp now."""


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
