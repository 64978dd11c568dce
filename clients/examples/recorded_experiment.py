"""Write a recorded experiment: scans measured at known poses, in the folder that `voa replay` reads.

    python clients/examples/recorded_experiment.py FOLDER
    voa replay FOLDER

The measurements are simulated here: a box of 12 x 4 cm, seen from four places 30 cm away by a lidar of one degree whose
ranges have a noise of 3 mm. In your laboratory `measure` is a scan of your lidar, the object lying at the pose, and
`predict` may stay away: without a prediction, give the mesh and use `voa replay FOLDER --predict mesh`.
The format is described in deploy/docs/recorded-experiments.md.
"""

import csv
import json
import math
import random
import sys
from pathlib import Path

from voa_recordings.experiment import RecordedExperiment, read_experiment

LENGTH_M, WIDTH_M, DISTANCE_M, HEIGHT_M, NOISE_M = 0.12, 0.04, 0.30, 0.03, 0.003
POSES = {"along x": 0.0, "diagonal": 45.0, "along y": 90.0}
"""Yaw of the box, degrees."""
SENSORS = {"E": 0.0, "NE": 45.0, "N": 90.0, "NW": 135.0}
"""Bearing of the place, degrees; the lidar faces the box."""
SCORES = {"close at 90": [0.9, 0.4, 0.0], "close at 0": [0.0, 0.4, 0.9]}
COLUMNS = ["sensor", "pose", "plane_height", "angle_deg", "measured", "predicted"]


def place(sensor: str) -> tuple[float, float, float]:
    """Return x and y in metres and yaw in degrees of the lidar at a place."""
    bearing = math.radians(SENSORS[sensor])
    return DISTANCE_M * math.cos(bearing), DISTANCE_M * math.sin(bearing), SENSORS[sensor] - 180.0


def predict(sensor: str, pose: str, angle_deg: int) -> float | None:
    """Return the range at which a beam meets the box, metres; None where it misses."""
    x, y, yaw = place(sensor)
    turn, beam = -math.radians(POSES[pose]), math.radians(yaw + angle_deg - POSES[pose])
    start = (x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn))
    near, far = 0.0, math.inf
    for at, towards, half in zip(start, (math.cos(beam), math.sin(beam)), (LENGTH_M / 2, WIDTH_M / 2), strict=True):
        if abs(towards) < 1e-12:
            if abs(at) > half:
                return None
            continue
        first, second = sorted(((-half - at) / towards, (half - at) / towards))
        near, far = max(near, first), min(far, second)
    return near if near < far else None


def measure(exact: float | None, noise: random.Random) -> float | None:
    """Return a simulated measurement, metres: the exact range and the lidar's noise."""
    return None if exact is None else exact + noise.gauss(0.0, NOISE_M)


def written(value: float | None) -> str:
    """Return a range as it stands in the file; empty for a no-return."""
    return "" if value is None else f"{value:.4f}"


def write_experiment(folder: Path, seed: int = 0) -> RecordedExperiment:
    """Write the experiment into a folder, and read it back."""
    folder.mkdir(parents=True, exist_ok=True)
    experiment = {
        "name": "box",
        "selection": "whole",  # every beam near the object has a row, whether it fits the pose or not
        "poses": list(POSES),
        "sensors": [
            dict(zip(("name", "x", "y", "yaw_deg"), (sensor, *place(sensor)), strict=True)) for sensor in SENSORS
        ],
        "grasps": list(SCORES),
        "scores": {grasp: dict(zip(POSES, scores, strict=True)) for grasp, scores in SCORES.items()},
    }
    (folder / "experiment.json").write_text(json.dumps(experiment, indent=1) + "\n", encoding="utf-8")
    noise = random.Random(seed)  # noqa: S311 - a simulation, not a secret
    with (folder / "scans.csv").open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(COLUMNS)
        for sensor in SENSORS:
            for pose in POSES:
                for angle in range(360):
                    exact = predict(sensor, pose, angle)
                    if exact is not None:  # a beam without a row is a no-return in both
                        rows.writerow([sensor, pose, HEIGHT_M, angle, written(measure(exact, noise)), written(exact)])
    return read_experiment(folder)


def main() -> None:
    """Write the experiment, and say what to do with it."""
    if len(sys.argv) != 2:
        sys.exit("usage: python clients/examples/recorded_experiment.py FOLDER")
    folder = Path(sys.argv[1])
    experiment = write_experiment(folder)
    measured = sum(scan.was_measured for scan in experiment.scans.values())
    print(f"{folder}: {measured} scans of {len(experiment.poses)} poses from {len(experiment.sensors)} places")
    print(f"now: voa replay {folder}")


if __name__ == "__main__":
    main()
