"""Topics for ROS tools in the mapping of a robot: those that the service publishes, and those that it receives.

Nothing is published, and nothing but scans and poses is received, unless the mapping of a robot switches it on:

```toml
[robot.outputs]
belief = true               # true: the usual topic, below the namespace of the robot: voa/belief
markers = "/voa/markers"    # or another topic
place = "goal_pose"         # Nav2 drives to each pose that is published there
meshes = "http://lab:8000"  # address at which RViz reads the mesh of the object from this service

[robot.inputs]
prior = "/initialpose"      # "2D Pose Estimate" of RViz marks the object
outcome = true              # voa/outcome: true or false, after the attempt of the best grasp
```

| output       | usual topic      | type                             | content                                         |
|--------------|------------------|----------------------------------|-------------------------------------------------|
| `belief`     | `voa/belief`     | `vision_msgs/Detection3D`        | a hypothesis for each pose                      |
| `poses`      | `voa/poses`      | `geometry_msgs/PoseArray`        | poses that hold 95 % of the belief              |
| `markers`    | `voa/markers`    | `visualization_msgs/MarkerArray` | the scene: belief, looks, scan, robot, grasp    |
| `grasps`     | `voa/grasps`     | `moveit_msgs/Grasp`              | the ten best grasps, a message each             |
| `best_grasp` | `voa/best_grasp` | `geometry_msgs/PoseStamped`      | the tool's pose at the best grasp               |
| `place`      | `voa/place`      | `geometry_msgs/PoseStamped`      | the robot's base pose for the recommended look  |
| `numbers`    | `voa/numbers`    | `std_msgs/Float64`               | `entropy_nats`, `expected_score`, `fit_rmsd_mm` |
"""

from collections.abc import Callable
from typing import Annotated, Any, Literal

from annotated_types import Ge, Le
from pydantic import AfterValidator, BeforeValidator, StringConstraints

from voa_msgs.base import Message
from voa_ros.robot_places import Topic

NUMBERS = ("entropy_nats", "expected_score", "fit_rmsd_mm")
"""Names of the topics of numbers, below the topic of the output `numbers`."""
Frame = Annotated[str, StringConstraints(min_length=1, max_length=256)]
"""Name of a coordinate frame (`frame_id`)."""


def _switch(usual: str) -> Callable[[Any], Any]:
    """Return a validator that reads true as the usual topic, and false as none."""

    def topic(given: Any) -> Any:
        if isinstance(given, bool):
            return usual if given else None
        if given is None or isinstance(given, str):
            return given
        raise ValueError(f"expected true, false or a topic, got {given!r}")

    return topic


def _address(address: str) -> str:
    """Return an address without a slash at its end; raises ValueError unless it is one of HTTP."""
    if not address.startswith(("http://", "https://")):
        raise ValueError(f"expected an address such as http://lab:8000, got {address!r}")
    return address.rstrip("/")


class Outputs(Message):
    """Topics that the service publishes for ROS tools about the session of a robot; each is off unless stated."""

    belief: Annotated[Topic | None, BeforeValidator(_switch("voa/belief"))] = None
    """Topic of the belief as a `vision_msgs/msg/Detection3D`; true: `voa/belief`; null: not published."""
    poses: Annotated[Topic | None, BeforeValidator(_switch("voa/poses"))] = None
    """Topic of the likeliest poses as a `geometry_msgs/msg/PoseArray`; true: `voa/poses`; null: not published."""
    markers: Annotated[Topic | None, BeforeValidator(_switch("voa/markers"))] = None
    """Topic of the scene as a `visualization_msgs/msg/MarkerArray`; true: `voa/markers`; null: not published."""
    grasps: Annotated[Topic | None, BeforeValidator(_switch("voa/grasps"))] = None
    """Topic of the best grasps, each a `moveit_msgs/msg/Grasp`; true: `voa/grasps`; null: not published."""
    best_grasp: Annotated[Topic | None, BeforeValidator(_switch("voa/best_grasp"))] = None
    """Topic of the best grasp as a `geometry_msgs/msg/PoseStamped`; true: `voa/best_grasp`; null: not published."""
    place: Annotated[Topic | None, BeforeValidator(_switch("voa/place"))] = None
    """Topic of the recommended place as a `geometry_msgs/msg/PoseStamped`; true: `voa/place`; null: not published."""
    numbers: Annotated[Topic | None, BeforeValidator(_switch("voa/numbers"))] = None
    """Topic below which numbers are published, each a `std_msgs/msg/Float64`; true: `voa/numbers`; null: not."""
    frame_id: Frame = "world"
    """Frame of all poses but those of `place`: the world frame of the scenario."""
    place_frame_id: Frame | None = None
    """Frame of the poses of `place`; null: `map` with `place.from = "amcl"`, `odom` with `"odometry"`, else
    `frame_id`."""
    meshes: Annotated[str, AfterValidator(_address)] | None = None
    """Address at which tools reach this service by HTTP, for the mesh of the markers; null: the markers have the
    triangles of a coarser mesh."""
    middleware: Literal["bridge", "rmw_zenoh"] = "bridge"
    """Middleware of the ROS tools, which decides on the keys: zenoh-bridge-ros2dds, or rmw_zenoh."""
    repeat_s: Annotated[float, Ge(0.2), Le(60.0)] = 2.0
    """Seconds after which the newest messages are published again, for tools that were started after them; those of
    `place` are not, because Nav2 would drive there again."""

    @property
    def needs_ranking(self) -> bool:
        """True if an output shows the ranking of places."""
        return self.place is not None or self.markers is not None

    @property
    def topics(self) -> list[str]:
        """Topics that are switched on, those of numbers included, not resolved."""
        single = (self.belief, self.poses, self.markers, self.grasps, self.best_grasp, self.place)
        return [*(topic for topic in single if topic is not None), *self.number_topics]

    @property
    def number_topics(self) -> list[str]:
        """Topics of the numbers, in the order of `NUMBERS`; empty: they are off."""
        return [] if self.numbers is None else [f"{self.numbers}/{name}" for name in NUMBERS]


class Inputs(Message):
    """Topics by which ROS tools change the session of a robot; each is off unless stated."""

    prior: Annotated[Topic | None, BeforeValidator(_switch("voa/prior"))] = None
    """Topic of a `geometry_msgs/msg/PoseWithCovarianceStamped` that states where the object lies; true: `voa/prior`;
    null: not received."""
    outcome: Annotated[Topic | None, BeforeValidator(_switch("voa/outcome"))] = None
    """Topic of a `std_msgs/msg/Bool`: true if the attempt of the best grasp succeeded; true: `voa/outcome`; null: not
    received."""
    object_moved: Annotated[float, Ge(0.0), Le(1.0)] = 0.0
    """Probability that an attempt moved the object, which goes with each outcome."""

    @property
    def topics(self) -> list[str]:
        """Topics that are switched on, not resolved."""
        return [topic for topic in (self.prior, self.outcome) if topic is not None]
