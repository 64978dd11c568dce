"""Scenarios: object, poses, grasps, scores, lidar, sensor configurations, update rule and prior."""

from datetime import datetime
from typing import Annotated, Any

from annotated_types import Ge, Gt, Le, Len, Lt
from pydantic import ConfigDict, Discriminator, Field, Tag

from voa_msgs import examples
from voa_msgs.base import Free, Id, Message, Name, Page, Point2, Point3, Quaternion, Range, Ranges
from voa_msgs.bounds import LimitedBy
from voa_msgs.examples import exemplified
from voa_msgs.geometry import Candidate, SensorConfiguration, Spread
from voa_msgs.lidars import Lidar
from voa_msgs.priors import Prior
from voa_msgs.updates import BeamUpdate, UpdateRule
from voa_msgs.warnings import ProbableMistake

MOST_ATTEMPTS = 1_000_000_000
"""Largest number of attempts of a grasp that a score may state."""


class Pose(Message):
    """Pose in which the object may lie."""

    name: Name
    """Name of the pose, unique in the scenario."""
    position: Point3 | None = None
    """Position of the object's frame in the world, metres; null only where `predictions` are given."""
    quaternion_wxyz: Quaternion | None = None
    """Orientation of the object's frame, as a unit quaternion w, x, y, z; null only where `predictions` are given."""


class Grasp(Message):
    """Grasp: a configuration of the gripper from which it attempts to close on the object."""

    name: Name
    """Name of the grasp, unique in the scenario."""
    data: Free = None
    """Any JSON of the user's own, such as joint angles; the service stores it and returns it unchanged."""


class MeasuredScores(Message):
    """Grasp scores that were measured: successes of a number of attempts."""

    attempts: Annotated[int, Ge(1), Le(MOST_ATTEMPTS)]
    """Number of attempts of each grasp at each pose."""
    successes: Annotated[
        list[Annotated[list[Annotated[int, Ge(0), Le(MOST_ATTEMPTS)]], LimitedBy("poses")]], Len(1), LimitedBy("grasps")
    ]
    """Number of successes: one row per grasp, one column per pose."""


class GivenScores(Message):
    """Grasp scores that are given as probabilities."""

    probabilities: Annotated[
        list[Annotated[list[Annotated[float, Ge(0.0), Le(1.0)]], LimitedBy("poses")]], Len(1), LimitedBy("grasps")
    ]
    """Probability of success, 0 to 1: one row per grasp, one column per pose."""


def _form(scores: Any) -> str:
    given = "probabilities" in scores if isinstance(scores, dict) else isinstance(scores, GivenScores)
    return "probabilities" if given else "successes"


Scores = Annotated[
    Annotated[MeasuredScores, Tag("successes")] | Annotated[GivenScores, Tag("probabilities")], Discriminator(_form)
]


class Workspace(Message):
    """Rectangle in the world frame that contains the object; returns from outside it are ignored."""

    min: Point2
    """Smallest x, y, metres."""
    max: Point2
    """Largest x, y, metres."""


class ScenarioRequest(Message):
    """Request to store a scenario: all that is fixed while the pose of an object is estimated."""

    model_config = exemplified(examples.SCENARIO)

    name: Name
    """Name of the scenario, for people; it is part of the content that the identifier is a digest of."""
    object: Id | None = None
    """Identifier of a stored object; null only where `predictions` are given."""
    poses: Annotated[list[Pose], Len(1), LimitedBy("poses")]
    """Poses in which the object may lie."""
    grasps: Annotated[list[Grasp], Len(1), LimitedBy("grasps")]
    """Grasps that the arm can attempt."""
    scores: Scores
    """Grasp scores: the probability, or the measured successes, of each grasp at each pose."""
    sensors: Annotated[list[SensorConfiguration], Len(1), LimitedBy("sensors")]
    """Sensor configurations: the places from which the lidar can look."""
    lidar: Lidar
    """Lidar that takes the scans."""
    update: UpdateRule = BeamUpdate()
    """Update rule: how a scan turns into a weight for each pose."""
    workspace: Workspace | None = None
    """Rectangle that contains the object; returns from outside it are ignored; null: every return counts."""
    min_gain: Annotated[float, Ge(0.0), Le(1.0)] = 0.005
    """Net value, in success probability, that a look must exceed to be recommended, over simulated scans by two
    standard errors."""
    spread: Spread | None = None
    """Spread of the object about each listed pose: standard deviations in the plane; needs a mesh; null: the object
    lies exactly at a listed pose."""
    absent: Annotated[float, Gt(0.0), Lt(1.0)] | None = None
    """Probability, before the first scan, that the object lies at none of the poses; null: it lies at one of them."""
    predictions: (
        Annotated[dict[Name, Annotated[dict[Name, Ranges], LimitedBy("poses")]], LimitedBy("sensors")] | None
    ) = None
    """Predicted scans, metres, by sensor configuration and pose, one range per beam (null: no-return), which replace
    those of the mesh at listed sensors, except for displaced poses (`spread`, `std`); null: all are computed from the
    mesh."""
    prior: Prior | None = None
    """Belief before the first observation: probabilities, or a model of them; null: all poses are equally probable."""


class Scenario(ScenarioRequest):
    """Stored scenario: the request with every default filled in."""

    model_config = ConfigDict(json_schema_extra={})

    id: str
    """Identifier: a digest of the content, name included."""
    warnings: list[ProbableMistake] = Field(default=[])
    """Probable mistakes in the scenario; empty: none was detected."""
    created_at: datetime
    """Time at which the scenario was first stored, UTC."""

    def request(self) -> ScenarioRequest:
        """Return the request that stores this scenario, without the fields that the service added."""
        added = set(Scenario.model_fields) - set(ScenarioRequest.model_fields)
        return ScenarioRequest.model_validate(self.model_dump(exclude=added))


class ScenarioSummary(Message):
    """Summary of a scenario, for a list."""

    id: str
    """Identifier of the scenario."""
    name: str
    """Name of the scenario."""
    object: str | None
    """Identifier of the object; null: the scenario has predictions instead of a mesh."""
    poses: int
    """Number of poses."""
    grasps: int
    """Number of grasps."""
    sensors: int
    """Number of sensor configurations."""
    rule: str
    """Name of the update rule."""
    created_at: datetime
    """Time at which the scenario was first stored, UTC."""


class ScenarioPage(Page):
    """Page of the list of stored scenarios."""

    items: list[ScenarioSummary]
    """Summaries of scenarios, oldest first."""


class PredictionsRequest(Message):
    """Request for the scans that the object would give at each pose."""

    model_config = exemplified(examples.PREDICTIONS)

    sensors: Annotated[list[Candidate], Len(1), LimitedBy("sensors")] | None = None
    """Names of sensor configurations, or any sensor poses; null: all sensor configurations of the scenario."""


class Predictions(Message):
    """Predicted scans of the object at each pose, from the geometry alone: no workspace is applied."""

    sensors: list[str]
    """Names of the sensor configurations or sensor poses, in the order of `ranges`."""
    poses: list[str]
    """Names of the poses, in the order of `ranges`."""
    ranges: list[list[list[Range]]]
    """Predicted ranges, metres: sensors x poses x beams; null: nothing is in range."""
