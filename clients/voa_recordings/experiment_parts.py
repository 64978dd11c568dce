"""Parts of a recorded experiment as its JSON files hold them: poses, sensors, lidar, and expected results."""

from collections import Counter
from typing import Annotated, Any, Self, TypeGuard

from annotated_types import Gt
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, field_validator, model_validator

from voa_client import VoaClientError
from voa_msgs.base import Point3, Quaternion
from voa_recordings.selection import Selection

_ON_GRID = 0.01  # of a beam spacing


class InvalidExperiment(VoaClientError):
    """A folder is not a recorded experiment, or lacks something; the message says what."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class ExperimentPose(_Part):
    """A pose of the object: its name, and, where known, position (metres) and orientation."""

    name: str
    position: Point3 | None = None
    quaternion_wxyz: Quaternion | None = None


class ExperimentSensor(_Part):
    """A sensor configuration: where the lidar stood, metres and degrees in the world frame."""

    name: str
    x: float = 0.0
    y: float = 0.0
    yaw_deg: float = 0.0


class ExperimentObject(_Part):
    """The object: the name of its mesh file in the folder, and the metres per unit of that file."""

    mesh: str
    scale: Annotated[float, Gt(0.0)] = 1.0


def _turning(increment_deg: float) -> float:
    if increment_deg == 0.0:
        raise ValueError("expected a number other than 0")
    return increment_deg


class ExperimentLidar(_Part):
    """Beams and range limits of the lidar, degrees and metres."""

    beams: Annotated[int, Gt(0)] = 360
    angle_min_deg: float = 0.0
    angle_increment_deg: Annotated[float, AfterValidator(_turning)] = 1.0
    range_min: float = 0.12
    range_max: float = 3.5

    def beam(self, angle_deg: float) -> int:
        """Return the index of the beam at an angle, whole turns apart; raises InvalidExperiment if there is none."""
        for turn in (0.0, 360.0, -360.0):
            exact = (angle_deg + turn - self.angle_min_deg) / self.angle_increment_deg
            if abs(exact - round(exact)) <= _ON_GRID and 0 <= round(exact) < self.beams:
                return round(exact)
        raise InvalidExperiment(
            f"there is no beam at {angle_deg} degrees: {self.beams} beams from {self.angle_min_deg} "
            f"by {self.angle_increment_deg} degrees"
        )


class ExpectedLook(_Part):
    """Expected value of looking from a sensor configuration, in success probability; None: not defined.

    Attributes:
        voa: over predicted scans.
        aecd: over measured scans.
        belief_after_measured_scan: by the pose at which the scan was measured; a probability by pose.
    """

    voa: float | None
    aecd: float | None
    belief_after_measured_scan: dict[str, dict[str, float]] = {}


class ExpectedBefore(_Part):
    """Expected best grasp before any look, and the probability that it succeeds."""

    best_grasp: str | None
    expected_score: float


class ExpectedResults(_Part):
    """Content of `expected.json`: the values of looks, by update rule and sensor configuration."""

    before: ExpectedBefore
    rules: dict[str, dict[str, ExpectedLook]]


class Observation(_Part):
    """Meaning of measured ranges: from `no_return` metres on, a beam counts as a no-return."""

    no_return: Annotated[float, Gt(0.0)] = 1.0


class ExperimentFile(_Part):
    """Content of `experiment.json`."""

    name: str
    poses: Annotated[list[ExperimentPose], Field(min_length=1)]
    sensors: Annotated[list[ExperimentSensor], Field(min_length=1)]
    grasps: Annotated[list[str], Field(min_length=1)]
    scores: dict[str, dict[str, float]] | None = None
    successes: dict[str, dict[str, int]] | None = None
    attempts: int | None = None
    object: ExperimentObject | None = None
    lidar: ExperimentLidar = ExperimentLidar()
    observation: Observation = Observation()
    selection: Selection | None = None

    @field_validator("poses", "sensors", mode="before")
    @classmethod
    def _name_alone(cls, items: Any) -> Any:
        return [{"name": item} if isinstance(item, str) else item for item in items] if _is_list(items) else items

    @field_validator("grasps", mode="before")
    @classmethod
    def _names(cls, items: Any) -> Any:
        if not _is_list(items):
            return items
        return [item["name"] if isinstance(item, dict) and "name" in item else item for item in items]

    @model_validator(mode="after")
    def _named_once(self) -> Self:
        for what, names in (
            ("poses", [pose.name for pose in self.poses]),
            ("sensors", [sensor.name for sensor in self.sensors]),
            ("grasps", self.grasps),
        ):
            twice = [name for name, count in Counter(names).items() if count > 1]
            if twice:
                raise ValueError(f"{what}: {twice[0]!r} twice")
        return self


def _is_list(items: Any) -> TypeGuard[list[Any]]:
    return isinstance(items, list)
