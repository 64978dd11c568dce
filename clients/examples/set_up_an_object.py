"""Set up an object: from a mesh to a ranking of the places to look from.

    python clients/examples/set_up_an_object.py [URL]

The object is a box of 12 x 4 x 8 cm. It may lie as it most probably comes to rest, at one of four yaws; the gripper can
close in four directions, and was tried fifteen times at each. A LDS-01 lidar can look from four places. Without a URL a
service is started for the length of the program.
"""

import math
import sys
import tempfile
from pathlib import Path
from typing import Any

from voa_client import Client, Object, Ranking, ScenarioRequest, SessionRequest
from voa_client.local import service_at

SIZE_M = (0.12, 0.04, 0.08)
YAWS_DEG = (0, 45, 90, 135)
ATTEMPTS = 15
SUCCESSES = {0: 14, 45: 6, 90: 0, 135: 6}
"""Successes of an attempt by how far the gripper is turned against the box, in degrees."""


def box_obj() -> str:
    """Return the box as an OBJ file in metres, its origin at a corner."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = ["v " + " ".join(str(side * at) for side, at in zip(SIZE_M, corner, strict=True)) for corner in corners]
    lines += ["f " + " ".join(map(str, face)) for face in faces]
    return "\n".join(lines) + "\n"


def pose(name: str, position: list[float], quaternion_wxyz: list[float], yaw_deg: float) -> dict[str, Any]:
    """Return a pose of a scenario: a resting object, turned about the vertical through the world's origin."""
    x, y, z = position
    half, yaw = math.radians(yaw_deg) / 2, math.radians(yaw_deg)
    c, s = math.cos(half), math.sin(half)
    w, i, j, k = quaternion_wxyz
    return {
        "name": name,
        "position": [x * math.cos(yaw) - y * math.sin(yaw), x * math.sin(yaw) + y * math.cos(yaw), z],
        "quaternion_wxyz": [c * w - s * k, c * i - s * j, c * j + s * i, c * k + s * w],
    }


def scenario_of(client: Client, mesh: Object) -> ScenarioRequest:
    """Write the scenario of the box: its poses, grasps, scores, lidar and places."""
    rest = client.stable_poses(mesh.id).items[0]  # the most probable way in which it comes to rest
    bearings_deg = {"E": 0, "NE": 45, "N": 90, "NW": 135}
    return ScenarioRequest.model_validate(
        {
            "name": "box",
            "object": mesh.id,
            "poses": [pose(f"yaw {yaw}", list(rest.position), list(rest.quaternion_wxyz), yaw) for yaw in YAWS_DEG],
            "grasps": [{"name": f"close at {yaw}", "data": {"yaw_deg": yaw}} for yaw in YAWS_DEG],
            "scores": {
                "attempts": ATTEMPTS,
                "successes": [[SUCCESSES[(gripper - yaw) % 180] for yaw in YAWS_DEG] for gripper in YAWS_DEG],
            },
            "sensors": [
                {
                    "name": name,
                    "x": 0.4 * math.cos(math.radians(bearing)),
                    "y": 0.4 * math.sin(math.radians(bearing)),
                    "yaw_rad": math.radians(bearing) - math.pi,  # the lidar faces the object
                    "cost": 0.01,
                }
                for name, bearing in bearings_deg.items()
            ],
            "lidar": {"preset": "lds-01", "height_m": 0.02},
            "workspace": {"min": [-0.2, -0.2], "max": [0.2, 0.2]},
        }
    )


def set_up(client: Client, folder: Path) -> Ranking:
    """Upload the mesh, store the scenario, print its warnings, and rank the looks of a new session."""
    mesh_file = folder / "box.obj"
    mesh_file.write_text(box_obj(), encoding="utf-8")
    mesh = client.create_object(mesh_file)
    print(f"mesh {mesh.name}: {mesh.faces} triangles, {' x '.join(f'{side:.2f}' for side in mesh.extents)} m")
    scenario = client.create_scenario(scenario_of(client, mesh))
    print(f"scenario {scenario.id[:12]}: {len(scenario.poses)} poses, {len(scenario.grasps)} grasps")
    for warning in client.warnings(scenario.id).items:
        print(f"warning: {warning.detail}")
    session = client.create_session(SessionRequest(scenario=scenario.id))
    return client.rank_looks(session.id)


def main() -> None:
    """Set the object up and print the ranking."""
    url = sys.argv[1] if len(sys.argv) > 1 else None
    with tempfile.TemporaryDirectory() as folder, service_at(url) as client:
        ranking = set_up(client, Path(folder))
    print(f"without a look: {ranking.best_grasp_before}, expected to succeed with {ranking.expected_score_before:.2f}")
    for look in ranking.ranking:
        print(
            f"{look.sensor:>3}  VOA {look.voa:+.3f}  cost {look.cost:.2f}  afterwards {look.expected_score_after:.2f}"
        )
    print(f"recommended: {ranking.recommendation.action}")


if __name__ == "__main__":
    main()
