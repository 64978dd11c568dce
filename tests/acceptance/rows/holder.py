"""The lab's 24 scans of the HOLDER, a real part, predicted from its mesh."""

import csv
import json
import math
import os
from collections import defaultdict
from pathlib import Path

import numpy as np
import trimesh

from tests.acceptance.customer import Service
from tests.acceptance.figures import Figure
from tests.acceptance.sizes import Size
from tests.acceptance.worlds import Place, Pose, World
from voa_client import Scan, UncertainSensorPose, UpdateRequest

_SHARED = Path(__file__).resolve().parents[3].parent / "shared" / "lab-holder"
_BEAMS = 360


def folder() -> Path:
    """Folder of the recorded experiment: `VOA_LAB_HOLDER`, or lab-holder in the folder `shared` beside the project."""
    return Path(os.environ.get("VOA_LAB_HOLDER", _SHARED))


def rows(service: Service, _seed: int, _size: Size) -> list[Figure]:
    """Count the scans after which the true pose is the likeliest; every beam that is not recorded is a no-return."""
    row, name = "HOLDER by mesh", "scans after which the true pose is the likeliest"
    lab = folder()
    if not lab.is_dir():
        return [Figure(row, name, None, "at least", 24, f"no data at {lab}; VOA_LAB_HOLDER names another folder")]
    world = _world(lab)
    scenario = service.scenario_of(world, workspace=None)
    by_name = {place.name: place for place in world.places}
    right, beliefs = 0, []
    for (sensor, pose), (height, ranges) in sorted(_recorded(lab).items()):
        place = by_name[sensor]
        at = UncertainSensorPose(x=place.x, y=place.y, yaw_rad=place.yaw_rad, height_m=height)
        lost = [index for index in range(_BEAMS) if index not in ranges]
        scan = Scan(ranges=[ranges.get(index) for index in range(_BEAMS)], no_return=lost, range_min=0.0)
        request = UpdateRequest(scenario=scenario, belief=None, sensor_pose=at, scan=scan)
        after = service.client.update_once(request)
        likeliest = after.poses[int(np.argmax(after.belief))]
        right += after.update.accepted and likeliest == pose
        beliefs.append(after.belief[after.poses.index(pose)])
    counts = f"{len(beliefs)} scans; mean belief in the true pose {np.mean(beliefs):.3f}"
    return [Figure(row, name, float(right), "at least", 24, counts)]


def _world(lab: Path) -> World:
    experiment = json.loads((lab / "experiment.json").read_text(encoding="utf-8"))
    poses = [
        Pose(pose["name"], tuple(pose["position"]), tuple(pose["quaternion_wxyz"])) for pose in experiment["poses"]
    ]
    names = [pose.name for pose in poses]
    scores = np.array([[experiment["scores"][grasp][pose] for pose in names] for grasp in experiment["grasps"]])
    places = [
        Place(each["name"], each["x"], each["y"], math.radians(each["yaw_deg"]), 0.014)
        for each in experiment["sensors"]
    ]
    mesh = trimesh.load_mesh(lab / experiment["object"]["mesh"], process=False)
    return World("holder", mesh, poses, places, scores)


def _recorded(lab: Path) -> dict[tuple[str, str], tuple[float, dict[int, float]]]:
    """Height of the scan plane, and measured ranges by beam, of each sensor and pose."""
    ranges: dict[tuple[str, str], dict[int, float]] = defaultdict(dict)
    heights = {}
    with (lab / "scans.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            key = row["sensor"], row["pose"]
            heights[key] = float(row["plane_height"])
            if row["measured"]:
                ranges[key][int(row["angle_deg"])] = float(row["measured"])
    return {key: (heights[key], ranges[key]) for key in heights}
