"""Which robot's topics feed which session: the mapping that an operator writes, as TOML.

```toml
[[robot]]
name = "tb3_1"                  # of this mapping; also the namespace of its topics, unless that is given
session = "4f1c..."             # or scenario = "...": the session on it that claims the robot, else the newest
scan = "scan"                   # below the namespace, or absolute with a leading "/"
domain = 0                      # ROS_DOMAIN_ID, of rmw_zenoh's keys
frame_id = "base_scan"          # only scans of this frame; left out: all, and two frames on the topic are refused
stamp = "first_ray"             # when header.stamp is taken; the LDS-01's driver: "after_revolution"
lidar = { x = -0.032, y = 0.0, yaw_rad = 0.0, height_m = 0.18, upside_down = false }  # in the base frame
look = { mode = "stationary", scans = 10 }

[robot.place]
from = "odometry"
origin = { x = 0.4, y = 0.0, yaw_rad = 3.14 }  # the odometry frame in the world frame
```

`place.from` says where the lidar was at each scan:

| from           | where it was                                                                              |
|----------------|-------------------------------------------------------------------------------------------|
| `"sensor"`     | at the scenario's sensor configuration that `sensor` names                                |
| `"attachment"` | as each sample's attachment says: a sensor configuration, or a pose of the lidar          |
| `"odometry"`   | where the odometry says, from `origin`                                                    |
| `"amcl"`       | where AMCL says, carried on by the odometry: AMCL is silent while the robot stands still  |

With the first two it is the lidar's own pose that is named, and `lidar` says nothing that matters.
"""

import math
import tomllib
from collections import Counter
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, Field, StringConstraints, ValidationError, model_validator
from pydantic_core import ErrorDetails

from voa_msgs.base import MOST, Id, Message, Name, Real
from voa_msgs.geometry import PoseUncertainty
from voa_msgs.reading import by_weight, problem
from voa_ros.messages import FARTHEST_M
from voa_ros.topics import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE_STAMPED, MessageType, resolve

MOST_SCANS = 200
_MOST_DOMAIN = 232
"""The largest ROS_DOMAIN_ID that DDS has ports for."""


class InvalidRobots(ValueError):
    """A mapping that cannot be used; says which robot and field, and what was expected."""


Coordinate = Annotated[float, Ge(-FARTHEST_M), Le(FARTHEST_M)]
Yaw = Annotated[float, Ge(-100.0), Le(100.0)]
Tolerance = Annotated[float, Gt(0.0), Le(MOST)]
Seconds = Annotated[float, Gt(0.0), Le(MOST)]
RobotName = Annotated[str, StringConstraints(min_length=1, max_length=128, pattern=r"^[A-Za-z0-9_.-]+$")]


def _topic(topic: str) -> str:
    resolve("", topic)
    return topic


def _namespace(namespace: str) -> str:
    resolve(namespace, "topic")
    return namespace


Topic = Annotated[str, AfterValidator(_topic)]
Namespace = Annotated[str, AfterValidator(_namespace)]


class PlanarPose(Message):
    """One frame in another, on the floor."""

    x: Coordinate = 0.0
    """Metres."""
    y: Coordinate = 0.0
    yaw_rad: Yaw = 0.0


class Mount(PlanarPose):
    """The lidar on the robot: its pose in the frame of the base."""

    height_m: Real | None = None
    """Height of the scan plane over the table; null: the scenario's lidar's."""
    upside_down: bool = False
    """Whether the lidar hangs upside down (rolled over about its +x axis): its angles then count clockwise."""


class SensorPlace(Message):
    """The lidar stands at a sensor configuration."""

    source: Literal["sensor"] = Field(alias="from")
    sensor: Name


class AttachmentPlace(Message):
    """Each sample says itself where it was taken."""

    source: Literal["attachment"] = Field(alias="from")


class OdometryPlace(Message):
    """The robot's odometry, from a known start."""

    source: Literal["odometry"] = Field(alias="from")
    topic: Topic = "odom"
    origin: PlanarPose = PlanarPose()
    """The odometry frame in the world frame."""
    std: PoseUncertainty | None = None
    """How well the lidar's pose is known; null: exactly."""
    max_age_s: Seconds = 0.2
    """How far a scan's time and that of the pose may be apart."""


class AmclPlace(Message):
    """AMCL's pose in a map, carried on by odometry.

    AMCL speaks only after the robot has moved on by its `update_min_d` (0.25 m). Its newest pose alone would have a
    robot that creeps stand still, and would be old for one that stands. So each of its poses corrects the odometry.
    """

    source: Literal["amcl"] = Field(alias="from")
    topic: Topic = "amcl_pose"
    odometry: Topic = "odom"
    origin: PlanarPose = PlanarPose()
    """The map in the world frame."""
    std: PoseUncertainty | None = None
    """How well the lidar's pose is known; null: by AMCL's covariance."""
    max_age_s: Seconds = 0.2
    """How far a scan's time and that of the odometry may be apart."""
    max_carried_m: Tolerance = 1.0
    """How far the odometry may carry AMCL's newest pose; farther on, AMCL is taken to be gone."""


Place = Annotated[SensorPlace | AttachmentPlace | OdometryPlace | AmclPlace, Field(discriminator="source")]


