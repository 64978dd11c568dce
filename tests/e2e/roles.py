"""Programs of the lidar robot, of the arm and of an onlooker, which use the service by its client alone.

    python tests/e2e/roles.py sensor|arm|onlooker URL SESSION POSE

The mug lies at POSE: the scans of the robot are the predictions for that pose.
"""

import json
import sys

from voa_client import ArmClient, Client, SensorClient
from voa_msgs.scenarios import PredictionsRequest
from voa_msgs.sessions import Scan


def sensor(client: Client, session: str, pose: str) -> dict[str, object]:
    """Take one look, from the place that is ranked first."""
    scenario = client.get_session(session).scenario
    stands = [""]

    def drive(name: str) -> None:
        stands[0] = name

    def take_scan() -> Scan:
        predicted = client.predict(scenario, PredictionsRequest(sensors=[stands[0]]))
        ranges = predicted.ranges[0][predicted.poses.index(pose)]
        return Scan(ranges=ranges, no_return=[index for index, value in enumerate(ranges) if value is None])

    tour = SensorClient(client, session).run(drive, take_scan, most_looks=1)
    return {"looks": [look.sensor for look in tour.looks], "grasp": tour.looks[-1].after.best_grasp}


def arm(client: Client, session: str, pose: str) -> dict[str, object]:
    """Wait for an expected score of 0.6, grasp, and report the outcome."""
    own = ArmClient(client, session)
    waited = own.wait_until(score=0.6)
    best = own.best_grasp()
    assert best is not None
    after = own.report(best.name, success=True)
    return {"reason": waited.reason, "grasp": best.name, "version": after.version}


def onlooker(client: Client, session: str, pose: str) -> dict[str, object]:
    """Follow every version until the session ends."""
    versions = []
    for seen in client.follow(session):
        versions.append(seen.version)
        print("following", file=sys.stderr, flush=True)
    return {"versions": versions}


def main() -> None:
    """Play a role and print its result as JSON."""
    role, url, session, pose = sys.argv[1:]
    with Client(url) as client:
        print(json.dumps({"sensor": sensor, "arm": arm, "onlooker": onlooker}[role](client, session, pose)))
    assert "numpy" not in sys.modules


if __name__ == "__main__":
    main()
