"""Laboratory for the page Robots: a service with a mapping on a router, and a lidar robot before an angle bracket."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.support.routers import Router
from tests.support.standing_robots import CORNER, GRID, Bench, bench_of, prism
from tests.support.waiting import wait_for
from tests.voa_cli.labs import Lab, service_on
from tests.voa_doctor.publishing import publishing
from tests.voa_recordings.files.bags import laser_scan
from voa_client import Client, ScenarioRequest
from voa_core.objects import Object
from voa_ros.cdr import encode_laser_scan, encode_odometry
from voa_ros.messages import Odometry, Pose, Stamp
from voa_ros.motions import Motion

ROBOT = "tb3_1"
PLACE = Motion(0.4, 0.05, math.pi + 0.2)
"""True pose of the lidar."""
_EVERY_S = 0.1
_HALF = math.sqrt(0.5)
_LOOK = "look = { scans = 3 }"


@dataclass
class Bracket:
    """Lidar robot that stands still before the angle bracket; its driver may turn the wrong way.

    Attributes:
        place: true pose of its lidar, which is also what its odometry says.
        is_mirrored: True if its driver counts the beams clockwise.
        is_contradictory: True if the header of its scans contradicts itself.
        noise: of its lidar.
    """

    bench: Bench
    place: Motion = PLACE
    is_mirrored: bool = False
    is_contradictory: bool = False
    noise: np.random.Generator = field(default_factory=lambda: np.random.default_rng(1))

    def messages(self, _: int) -> list[tuple[str, bytes]]:
        """Odometry and a scan, stamped now."""
        now = time.time()
        odometry = Odometry(Stamp.of(now), "odom", "base", Pose.planar(self.place.x, self.place.y, self.place.yaw_rad))
        ranges = self.exact() + self.noise.normal(0.0, 0.002, GRID.beams)
        if self.is_mirrored:
            ranges = np.roll(ranges[::-1], 1)
        increment = -GRID.angle_increment if self.is_contradictory else GRID.angle_increment
        scan = laser_scan(ranges.tolist(), round(1e9 * now), angle_increment=increment)
        return [(f"{ROBOT}/odom", encode_odometry(odometry)), (f"{ROBOT}/scan", encode_laser_scan(scan))]

    def exact(self) -> NDArray[np.float64]:
        return self.bench.ranges(self.place, "as made")


@dataclass(frozen=True)
class Laboratory:
    """Service with a mapping, its scenario, and the robot."""

    lab: Lab
    client: Client
    mapping: Path
    scenario: str
    robot: Bracket

    def map(self, more: str = "") -> None:
        """Map the robot by its odometry, with further lines for its entry."""
        robot = f'[[robot]]\nname = "{ROBOT}"\nscenario = "{self.scenario}"\n{_LOOK}\n{more}\n'
        self.mapping.write_text(f'{robot}[robot.place]\nfrom = "odometry"\nstd = {{ xy_m = 0.005, yaw_rad = 0.01 }}\n')
        wait_for(lambda: ROBOT in [each.robot for each in self.client.robots().items], "the mapping")


def obj_of(mesh: Object) -> str:
    """Write a mesh as an OBJ file."""
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces.tolist()]
    return "\n".join(lines)


@contextmanager
def laboratory(router: Router, folder: Path) -> Iterator[Laboratory]:
    """Run the service, and a robot that publishes ten scans per second for the length of a `with`."""
    folder.mkdir(parents=True, exist_ok=True)
    mapping = folder / "robots.toml"
    mapping.write_text("")
    bracket = prism(CORNER)
    robot = Bracket(bench_of(bracket))
    with (
        service_on(router, folder, ["--robots", str(mapping)]) as lab,
        Client(lab.url) as client,
        publishing(router, robot.messages, _EVERY_S),
    ):
        mesh = folder / "bracket.obj"
        mesh.write_text(obj_of(bracket))
        uploaded = client.create_object(mesh)
        scenario = client.create_scenario(_scenario(uploaded.id))
        yield Laboratory(lab, client, mapping, scenario.id, robot)


def _scenario(object_id: str) -> ScenarioRequest:
    turns = {"as made": (1.0, 0.0), "turned": (_HALF, _HALF), "back": (0.0, 1.0)}
    return ScenarioRequest.model_validate(
        {
            "name": "bracket",
            "object": object_id,
            "poses": [
                {"name": name, "position": [0.0, 0.0, 0.0], "quaternion_wxyz": [w, 0.0, 0.0, z]}
                for name, (w, z) in turns.items()
            ],
            "grasps": [{"name": "G1"}, {"name": "G2"}],
            "scores": {"probabilities": [[0.9, 0.1, 0.2], [0.1, 0.8, 0.3]]},
            "sensors": [
                {"name": "E", "x": 0.4, "y": 0.05, "yaw_rad": math.pi},
                {"name": "N", "x": 0.0, "y": 0.4, "yaw_rad": -math.pi / 2},
                {"name": "W", "x": -0.4, "y": 0.0, "yaw_rad": 0.0},
            ],
            "lidar": {"preset": "lds-01", "height_m": 0.05},
            "update": {"rule": "beam"},
            "workspace": {"min": [-0.25, -0.25], "max": [0.25, 0.25]},
        }
    )
