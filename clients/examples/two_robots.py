"""Two robots in one session: a lidar robot that looks, and an arm that waits for its moment and grasps.

    python clients/examples/two_robots.py [URL]

Each robot is a thread with a client of its own, as it would be a process on a machine of its own: they share nothing
but the session's id. The lidar robot announces each look before it drives (`SensorClient.run` does it), so that a
second lidar robot would plan around it, and the arm waits for it. The scans are simulated (the mug lies in a pose that
only the simulation knows) and so is the arm, which succeeds if the grasp's score at that pose is above one half.
`drive`, `take_scan` and `attempt` are what your robots replace. Without a URL a service is started for the length of
the program.
"""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

from voa_assets import path
from voa_client import ArmClient, Client, PredictionsRequest, Scan, Scenario, SensorClient, SessionRequest
from voa_client.local import local_service
from voa_client.scenario_files import load_scenario

POSE = "U_90"


@dataclass
class SimulatedLidarRobot:
    """A lidar robot whose scans are what the mesh at `POSE` would give, so it needs no table.

    It keeps the places that it visited, and those that other robots saw announced while it drove there.
    """

    client: Client
    scenario: Scenario
    session_id: str
    stands_at: str = ""
    visited: list[str] = field(default_factory=list)
    announced: list[str | None] = field(default_factory=list)

    def drive(self, sensor: str) -> None:
        """Drive the lidar to a sensor configuration of the scenario; return when it stands there."""
        self.stands_at = sensor
        self.visited.append(sensor)
        self.announced += [look.sensor for look in self.client.get_session(self.session_id).under_way]

    def take_scan(self) -> Scan:
        """Return one revolution: ranges in metres, and the beams in whose direction nothing is in range."""
        predicted = self.client.predict(self.scenario.id, PredictionsRequest(sensors=[self.stands_at]))
        ranges = predicted.ranges[0][predicted.poses.index(POSE)]
        return Scan(ranges=ranges, no_return=[beam for beam, value in enumerate(ranges) if value is None])


def attempt(scenario: Scenario, grasp: str) -> bool:
    """Try a grasp in the simulation: it succeeds where its score at the object's pose is above one half."""
    names, poses = [each.name for each in scenario.grasps], [each.name for each in scenario.poses]
    scores = scenario.model_dump()["scores"]
    return bool(scores["successes"][names.index(grasp)][poses.index(POSE)] > scores["attempts"] / 2)


def lidar_robot(url: str, session_id: str, arm_is_ready: threading.Event) -> SimulatedLidarRobot:
    """Look where it is worth most, until no look is worth its cost; return the robot."""
    arm_is_ready.wait()
    with Client(url) as client:
        scenario = client.get_scenario(client.get_session(session_id).scenario)
        robot = SimulatedLidarRobot(client, scenario, session_id)
        SensorClient(client, session_id, robot="scout").run(robot.drive, robot.take_scan, most_looks=3)
    return robot


def arm(url: str, session_id: str, arm_is_ready: threading.Event) -> tuple[str | None, bool]:
    """Follow the session until a grasp is good enough or no look is worth its cost; grasp, and report the outcome."""
    with Client(url) as client:
        scenario = client.get_scenario(client.get_session(session_id).scenario)
        own = ArmClient(client, session_id)
        arm_is_ready.set()
        waited = own.wait_until(score=0.8)
        best = own.best_grasp()
        if best is None or waited.reason == "probably_absent":  # only where the scenario states `absent`
            return None, False
        success = attempt(scenario, best.name)
        own.report(best.name, success=success)
    print(f"the arm waited until {waited.reason}; expected {best.name} to succeed with {best.expected_score:.2f}")
    return best.name, success


def play(url: str) -> tuple[SimulatedLidarRobot, str | None, bool]:
    """Open a session and let both robots work in it; return the lidar robot, the grasp and its outcome."""
    with Client(url) as client:
        scenario = load_scenario(client, path("mug") / "scenario.json")
        session_id = client.create_session(SessionRequest(scenario=scenario.id)).id
    ready = threading.Event()
    with ThreadPoolExecutor(2) as robots:
        looking = robots.submit(lidar_robot, url, session_id, ready)
        grasping = robots.submit(arm, url, session_id, ready)
        return looking.result(), *grasping.result()


def main() -> None:
    """Play it once, and print what happened."""
    if len(sys.argv) > 1:
        robot, grasp, success = play(sys.argv[1])
    else:
        with local_service() as url:
            robot, grasp, success = play(url)
    print(f"announced {', '.join(map(str, robot.announced))} before the drives")
    print(f"looked from {', '.join(robot.visited)}; {grasp} {'succeeded' if success else 'failed'}")


if __name__ == "__main__":
    main()
