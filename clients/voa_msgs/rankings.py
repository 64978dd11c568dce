"""Looks ranked by what they are worth, and grasps by what they promise."""

from typing import Annotated, Literal

from annotated_types import Ge, Le, Len
from pydantic import Field

from voa_msgs import examples
from voa_msgs.base import Distribution, Id, Message, Name
from voa_msgs.bounds import LimitedBy
from voa_msgs.examples import exemplified
from voa_msgs.geometry import Candidate

Definition = Literal["posterior", "executed"]


class VoaRequest(Message):
    """Which looks to rank, for which grasps."""

    model_config = exemplified(examples.VOA)

    sensors: Annotated[list[Candidate], Len(1), LimitedBy("sensors")] | None = None
    """Names of the scenario's configurations, or any sensor poses; null: all of the scenario's."""
    definition: Definition = "posterior"
    grasps: Annotated[list[Name], Len(1), LimitedBy("grasps")] | None = None
    """The grasps that are reachable now; null: all."""
    sensor_belief: Distribution | None = None
    """Belief of the agent that carries the lidar, where it differs; null: the session's."""
    min_gain: Annotated[float, Ge(0.0), Le(1.0)] | None = None
    """A look is recommended where its net value exceeds this; null: the scenario's `min_gain`."""
    outcomes: bool = False
    """Whether to list what each look could find."""


class RankingRequest(VoaRequest):
    """A ranking for the belief in the request; nothing is stored."""

    model_config = exemplified(examples.RANKING)

    scenario: Id
    belief: Distribution | None
    """Null: the scenario's prior."""


class Outcome(Message):
    """What a look finds if the object is at `pose`."""

    pose: str
    probability: float
    best_grasp: str | None
    expected_score: float


class RankedSensor(Message):
    """A look and what it is worth, in success probability."""

    sensor: str
    voa: float
    standard_error: float | None
    """Null: exact."""
    cost: float
    net_value: float
    """`voa` - `cost`."""
    expected_score_after: float
    ties_with_first: bool
    """Whether it is worth as much as the first of the ranking, within 1e-6; true for the first itself."""
    outcomes: list[Outcome] | None = None
    """Where asked for."""


class Look(Message):
    """Look from there: it is worth more than it costs, by more than `min_gain`."""

    action: Literal["look"]
    sensor: str
    net_value: float


class GraspNow(Message):
    """No look is worth its cost and `min_gain`: grasp."""

    action: Literal["grasp"]
    grasp: str | None
    expected_score: float


class Ranking(Message):
    """Looks, the best net value first."""

    version: int | None
    definition: Definition
    method: Literal["exact", "sampled"]
    precision: Literal["float64", "float32"]
    expected_score_before: float
    best_grasp_before: str | None
    ranking: list[RankedSensor]
    recommendation: Annotated[Look | GraspNow, Field(discriminator="action")]


class RankedGrasp(Message):
    """A grasp and its expected score."""

    name: str
    expected_score: float


class RankedGrasps(Message):
    """Grasps, the best expected score first."""

    version: int
    grasps: list[RankedGrasp]
