"""Make assets/voa_assets/experiments/mug: a recorded experiment whose scans are synthetic.

    python -m tests.support.make_recorded_mug [DIR]

Poses, grasps and scores are those of the mug's scenario, looked at from every second of its sensor configurations.
Predictions come from the twin's ray caster, measured ranges from them with the faults of a small spinning lidar, and
`expected.json` from the twin's mathematics: nothing here comes from `voa_core`, which is what it is there to check.
"""

import csv
import io
import json
import math
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from tests.support import twin
from voa_assets import lidar_presets, path

SEED = 20240311
NOISE_M = 0.003
"""Standard deviation of a range: what the paper reports of the LDS-01 this close, not what its datasheet allows."""
LOST = 0.04
"""Share of beams that come back empty from a surface."""
EDGE_OFF = 0.25
"""Share of the beams at an edge that return something between the near and the far surface."""
EDGE_OFF_M = (0.010, 0.060)
STRAY = 0.15
"""Share of the beams just beside the mug that return although they pass it."""

RULES: dict[str, dict[str, float]] = {
    "margin": {"margin_m": 0.008},
    "gaussian": {"sigma_m": 1.0},
    "exponential": {},
    "inverse_rmsd": {"floor_m": 0.001},
}

LINE = 120

Beams = list[float]
Scans = dict[tuple[str, str], Beams]
"""Ranges of a scan by sensor and pose, metres; `inf` is a no-return."""


@dataclass(frozen=True)
class Recording:
    """The scenario's content as `experiment.json` has it, with predicted and measured scans."""

    experiment: dict[str, Any]
    plane_height: float
    predicted: Scans
    measured: Scans

    @property
    def poses(self) -> list[str]:
        return [pose["name"] for pose in self.experiment["poses"]]

    @property
    def sensors(self) -> list[str]:
        return [sensor["name"] for sensor in self.experiment["sensors"]]


def experiment_of(scenario: dict[str, Any]) -> dict[str, Any]:
    """The body of `experiment.json`."""
    preset = lidar_presets()[scenario["lidar"]["preset"]]
    poses, grasps = ([entry["name"] for entry in scenario[what]] for what in ("poses", "grasps"))
    return {
        "name": "mug",
        "object": {"mesh": scenario["object"], "scale": 1.0},
        "lidar": {
            "model": "LDS-01",
            "beams": preset["beams"],
            "angle_min_deg": 0,
            "angle_increment_deg": 1,
            "range_min": preset["range_min"],
            "range_max": preset["range_max"],
        },
        "observation": {"no_return": scenario["update"]["no_return_m"]},
        "selection": "whole",
        "poses": scenario["poses"],
        "sensors": [
            {
                "name": sensor["name"],
                "x": sensor["x"],
                "y": sensor["y"],
                "yaw_deg": (sensor["data"]["bearing_deg"] + 180) % 360,
            }
            for sensor in scenario["sensors"][::2]
        ],
        "grasps": grasps,
        "attempts": scenario["scores"]["attempts"],
        "successes": {
            grasp: dict(zip(poses, row, strict=True))
            for grasp, row in zip(grasps, scenario["scores"]["successes"], strict=True)
        },
    }


def record(folder: Path) -> Recording:
    """Look at the mug of the scenario in `folder`."""
    scenario = json.loads((folder / "scenario.json").read_text(encoding="utf-8"))
    experiment, height = experiment_of(scenario), scenario["lidar"]["height_m"]
    mesh = trimesh.load_mesh(folder / scenario["object"], process=False)
    angles = [math.radians(degree) for degree in range(experiment["lidar"]["beams"])]
    rng = np.random.default_rng(SEED)
    predicted: Scans = {}
    measured: Scans = {}
    for sensor in experiment["sensors"]:
        stand = (sensor["x"], sensor["y"], math.radians(sensor["yaw_deg"]))
        for pose in experiment["poses"]:
            ranges = twin.cast(
                mesh.vertices,
                mesh.faces,
                pose["position"],
                pose["quaternion_wxyz"],
                stand,
                height,
                angles,
                experiment["lidar"]["range_max"],
            )
            pair = (sensor["name"], pose["name"])
            predicted[pair] = [round(value, 9) for value in ranges]
            measured[pair] = measure(predicted[pair], rng)
    return Recording(experiment, height, predicted, measured)


