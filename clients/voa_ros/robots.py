"""Mapping of robots that an operator writes as TOML: the session to which the scans of each robot are applied.

```toml
[[robot]]
name = "tb3_1"                  # name in this mapping; also the namespace of its topics, unless `namespace` is given
session = "4f1c..."             # or scenario = "...": the session on it that claims the robot, else the newest
scan = "scan"                   # topic of the scans, below the namespace, or absolute with a leading "/"
domain = 0                      # ROS_DOMAIN_ID in the keys of rmw_zenoh
frame_id = "base_scan"          # use scans of this frame only; without it, a topic with two frames is refused
stamp = "first_ray"             # the instant of header.stamp; with the LDS-01's driver: "after_revolution"
lidar = { x = -0.032, y = 0.0, yaw_rad = 0.0, height_m = 0.18, upside_down = false }  # in the base frame
look = { mode = "stationary", scans = 10 }

[robot.place]
from = "odometry"
origin = { x = 0.4, y = 0.0, yaw_rad = 3.14 }  # the odometry frame in the world frame
```

`place.from` is the source of the lidar's pose at each scan:

| from           | pose of the lidar                                                                           |
|----------------|---------------------------------------------------------------------------------------------|
| `"sensor"`     | the sensor configuration of the scenario that `sensor` names                                |
| `"attachment"` | the sensor configuration, or the pose of the lidar, that the attachment of the scan states  |
| `"odometry"`   | the pose of the odometry, whose frame is at `origin` in the world                           |
| `"amcl"`       | the pose of AMCL, carried forward by odometry: AMCL is silent while the robot stands still  |

The first two state the pose of the lidar itself, so that `lidar.x`, `lidar.y` and `lidar.yaw_rad` are not used.
`[robot.outputs]` and `[robot.inputs]` switch on topics for ROS tools: see `robot_outputs`.
"""

import math
import tomllib
from collections import Counter
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from annotated_types import Ge, Le
from pydantic import AfterValidator, Field, StringConstraints, ValidationError, model_validator
from pydantic_core import ErrorDetails

from voa_msgs.base import Id, Message
from voa_msgs.reading import by_weight, problem
from voa_ros.robot_outputs import Inputs, Outputs
from voa_ros.robot_places import AmclPlace, Mount, OdometryPlace, Place, Tolerance, Topic
from voa_ros.topics import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE_STAMPED, MessageType, resolve

MOST_SCANS = 200
"""Most revolutions in one look."""
_MOST_DOMAIN = 232
"""The largest ROS_DOMAIN_ID that DDS has ports for."""


class InvalidRobots(ValueError):
    """Error for a mapping that cannot be used; its text names the robot and the field, and says what was expected."""


RobotName = Annotated[str, StringConstraints(min_length=1, max_length=128, pattern=r"^[A-Za-z0-9_.-]+$")]
"""Name of a robot in a mapping."""


def _namespace(namespace: str) -> str:
    resolve(namespace, "topic")
    return namespace


Namespace = Annotated[str, AfterValidator(_namespace)]
"""Namespace of the topics of a robot: any number of chunks, with or without a leading slash."""


class LookRule(Message):
    """Rule by which the scans of a robot become looks; `voa_ros.look_taker` explains the modes."""

    mode: Literal["stationary", "on_request", "every"] = "stationary"
    """Mode: a look at each stop, a look after each request, or each scan is a look."""
    scans: Annotated[int, Ge(1), Le(MOST_SCANS)] = 10
    """Number of revolutions in one look; in mode `every` it is 1."""
    still_xy_m: Tolerance = 0.005
    """Largest move, metres, since the previous and since the first revolution of a stop, of a robot that stands."""
    still_yaw_rad: Tolerance = math.radians(0.5)
    """Largest turn, radians, since the previous and since the first revolution of a stop, of a robot that stands."""
    moved_xy_m: Tolerance = 0.02
    """Distance, metres, from the place of the last look beyond which the robot has moved on."""
    moved_yaw_rad: Tolerance = math.radians(2.0)
    """Turn, radians, from the place of the last look beyond which the robot has moved on."""

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        if self.mode != "every" and self.scans < 2:
            raise ValueError(
                f"scans: expected at least 2 in mode {self.mode!r}: one does not show that the robot stands still"
            )
        if self.moved_xy_m < self.still_xy_m or self.moved_yaw_rad < self.still_yaw_rad:
            raise ValueError("expected moved_xy_m and moved_yaw_rad to be at least still_xy_m and still_yaw_rad")
        return self


@dataclass(frozen=True)
class Subscription:
    """Topic to which a mapping needs a subscription.

    Attributes:
        topic: name of the topic, resolved with the namespace.
        type: type of its messages.
    """

    topic: str
    type: MessageType


