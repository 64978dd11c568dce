"""Scenarios: object, poses, grasps, scores, lidar, sensor configurations, update rule, prior."""

from datetime import datetime
from typing import Annotated, Any

from annotated_types import Ge, Le, Len
from pydantic import ConfigDict, Discriminator, Field, Tag

from voa_msgs import examples
from voa_msgs.base import Free, Id, Message, Name, Page, Point2, Point3, Quaternion, Range, Ranges
from voa_msgs.bounds import LimitedBy
from voa_msgs.examples import exemplified
from voa_msgs.geometry import Candidate, SensorConfiguration
from voa_msgs.lidars import Lidar
from voa_msgs.priors import Prior
from voa_msgs.updates import BeamUpdate, UpdateRule
from voa_msgs.warnings import ProbableMistake

MOST_ATTEMPTS = 1_000_000_000


class Pose(Message):
    """A pose that the object may have; its geometry may be absent where all predictions are given."""

    name: Name
    position: Point3 | None = None
    """Of the object's frame in the world, metres."""
    quaternion_wxyz: Quaternion | None = None


class Grasp(Message):
    """A gripper configuration to attempt the grasp from."""

    name: Name
    data: Free = None
    """The user's own; kept and returned."""


class MeasuredScores(Message):
    """Successes of attempts, grasps x poses."""

    attempts: Annotated[int, Ge(1), Le(MOST_ATTEMPTS)]
    successes: Annotated[
        list[Annotated[list[Annotated[int, Ge(0), Le(MOST_ATTEMPTS)]], LimitedBy("poses")]], Len(1), LimitedBy("grasps")
    ]


class GivenScores(Message):
    """Probabilities of success, grasps x poses."""

    probabilities: Annotated[
        list[Annotated[list[Annotated[float, Ge(0.0), Le(1.0)]], LimitedBy("poses")]], Len(1), LimitedBy("grasps")
    ]


def _form(scores: Any) -> str:
    given = "probabilities" in scores if isinstance(scores, dict) else isinstance(scores, GivenScores)
    return "probabilities" if given else "successes"


Scores = Annotated[
    Annotated[MeasuredScores, Tag("successes")] | Annotated[GivenScores, Tag("probabilities")], Discriminator(_form)
]


class Workspace(Message):
    """A box over the table in the world frame; what the lidar sees outside of it is not the object."""

    min: Point2
    max: Point2


class ScenarioRequest(Message):
    """What stays the same while one object is looked at."""

    model_config = exemplified(examples.SCENARIO)

    name: Name
    object: Id | None = None
    """Id of a stored object; null where all predictions are given."""
    poses: Annotated[list[Pose], Len(1), LimitedBy("poses")]
    grasps: Annotated[list[Grasp], Len(1), LimitedBy("grasps")]
    scores: Scores
    sensors: Annotated[list[SensorConfiguration], Len(1), LimitedBy("sensors")]
    lidar: Lidar
    update: UpdateRule = BeamUpdate()
    workspace: Workspace | None = None
    min_gain: Annotated[float, Ge(0.0), Le(1.0)] = 0.005
    """A look is recommended where its net value, in success probability, exceeds this."""
    predictions: (
        Annotated[dict[Name, Annotated[dict[Name, Ranges], LimitedBy("poses")]], LimitedBy("sensors")] | None
    ) = None
    """Per sensor and pose the ranges of all beams; null: no-return. They win over the mesh."""
    prior: Prior | None = None
    """Null: uniform."""


class Scenario(ScenarioRequest):
    """A stored scenario: the request with every default filled in."""

    model_config = ConfigDict(json_schema_extra={})

    id: str
    """Digest of the content, name included."""
    warnings: list[ProbableMistake] = Field(default=[])
    created_at: datetime

    def request(self) -> ScenarioRequest:
        """Return the request that makes this very scenario, without what the service added to it."""
        added = set(Scenario.model_fields) - set(ScenarioRequest.model_fields)
        return ScenarioRequest.model_validate(self.model_dump(exclude=added))


class ScenarioSummary(Message):
    """A scenario in a list."""

    id: str
    name: str
    object: str | None
    poses: int
    grasps: int
    sensors: int
    rule: str
    created_at: datetime


class ScenarioPage(Page):
    """Stored scenarios, oldest first."""

    items: list[ScenarioSummary]


class PredictionsRequest(Message):
    """The sensor poses to predict from; null: the scenario's own configurations."""

    model_config = exemplified(examples.PREDICTIONS)

    sensors: Annotated[list[Candidate], Len(1), LimitedBy("sensors")] | None = None


class Predictions(Message):
    """Predicted scans: sensors x poses x beams, metres, null where nothing is in range; no workspace applied."""

    sensors: list[str]
    poses: list[str]
    ranges: list[list[list[Range]]]
