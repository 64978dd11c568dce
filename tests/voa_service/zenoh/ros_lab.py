"""A service with a mapping of ROS 2 robots, and their messages as drivers write them: made by rosbags."""

import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from tests.support.bus import Stranger, bridged, stranger
from tests.support.routers import Router
from tests.support.serving import Json, Service, serving
from tests.support.waiting import wait_for
from voa_service.settings import Limits

ROS = get_typestore(Stores.ROS2_JAZZY)
GOOD = (0.5, 0.5, math.inf, 1.0)

Types = ROS.types


def stamp(at_s: float) -> Any:
    return Types["builtin_interfaces/msg/Time"](sec=int(at_s), nanosec=round(1e9 * (at_s % 1)))


def header(at_s: float, frame: str) -> Any:
    return Types["std_msgs/msg/Header"](stamp=stamp(at_s), frame_id=frame)


def laser_scan(ranges: Sequence[float], at_s: float, increment: float = 0.1) -> bytes:
    """A LaserScan as a driver's middleware writes it."""
    message = Types["sensor_msgs/msg/LaserScan"](
        header=header(at_s, "base_scan"),
        angle_min=0.0,
        angle_max=increment * (len(ranges) - 1),
        angle_increment=increment,
        time_increment=math.inf,  # the LDS-01's driver divides by a speed that may be 0
        scan_time=0.2,
        range_min=0.1,
        range_max=2.0,
        ranges=np.array(ranges, dtype=np.float32),
        intensities=np.zeros(len(ranges), dtype=np.float32),
    )
    return bytes(ROS.serialize_cdr(message, "sensor_msgs/msg/LaserScan"))


def odometry(x: float, y: float, yaw: float, at_s: float) -> bytes:
    pose = Types["geometry_msgs/msg/Pose"](
        position=Types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0),
        orientation=Types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
    )
    zero = Types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
    message = Types["nav_msgs/msg/Odometry"](
        header=header(at_s, "odom"),
        child_frame_id="base_footprint",
        pose=Types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
        twist=Types["geometry_msgs/msg/TwistWithCovariance"](
            twist=Types["geometry_msgs/msg/Twist"](linear=zero, angular=zero), covariance=np.zeros(36)
        ),
    )
    return bytes(ROS.serialize_cdr(message, "nav_msgs/msg/Odometry"))


class Lab:
    """A service with a mapping, and a robot that may put anything."""

    def __init__(self, service: Service, bus: Stranger, mapping: Path) -> None:
        self.service = service
        self.bus = bus
        self.mapping = mapping

    def map(self, *robots: str) -> None:
        """Write the mapping; returns when it holds."""
        self.mapping.write_text("\n".join(f"[[robot]]\n{robot}" for robot in robots))
        names = [line.partition('"')[2].rstrip('"') for text in robots for line in text.split("\n")[:1]]
        wait_for(lambda: [each["robot"] for each in self.reports() if each["source"] == "ros2"] == names, "the mapping")
        for name in names:
            with self.bus.session.declare_publisher(f"{name}/scan") as publisher:
                # The stub says bool; it is an object whose `matching` tells.
                wait_for(lambda: publisher.matching_status.matching, "the topic to be listened to")  # type: ignore[attr-defined] # the stub says bool; it has `matching`

    def reports(self) -> list[Json]:
        return list(self.service.get("/v1/robots")["items"])

    def report(self, robot: str = "tb3_1") -> Json:
        (report,) = [each for each in self.reports() if (each["robot"], each["source"]) == (robot, "ros2")]
        return dict(report)

    def version(self, session: str) -> int:
        return int(self.service.get(f"/v1/sessions/{session}")["version"])

    def last_request(self, session: str) -> Json:
        return dict(self.service.get(f"/v1/sessions/{session}/history")["items"][-1]["request"])

    def put(self, key: str, payload: bytes, attachment: str | None = None) -> None:
        """As a bridge does it: no encoding."""
        self.bus.session.put(key, payload, attachment=attachment)

    def revolutions(self, count: int, first: int = 0, ranges: Sequence[float] = GOOD, robot: str = "tb3_1") -> None:
        """Publish `count` scans at 5 Hz by the robot's clock; returns when all were received."""
        before = self.report(robot)["scans"]
        for turn in range(first, first + count):
            self.put(f"{robot}/scan", laser_scan(ranges, 100.0 + 0.2 * turn))
        wait_for(lambda: self.report(robot)["scans"] == before + count, "the scans")


@contextmanager
def lab(folder: Path, own_router: Router, **settings: Any) -> Iterator[Lab]:
    folder.mkdir(exist_ok=True)
    mapping = folder / "robots.toml"
    if not mapping.exists():
        mapping.write_text("")
    with ExitStack() as stack:
        service = stack.enter_context(serving(folder, limits=Limits(scan_bytes=20_000)))
        stack.enter_context(bridged(service, own_router, robots=mapping, **settings))
        bus = stack.enter_context(stranger(own_router.endpoint))
        wait_for(lambda: bus.replies("service.health", {}), "the service")
        yield Lab(service, bus, mapping)


def robot(session: str, place: str = '{ from = "sensor", sensor = "Q1" }', look: str = '{ mode = "every" }') -> str:
    return f'name = "tb3_1"\nsession = "{session}"\nlook = {look}\nplace = {place}\n'