class RobotMapping(Message):
    """Mapping of one robot: its topics, the session for its scans, its lidar, and the rule for looks."""

    name: RobotName
    """Name of the robot, unique in the mapping."""
    session: Id | None = None
    """Identifier of the session to which the scans are applied; null: `scenario` selects the session."""
    scenario: Id | None = None
    """Identifier of a scenario: the session on it that claims the robot gets the scans, else the newest session."""
    namespace: Namespace | None = None
    """Namespace of the topics; null: the name of the robot; "": none."""
    scan: Topic = "scan"
    """Topic of the scans."""
    domain: Annotated[int, Ge(0), Le(_MOST_DOMAIN)] = 0
    """ROS_DOMAIN_ID of the nodes, where they publish by rmw_zenoh; the keys of a bridge have no domain."""
    frame_id: Annotated[str, StringConstraints(min_length=1, max_length=256)] | None = None
    """Frame of the scans that are used; null: all scans, which must have one frame."""
    stamp: Literal["first_ray", "after_revolution"] = "first_ray"
    """Instant of the stamp of a scan: its first ray, or the end of its revolution."""
    lidar: Mount = Mount()
    """Pose of the lidar on the robot."""
    look: LookRule = LookRule()
    """Rule by which scans become looks."""
    place: Place
    """Source of the poses at which scans are taken."""
    outputs: Outputs = Outputs()
    """Topics that the service publishes for ROS tools."""
    inputs: Inputs = Inputs()
    """Topics by which ROS tools change the session."""

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
                raise ValueError(
                    "namespace: expected one, because the name of the robot cannot be a ROS namespace"
                ) from error
        return self

    @model_validator(mode="after")
    def _topics_differ(self) -> Self:
        for topic, count in Counter([*self.inputs.topics, *self.outputs.topics]).items():
            if count > 1:
                raise ValueError(f"outputs and inputs: expected topics that differ, {topic!r} is used {count} times")
        return self

    def topic(self, topic: str) -> str:
        """Resolve a topic of this robot with its namespace."""
        return resolve(self.name if self.namespace is None else self.namespace, topic)

    @property
    def scan_topic(self) -> str:
        """Topic of the scans, resolved."""
        return self.topic(self.scan)

    @property
    def odometry_topic(self) -> str | None:
        """Topic of the odometry, resolved; None: the mapping needs no odometry."""
        match self.place:
            case OdometryPlace(topic=topic) | AmclPlace(odometry=topic):
                return self.topic(topic)
            case _:
                return None

    @property
    def amcl_topic(self) -> str | None:
        """Topic of AMCL's poses, resolved; None: the mapping needs none."""
        return self.topic(self.place.topic) if isinstance(self.place, AmclPlace) else None

    @property
    def subscriptions(self) -> tuple[Subscription, ...]:
        """List the topics to subscribe to, that of the scans first."""
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
            raise ValueError(f"robot: the name {twice[0]!r} is given twice: expected a different name for each robot")
        return self

    @model_validator(mode="after")
    def _outputs_differ(self) -> Self:
        used: dict[str, str] = {}
        for robot in self.robot:
            for topic in map(robot.topic, robot.outputs.topics):
                if topic in used:
                    raise ValueError(
                        f"robot: the output {topic!r} of {robot.name!r} is one of {used[topic]!r} too: expected "
                        "another topic for each robot"
                    )
                used[topic] = robot.name
        for robot in self.robot:
            received = [*(each.topic for each in robot.subscriptions), *map(robot.topic, robot.inputs.topics)]
            for topic in received:
                if topic in used:
                    raise ValueError(
                        f"robot: {topic!r} is an output of {used[topic]!r}: expected another topic for {robot.name!r}"
                    )
        return self


def load(text: str) -> tuple[RobotMapping, ...]:
    """Read a mapping of robots.

    Args:
        text: TOML, as the docstring of this module shows it.

    Raises:
        InvalidRobots: the text is not TOML or not a valid mapping; the error lists every mistake on a line of its own.
    """
    try:
        document = tomllib.loads(text.removeprefix("\ufeff"))  # the byte order mark that some editors write
    except tomllib.TOMLDecodeError as error:
        raise InvalidRobots(f"expected TOML: {error}") from error
    try:
        return tuple(_File.model_validate(document).robot)
    except ValidationError as error:
        raise InvalidRobots("\n".join(_line(document, one) for one in by_weight(error.errors()))) from error


_PLACES = ("sensor", "attachment", "odometry", "amcl")


def _line(document: dict[str, Any], error: ErrorDetails) -> str:
    """Describe an error in one line, with the robot and the field."""
    loc = error["loc"]
    where = [
        str(part) for at, part in enumerate(loc) if (at, loc[2:3]) != (3, ("place",))
    ]  # without the tag of the place
    match error["type"]:
        case "model_type":
            what = "expected a table"
        case "finite_number":  # unlike JSON, TOML has NaN and infinity
            what = f"expected a finite number, got {error['input']}"
        case "union_tag_invalid" | "union_tag_not_found":
            where.append("from")
            what = f"expected one of {', '.join(_PLACES)}"
        case _:
            what = problem(_File, error)
    if len(loc) < 2:
        return ": ".join([*where, what])
    robot = document["robot"][loc[1]]
    name = robot.get("name") if isinstance(robot, dict) else None
    called = f"robot {name!r}" if isinstance(name, str) else f"robot no. {int(loc[1]) + 1}"
    return ": ".join(part for part in (called, ".".join(where[2:]), what) if part)
