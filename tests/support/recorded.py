"""Small recorded experiments that are written to a folder, and their expected evaluation by the brute-force twin."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tests.support import twin

Row = tuple[str, str, float | None, float, float | None, float | None]
"""Row of scans.csv: sensor, pose, plane height (m), angle (degrees), measured and predicted range (m)."""

RULES: dict[str, dict[str, float]] = {
    "margin": {"margin_m": 0.008},
    "exponential": {},
    "gaussian": {"sigma_m": 1.0},
    "inverse_rmsd": {"floor_m": 0.001},
}


def experiment(**changes: Any) -> dict[str, Any]:
    """Content of experiment.json with two poses and two sensors that have names alone, and two grasps."""
    return {
        "name": "tiny",
        "poses": [{"name": "P1"}, {"name": "P2"}],
        "sensors": [{"name": "Q1"}, {"name": "Q2"}],
        "grasps": ["G1", "G2"],
        "scores": {"G1": {"P1": 0.9, "P2": 0.1}, "G2": {"P1": 0.2, "P2": 0.7}},
    } | changes


def rows() -> list[Row]:
    return [
        ("Q1", "P1", 0.01, 0.0, 0.301, 0.300),
        ("Q1", "P1", 0.01, 1.0, 0.310, 0.312),
        ("Q1", "P2", 0.01, 0.0, 0.398, 0.400),
        ("Q1", "P2", 0.01, 359.0, None, 0.405),
        ("Q2", "P1", 0.01, 0.0, 0.250, None),
        ("Q2", "P2", 0.01, 0.0, 0.260, 0.255),
    ]


def write(folder: Path, content: Mapping[str, Any] | None = None, scans: Sequence[Row] | None = None) -> Path:
    """Write a recorded experiment to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "experiment.json").write_text(json.dumps(experiment() if content is None else content), encoding="utf-8")
    with (folder / "scans.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["sensor", "pose", "plane_height", "angle_deg", "measured", "predicted"])
        writer.writerows(["" if cell is None else cell for cell in row] for row in (rows() if scans is None else scans))
    return folder


def names(items: Sequence[Any]) -> list[str]:
    return [item if isinstance(item, str) else item["name"] for item in items]


def expected(content: Mapping[str, Any], scans: Sequence[Row]) -> dict[str, Any]:
    """Compute `experiment`, `before` and `rules` of the report of an evaluation with the twin."""
    poses, sensors, grasps = (names(content[what]) for what in ("poses", "sensors", "grasps"))
    table = content.get("scores")
    if table is None:
        table = {g: {p: content["successes"][g][p] / content["attempts"] for p in poses} for g in grasps}
    scores = [[table[grasp][pose] for pose in poses] for grasp in grasps]
    lidar = {"beams": 360, "angle_min_deg": 0.0, "angle_increment_deg": 1.0} | dict(content.get("lidar", {}))
    no_return = content.get("observation", {}).get("no_return", 1.0)

    def scan(sensor: str, pose: str, column: int) -> list[float]:
        ranges = [math.inf] * int(lidar["beams"])
        for row in scans:
            value = row[column]
            if (row[0], row[1]) == (sensor, pose) and isinstance(value, float):
                index = round((row[3] - lidar["angle_min_deg"]) / lidar["angle_increment_deg"]) % len(ranges)
                ranges[index] = value if value <= no_return else math.inf
        return ranges

    belief = [1.0 / len(poses)] * len(poses)
    grasp, before = twin.best_grasp(scores, belief)
    report: dict[str, Any] = {}
    for rule, own in RULES.items():
        parameters = own | {"no_return_m": no_return}
        report[rule] = {}
        for sensor in sensors:
            predicted = [scan(sensor, pose, 5) for pose in poses]
            logs = [[twin.log_weight(rule, parameters, seen, other) for other in predicted] for seen in predicted]
            apart = [[twin.distance(seen, other, no_return) for other in predicted] for seen in predicted]
            policy = "nearest" if rule == "margin" else "reject"
            beliefs = {}
            for pose in poses:
                if not any((r[0], r[1]) == (sensor, pose) and r[4] is not None for r in scans):
                    continue
                seen = scan(sensor, pose, 4)
                beliefs[pose] = twin.update(
                    belief,
                    [twin.log_weight(rule, parameters, seen, other) for other in predicted],
                    [twin.distance(seen, other, no_return) for other in predicted],
                    len(seen),
                    on_no_match=policy,
                ).belief
            everywhere = len(beliefs) == len(poses)
            report[rule][sensor] = {
                "voa": twin.value_of_assistance(scores, belief, logs, apart, on_no_match=policy),
                "aecd": twin.executed_value(scores, belief, list(beliefs.values())) if everywhere else None,
                "beliefs": beliefs,
            }
    return {
        "experiment": content["name"],
        "poses": poses,
        "sensors": sensors,
        "before": {"best_grasp": None if grasp is None else grasps[grasp], "expected_score": before},
        "rules": report,
    }