class LookRule(Message):
    """When scans are a look; see `voa_ros.looks`."""

    mode: Literal["stationary", "on_request", "every"] = "stationary"
    scans: Annotated[int, Ge(1), Le(MOST_SCANS)] = 10
    """Revolutions in one look (`every`: one)."""
    still_xy_m: Tolerance = 0.005
    """Standing still is to move by less, from one revolution to the next and since the first of the stop."""
    still_yaw_rad: Tolerance = math.radians(0.5)
    moved_xy_m: Tolerance = 0.02
    """Having moved on is to stand farther from where the last look was taken, or more turned."""
    moved_yaw_rad: Tolerance = math.radians(2.0)

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        if self.mode != "every" and self.scans < 2:
            raise ValueError(
                f"scans: expected at least 2 in mode {self.mode!r}: one does not show that the robot stands"
            )
        if self.moved_xy_m < self.still_xy_m or self.moved_yaw_rad < self.still_yaw_rad:
            raise ValueError("expected moved_xy_m and moved_yaw_rad to be at least still_xy_m and still_yaw_rad")
        return self


@dataclass(frozen=True)
class Subscription:
    """A topic that a mapping needs, resolved."""

    topic: str
    type: MessageType


class RobotMapping(Message):
    """One robot's scans, and the session that they are for."""

    name: RobotName
    session: Id | None = None
    scenario: Id | None = None
    """Instead of a session: the session on this scenario that claims the robot, else the newest at its first look."""
    namespace: Namespace | None = None
    """Of its topics; null: the name; "": none."""
    scan: Topic = "scan"
    domain: Annotated[int, Ge(0), Le(_MOST_DOMAIN)] = 0
    """ROS_DOMAIN_ID of its nodes, where they publish by rmw_zenoh; a bridge's keys have no domain."""
    frame_id: Annotated[str, StringConstraints(min_length=1, max_length=256)] | None = None
    """Only scans of this frame are used; null: all, as long as they are of one frame."""
    stamp: Literal["first_ray", "after_revolution"] = "first_ray"
    lidar: Mount = Mount()
    look: LookRule = LookRule()
    place: Place

    @model_validator(mode="after")
    def _one_session(self) -> Self:
        if (self.session is None) == (self.scenario is None):
            raise ValueError("expected exactly one of 'session' and 'scenario'")
        return self

    @model_validator(mode="after")
    def _own_namespace(self) -> Self:
        if self.namespace is None:
            try:
                _namespace(self.name)
            except ValueError as error:
                raise ValueError("namespace: expected one, since the name is none that ROS could have") from error
        return self

    def topic(self, topic: str) -> str:
        """A topic of this robot, resolved."""
        return resolve(self.name if self.namespace is None else self.namespace, topic)

    @property
    def scan_topic(self) -> str:
        """Where its scans are, resolved."""
        return self.topic(self.scan)

    @property
    def odometry_topic(self) -> str | None:
        """Where its odometry is, resolved; None where it is not needed."""
        match self.place:
            case OdometryPlace(topic=topic) | AmclPlace(odometry=topic):
                return self.topic(topic)
            case _:
                return None

    @property
    def amcl_topic(self) -> str | None:
        """Where AMCL's poses are, resolved; None where they are not needed."""
        return self.topic(self.place.topic) if isinstance(self.place, AmclPlace) else None

    @property
    def subscriptions(self) -> tuple[Subscription, ...]:
        """All topics to listen to, that of the scans first."""
        topics = [
            (self.scan_topic, LASER_SCAN),
            (self.odometry_topic, ODOMETRY),
            (self.amcl_topic, POSE_WITH_COVARIANCE_STAMPED),
        ]
        return tuple(Subscription(topic, type_) for topic, type_ in topics if topic is not None)


class _File(Message):
    robot: list[RobotMapping] = Field(default=[])

    @model_validator(mode="after")
    def _named_once(self) -> Self:
        twice = [name for name, count in Counter(robot.name for robot in self.robot).items() if count > 1]
        if twice:
            raise ValueError(f"robot: {twice[0]!r} twice: expected each name once")
        return self


def load(text: str) -> tuple[RobotMapping, ...]:
    """Read a mapping.

    Args:
        text: TOML, as above.

    Raises:
        InvalidRobots: it is not TOML, or something in it is not as expected; all that is wrong, a line each.
    """
    try:
        told = tomllib.loads(text.removeprefix("\ufeff"))  # the byte order mark that some editors write
    except tomllib.TOMLDecodeError as error:
        raise InvalidRobots(f"expected TOML: {error}") from error
    try:
        return tuple(_File.model_validate(told).robot)
    except ValidationError as error:
        raise InvalidRobots("\n".join(_line(told, one) for one in by_weight(error.errors()))) from error


_PLACES = ("sensor", "attachment", "odometry", "amcl")


def _line(told: dict[str, Any], error: ErrorDetails) -> str:
    """Say what one error is, by robot and field."""
    loc = error["loc"]
    where = [str(part) for at, part in enumerate(loc) if (at, loc[2:3]) != (3, ("place",))]  # less the place's kind
    match error["type"]:
        case "model_type":
            what = "expected a table"
        case "finite_number":  # TOML has NaN and infinity, other than JSON
            what = f"expected a finite number, got {error['input']}"
        case "union_tag_invalid" | "union_tag_not_found":
            where.append("from")
            what = f"expected one of {', '.join(_PLACES)}"
        case _:
            what = problem(_File, error)
    if len(loc) < 2:
        return ": ".join([*where, what])
    robot = told["robot"][loc[1]]
    name = robot.get("name") if isinstance(robot, dict) else None
    called = f"robot {name!r}" if isinstance(name, str) else f"robot no. {int(loc[1]) + 1}"
    return ": ".join(part for part in (called, ".".join(where[2:]), what) if part)
