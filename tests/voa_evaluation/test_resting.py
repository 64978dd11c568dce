"""Poses are confirmed by letting go, and drops give a prior."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from voa_assets import path
from voa_cli.evaluate import command as evaluate
from voa_cli.evaluate import drops as command
from voa_evaluation.resting import (
    MOVING,
    OTHER,
    STABLE_RAD,
    RestCounts,
    drop_repeatedly,
    prior_from,
    rest_of,
    tilt_when_let_go,
)
from voa_fleet.world.objects import OBJECTS, FleetObject


@pytest.mark.parametrize("name", OBJECTS)
def test_every_pose_of_every_scenario_is_stable(targets: dict[str, FleetObject], name: str) -> None:
    target = targets[name]
    assert max(tilt_when_let_go(target, pose) for pose in target.poses) < STABLE_RAD / 10.0


def test_a_pose_that_is_not_stable_is_detected(mug: FleetObject) -> None:
    tilted = mug.pose("U_0").model_copy(update={"quaternion_wxyz": [0.9, 0.436, 0.0, 0.0], "position": [0, 0, 0.05]})
    scenario = mug.scenario.model_copy(update={"poses": [tilted]})
    target = replace(mug, scenario=scenario)
    assert tilt_when_let_go(target, "U_0") > STABLE_RAD


@pytest.mark.parametrize("name", OBJECTS)
def test_drops_come_to_rest_in_ways_that_have_a_name(targets: dict[str, FleetObject], name: str) -> None:
    counts: list[int] = []
    drops = drop_repeatedly(targets[name], 24, seed=2, progress=counts.append)
    assert sum(counts) == drops.total == 24
    assert drops.counts[OTHER] <= 1
    assert drops.counts[MOVING] <= 4
    assert sum(count > 0 for count in drops.counts.values()) >= 3


def test_the_same_seed_drops_the_same_way(mug: FleetObject) -> None:
    assert drop_repeatedly(mug, 6, seed=3) == drop_repeatedly(mug, 6, seed=3)


def test_the_prior_shares_each_way_to_rest_among_its_poses(mug: FleetObject) -> None:
    drops = RestCounts("mug", {"upright": 30, "upside down": 10, "on its side": 55, OTHER: 3, MOVING: 2}, 0)
    prior = prior_from(mug, drops)
    assert sum(prior) == pytest.approx(1.0)
    assert prior[mug.poses.index("D_90")] == pytest.approx(0.25)
    assert prior[mug.poses.index("U_45")] == pytest.approx(0.15)


def test_without_a_drop_into_a_pose_there_is_no_prior(mug: FleetObject) -> None:
    nowhere = RestCounts("mug", {"upright": 0, "upside down": 0, "on its side": 5, OTHER: 0, MOVING: 0}, 0)
    with pytest.raises(ValueError, match="in 5 drops the mug never came to rest"):
        prior_from(mug, nowhere)


@pytest.mark.parametrize(
    ("up", "name"),
    [((0.0, 0.0, 1.0), "upright"), ((0.05, 0.0, -1.0), "upside down"), ((1.0, 0.0, 0.0), OTHER)],
)
def test_a_way_to_rest_is_identified_by_the_axis_that_points_up(
    mug: FleetObject, up: tuple[float, ...], name: str
) -> None:
    direction = np.array(up)
    assert rest_of(mug, direction / np.linalg.norm(direction)) == name


def test_the_command_reports_counts_prior_and_stability(capsys: pytest.CaptureFixture[str]) -> None:
    assert evaluate.main(["drops", "block", "--drops", "20", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert sum(rest["count"] for rest in report["rests"]) == report["drops"] == 20
    assert sum(pose["prior"] for pose in report["poses"]) == pytest.approx(1.0)
    assert all(pose["stable"] for pose in report["poses"])


def test_the_command_fails_where_a_pose_is_not_stable(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "own"
    shutil.copytree(path("block"), folder)
    body = json.loads((folder / "scenario.json").read_text(encoding="utf-8"))
    body["poses"][0] |= {"quaternion_wxyz": [0.94, 0.342, 0.0, 0.0], "position": [0, 0, 0.06]}
    (folder / "scenario.json").write_text(json.dumps(body), encoding="utf-8")
    assert command.main([str(folder), "--drops", "12"]) == 1
    said = capsys.readouterr().out
    assert "12 drops of the block" in said
    assert "NO" in said
