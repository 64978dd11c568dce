"""An episode with real devices: the skeleton of `voa_fleet.devices.example` with drivers that are scripted here.

    python clients/examples/real_device.py [URL]

The program opens a session, drives the lidar to the places that the service recommends, sends the scans, runs the arm's
program for the best grasp, and reports the outcome. The three drivers below stand in for a table with a mug on it:
replace them with your navigation stack, your lidar and your arm's controller, and leave the rest. Copy
`clients/voa_fleet/devices/example.py` and fill in the places that it marks. Without a URL a service is started for the
length of the program. It needs the extra `fleet`.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass

from voa_assets import path
from voa_client import CandidateSensor, Client, PredictionsRequest, Scenario
from voa_client.local import local_service
from voa_client.scenario_files import load_scenario
from voa_fleet.devices.example import ExampleArm, ExampleSensorRobot
from voa_fleet.episodes.episode import Episode, Pair, run_episode
from voa_fleet.episodes.looks import client_channel
from voa_fleet.episodes.policies import policy_named
from voa_fleet.world.clocks import RealClock

POSE = "U_90"
"""Pose in which the mug lies on the scripted table; neither the robot nor the service knows it."""
OUT_OF_RANGE_M = 100.0
"""Range that the scripted lidar reports where nothing is in range: beyond its `range_max`, hence a no-return."""
REVOLUTIONS = 3
"""Revolutions of the lidar in one look; with a real lidar leave the default of ten."""
PROGRAMS = {"TD90": "grasp_from_above", "OI90": "grasp_the_handle"}
"""Program of the arm's controller for each grasp that this arm can do."""


@dataclass
class ScriptedBase:
    """A mobile base that arrives exactly at every goal."""

    x: float = 1.0
    y: float = 0.0
    yaw_rad: float = 0.0

    def go_to(self, x: float, y: float, yaw_rad: float) -> bool:
        """Put the base at a pose in the world frame (metres, radians); True: it has arrived."""
        self.x, self.y, self.yaw_rad = x, y, yaw_rad
        return True

    def pose(self) -> tuple[float, float, float]:
        """Return the base's x, y (metres) and yaw (radians) in the world frame."""
        return self.x, self.y, self.yaw_rad

    def standard_deviations(self) -> tuple[float, float]:
        """Return the standard deviations of localisation: 2 mm in x and y, 0.01 rad in yaw."""
        return 0.002, 0.01


@dataclass
class ScriptedLidar:
    """A lidar whose ranges are those that the mug's mesh gives at `POSE`, seen from the base."""

    client: Client
    scenario: Scenario
    base: ScriptedBase

    def revolution(self, timeout_s: float) -> Sequence[float] | None:  # noqa: ARG002 - the driver's interface
        """Return the ranges of one revolution, metres."""
        here = ExampleSensorRobot(self.base, self).pose()
        sensor = CandidateSensor(x=here.x, y=here.y, yaw_rad=here.yaw_rad)
        predicted = self.client.predict(self.scenario.id, PredictionsRequest(sensors=[sensor]))
        ranges = predicted.ranges[0][predicted.poses.index(POSE)]
        return [OUT_OF_RANGE_M if value is None else value for value in ranges]


@dataclass
class ScriptedArm:
    """An arm whose fingers hold the mug after the program that grasps its handle, and close completely after others."""

    last_program: str = ""

    def run_program(self, name: str) -> bool:
        """Note which program of the controller runs; True: it ended without a protective stop."""
        self.last_program = name
        return True

    def grip_width_m(self) -> float:
        """Return the distance between the closed fingers, metres."""
        return 0.011 if self.last_program == PROGRAMS["OI90"] else 0.0


def play(url: str) -> Episode:
    """Run one episode with the service at a URL."""
    with Client(url) as client:
        scenario = load_scenario(client, path("mug") / "scenario.json")
        base = ScriptedBase()
        robot = ExampleSensorRobot(base, ScriptedLidar(client, scenario, base))
        arm = ExampleArm(ScriptedArm(), PROGRAMS)
        pair = Pair("lab", client, robot, arm, client_channel(client, robot, scenario, REVOLUTIONS), RealClock())
        return run_episode(pair, scenario, policy_named("voa"))


def main() -> None:
    """Run one episode, and print its looks, its grasp and the outcome."""
    if len(sys.argv) > 1:
        episode = play(sys.argv[1])
    else:
        with local_service() as url:
            episode = play(url)
    places = ", ".join(look.sensor for look in episode.looks) or "nowhere"
    outcome = "no grasp was worth an attempt" if episode.outcome is None else episode.outcome.detail
    print(f"looked from {places}; {episode.grasp}, expected to succeed with {episode.expected_score:.2f}: {outcome}")


if __name__ == "__main__":
    main()
