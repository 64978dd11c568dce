"""Scenarios and meshes for tests of the page: the shipped mug with the geometry of its grasps, and boxes."""

from typing import Any

import numpy as np

from tests.voa_core.worlds import BOX_FACES
from voa_assets import path as asset_path
from voa_client.message_files import read_file
from voa_fleet.errors import InvalidObject
from voa_fleet.world.meshes import Mesh, read_obj
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import ScenarioRequest

UPRIGHT, ON_ITS_SIDE = [1.0, 0.0, 0.0, 0.0], [0.7071067811865476, 0.7071067811865476, 0.0, 0.0]
GEOMETRY: dict[str, Any] = {
    "TD0": {"tool_centre_point": [0.038, 0.0, 0.068], "approach": [0, 0, -1], "closing": [1, 0, 0]},
    "TD90": {"tool_centre_point": [0.0, 0.038, 0.068], "approach": [0, 0, -1], "closing": [0, 1, 0]},
    "OI90": {"tool_centre_point": [0.0, 0.052, 0.0475], "approach": [0, -1, 0], "closing": [1, 0, 0]},
}
"""Geometry of three of the mug's four grasps."""


def box(x: float = 0.04, y: float = 0.06, z: float = 0.05) -> Mesh:
    """A box that stands on the table around the z axis, metres."""
    corners = [((i - 0.5) * x, (j - 0.5) * y, k * z) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return Mesh(np.array(corners), np.array(BOX_FACES, dtype=np.int32))


def mug() -> tuple[ScenarioRequest, Mesh]:
    """The shipped mug; its last grasp has no geometry."""
    folder = asset_path("mug")
    scenario = read_file(ScenarioRequest, folder / "scenario.json", InvalidObject)
    document = scenario.model_dump(mode="json")
    for grasp in document["grasps"]:
        grasp["data"] = GEOMETRY.get(grasp["name"])
    return ScenarioRequest.model_validate(document), read_obj(folder / "mug.obj")


def box_scenario(count: int = 2, **changes: Any) -> ScenarioRequest:
    """Scenario of `box()`, upright at several places along x, with two grasps of given probabilities."""
    return ScenarioRequest.model_validate(
        {
            "name": "box <1>",
            "object": "box.obj",
            "poses": [
                {"name": f"upright {index}", "position": [0.1 * index, 0.0, 0.0], "quaternion_wxyz": UPRIGHT}
                for index in range(count)
            ],
            "grasps": [{"name": "G1"}, {"name": "G2"}],
            "scores": {"probabilities": [[0.9] * count, [0.0] * count]},
            "sensors": [{"name": "E", "x": 0.4, "y": 0.0, "yaw_rad": 3.141592653589793}],
            "lidar": {"preset": "lds-01", "height_m": 0.02},
            "update": {"rule": "beam"},
        }
        | changes
    )


def ranking_of(scenario: ScenarioRequest) -> Ranking:
    """A ranking of all places of a scenario, from 0.3 down, which recommends the first."""
    names = [sensor.name for sensor in scenario.sensors]
    return Ranking.model_validate(
        {
            "version": None,
            "definition": "executed",
            "scans": "simulated",
            "samples": 43,
            "method": "exact",
            "precision": "float64",
            "expected_score_before": 0.4,
            "best_grasp_before": scenario.grasps[0].name,
            "ranking": [
                {
                    "sensor": name,
                    "voa": 0.3 - 0.05 * index,
                    "standard_error": 0.004,
                    "cost": 0.0,
                    "net_value": 0.3 - 0.05 * index,
                    "expected_score_after": 0.7 - 0.05 * index,
                    "ties_with_first": index == 0,
                }
                for index, name in enumerate(names)
            ],
            "recommendation": {"action": "look", "sensor": names[0], "net_value": 0.3},
        }
    )