def measure(predicted: Beams, rng: np.random.Generator) -> Beams:
    """A scan as the lidar would give it, in whole millimetres: noise, lost beams, edges that return a mixture."""
    beams = len(predicted)
    noise, lost, fault = rng.normal(0.0, NOISE_M, beams), rng.random(beams), rng.random(beams)
    off = rng.uniform(*EDGE_OFF_M, beams)
    measured = []
    for i, surface in enumerate(predicted):
        beside = [predicted[i - 1], predicted[(i + 1) % beams]]
        seen = surface
        if surface == math.inf:
            if min(beside) != math.inf and fault[i] < STRAY:
                seen = min(beside) + off[i]
        elif lost[i] < LOST:
            seen = math.inf
        elif max(beside) == math.inf and fault[i] < EDGE_OFF:
            seen = surface + off[i]
        measured.append(round(seen + noise[i], 3) if seen != math.inf else math.inf)
    return measured


def rows(recording: Recording) -> Iterator[list[str]]:
    """The rows of `scans.csv`: every beam that returned, was predicted to, or both."""
    yield ["sensor", "pose", "plane_height", "angle_deg", "measured", "predicted"]
    for (sensor, pose), predicted in recording.predicted.items():
        for degree, (seen, expected) in enumerate(zip(recording.measured[sensor, pose], predicted, strict=True)):
            if min(seen, expected) == math.inf:
                continue
            numbers = [f"{seen:.3f}" if seen != math.inf else "", f"{expected:.9f}" if expected != math.inf else ""]
            yield [sensor, pose, f"{recording.plane_height:.3f}", str(degree), *numbers]


def expected_of(recording: Recording) -> dict[str, Any]:
    """The body of `expected.json`, by the twin."""
    poses, grasps = recording.poses, recording.experiment["grasps"]
    attempts = recording.experiment["attempts"]
    table = [[recording.experiment["successes"][grasp][pose] / attempts for pose in poses] for grasp in grasps]
    before = [1.0 / len(poses)] * len(poses)
    best, score = twin.best_grasp(table, before)
    return {
        "before": {"best_grasp": None if best is None else grasps[best], "expected_score": score},
        "rules": {
            rule: {sensor: _value(recording, table, before, rule, sensor) for sensor in recording.sensors}
            for rule in RULES
        },
    }


def _value(recording: Recording, table: twin.Scores, before: Sequence[float], rule: str, sensor: str) -> dict[str, Any]:
    no_return = recording.experiment["observation"]["no_return"]
    parameters = {"no_return_m": no_return, **RULES[rule]}
    predicted = [recording.predicted[sensor, pose] for pose in recording.poses]

    def compare(scan: Beams) -> tuple[list[float], list[float]]:
        return (
            [twin.log_weight(rule, parameters, scan, other) for other in predicted],
            [twin.distance(scan, other, no_return) for other in predicted],
        )

    among = [compare(scan) for scan in predicted]
    after = []
    for pose in recording.poses:
        scan = recording.measured[sensor, pose]
        log_weights, distances = compare(scan)
        after.append(twin.update(before, log_weights, distances, len(scan), on_no_match="nearest").belief)
    voa = twin.value_of_assistance(
        table, before, [weights for weights, _ in among], [d for _, d in among], on_no_match="nearest"
    )
    return {
        "voa": round(voa, 12),
        "aecd": round(twin.executed_value(table, before, after), 12),
        "belief_after_measured_scan": {
            pose: {other: round(share, 12) for other, share in zip(recording.poses, belief, strict=True)}
            for pose, belief in zip(recording.poses, after, strict=True)
        },
    }


def readable(value: Any, indent: str = "") -> str:
    """JSON with every part that fits on a line on one."""
    line = json.dumps(value)
    if len(indent) + len(line) <= LINE or not isinstance(value, dict | list):
        return line
    deeper = indent + " "
    if isinstance(value, dict):
        parts = [f"{json.dumps(key)}: {readable(part, deeper)}" for key, part in value.items()]
        opening, closing = "{", "}"
    else:
        parts = [readable(part, deeper) for part in value]
        opening, closing = "[", "]"
    return f"{opening}\n{deeper}" + f",\n{deeper}".join(parts) + f"\n{indent}{closing}"


def write(recording: Recording, mesh: Path, folder: Path) -> None:
    """The four files of the experiment into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(mesh, folder / mesh.name)
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows(rows(recording))
    texts = {
        "experiment.json": readable(recording.experiment) + "\n",
        "scans.csv": table.getvalue(),
        "expected.json": readable(expected_of(recording)) + "\n",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def main() -> None:
    """Write the folder named on the command line, or the one in the package."""
    source = path("mug")
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else source.parent / "experiments" / "mug"
    write(record(source), source / "mug.obj", target)


if __name__ == "__main__":
    main()
