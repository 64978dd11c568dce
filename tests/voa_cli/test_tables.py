"""`voa rank` as a person reads it: tables, bars, ties, and the recommendation."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import data_scenario
from voa_assets import path as asset
from voa_cli.main import main
from voa_client import Client, Scan, ScanRequest, ScenarioRequest, SessionRequest

Json = dict[str, Any]


def test_a_person_reads_a_table(capfd: pytest.CaptureFixture[str], process: str) -> None:
    assert main(["rank", str(asset("mug/scenario.json")), "--url", process]) == 0
    out = capfd.readouterr().out
    assert "best grasp without a look: TD90, expected score 0.400" in out
    assert "0 to 0.155" in out
    assert "look from ENE first: its net value +0.155 is more than min_gain 0.005" in out
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.parametrize("name", ["mug", "mallet", "block"])
def test_under_a_certain_belief_no_look_is_shown_as_worth_anything(
    capfd: pytest.CaptureFixture[str], process: str, name: str
) -> None:
    path = asset(f"{name}/scenario.json")
    belief = [1.0, *[0.0] * (len(json.loads(path.read_bytes())["poses"]) - 1)]
    assert main(["rank", str(path), "--belief", ",".join(map(str, belief)), "--url", process]) == 0
    out = capfd.readouterr().out
    assert "+0.000" not in out
    assert "look from" not in out
    assert "now, expected score" in " ".join(out.split())
    assert "(all: 0)" in " ".join(out.split())
    rows = [line for line in out.splitlines() if line.startswith("│")]
    assert [row.split()[1] for row in rows] == ["=1"] * len(rows)
    assert "█" not in out


def test_a_small_gain_is_grasped_and_a_scenario_may_require_less(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    document = json.loads(asset("mug/scenario.json").read_bytes())
    document["object"] = str(asset("mug/mug.obj"))
    for min_gain, says in (
        (0.005, "no look's net value is more than min_gain 0.005"),
        (0.001, "is more than min_gain 0.001"),
    ):
        (tmp_path / "scenario.json").write_text(json.dumps(document | {"min_gain": min_gain}), encoding="utf-8")
        arguments = [str(tmp_path / "scenario.json"), "--belief", "0.995,0,0.005,0,0,0", "--url", process]
        assert main(["rank", *arguments]) == 0
        assert says in " ".join(capfd.readouterr().out.split())


def test_costs_fit_80_columns_and_names_in_brackets_are_printed(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    document = json.loads(asset("block/scenario.json").read_bytes())
    document["object"] = str(asset("block/block.obj"))
    for index, sensor in enumerate(document["sensors"]):
        sensor |= {"cost": 0.03 * index, "name": f"[{sensor['name']}]"}
    (tmp_path / "scenario.json").write_text(json.dumps(document), encoding="utf-8")
    assert main(["rank", str(tmp_path / "scenario.json"), "--url", process]) == 0
    out = capfd.readouterr().out
    assert max(map(len, out.splitlines())) <= 80
    assert "│ [NNE]  │ +0.169 │ █" in out
    assert "│ 0.030 │    +0.139 │" in out
    assert "look from [NNE] first: its net value +0.139" in out


@pytest.mark.parametrize(("columns", "bars"), [(60, False), (72, False), (74, True), (100, True)])
def test_bars_are_drawn_where_a_line_has_room_beside_whole_figures(
    capfd: pytest.CaptureFixture[str],
    process: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    columns: int,
    bars: bool,
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    document = json.loads(asset("block/scenario.json").read_bytes())
    document["object"] = str(asset("block/block.obj"))
    document["sensors"][0]["cost"] = 0.01
    (tmp_path / "scenario.json").write_text(json.dumps(document), encoding="utf-8")
    assert main(["rank", str(tmp_path / "scenario.json"), "--url", process]) == 0
    out = capfd.readouterr().out
    assert max(map(len, out.splitlines())) <= columns
    assert "…" not in out
    assert ("█" in out) is bars


def spread(tmp_path: Path, **changes: Any) -> Path:
    """Write the block's scenario with a spread, and costs that grow from place to place."""
    document = json.loads(asset("block/scenario.json").read_bytes())
    document |= {"object": str(asset("block/block.obj")), "spread": {"xy_m": 0.005, "yaw_rad": 0.05}} | changes
    for index, sensor in enumerate(document["sensors"]):
        sensor["cost"] = 0.01 * index
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def printed(capfd: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run `voa rank`, and return what it prints."""
    assert main(["rank", *arguments]) == 0
    return capfd.readouterr().out


@pytest.mark.parametrize(("columns", "heading"), [(60, False), (80, True)])
def test_values_over_simulated_scans_have_errors_and_whole_columns(
    capfd: pytest.CaptureFixture[str],
    process: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    columns: int,
    heading: bool,
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    out = printed(
        capfd, str(spread(tmp_path, absent=0.1)), "--sensor-std", "0.01,1", "--samples", "8", "--url", process
    )
    assert max(map(len, out.splitlines())) <= columns
    assert "…" not in out
    assert ("score after" in out) is heading
    words = " ".join(out.split())
    assert "object at none of the poses: probability 0.100 (scores hold if it is at one)" in words
    assert "VOA (executed) over 8 simulated scans of each pose" in words
    assert "can be gained by looking: the gain if the pose were known" in words
    rows = [line for line in out.splitlines() if line.startswith("│")]
    assert rows
    assert all(" ± " in row for row in rows)
    assert "by two standard errors" in words


def pair_scenario(cost: float) -> Json:
    """Scenario in which two looks are worth nothing alone: the grasp depends on whether both see the same."""
    near, far = [0.3] * 4, [1.9] * 4
    poses = ("P00", "P01", "P10", "P11")
    sight = {
        "left": {pose: far if pose[1] == "1" else near for pose in poses},
        "right": {pose: far if pose[2] == "1" else near for pose in poses},
    }
    sensors = [
        {"name": name, "x": x, "y": 0.0, "yaw_rad": 0.0, "cost": cost} for name, x in (("left", -1.0), ("right", 1.0))
    ]
    scores = [[0.9, 0.1, 0.1, 0.9], [0.1, 0.9, 0.9, 0.1]]
    return data_scenario(
        name="pair",
        poses=[{"name": pose} for pose in poses],
        scores={"probabilities": scores},
        sensors=sensors,
        predictions=sight,
        update={"rule": "gaussian", "sigma_m": 0.1},
    )


@pytest.mark.parametrize(
    ("cost", "options", "says"),
    [
        (0.03, (), "look from left, then from right: together their net value +0.340 is more than min_gain 0.005"),
        (0.03, ("--lookahead", "1"), "grasp G1 now, expected score 0.500"),
        (0.03, ("--from", "left", "--cost-per-m", "0.1"), "together their net value +0.140"),
        (0.03, ("--from", "0,0", "--cost-per-m", "0.1"), "together their net value +0.040"),
        (0.03, ("--pending", "left"), "look from right first: its net value +0.370"),
        (0.25, (), "grasp G1 now, expected score 0.500"),
    ],
)
def test_a_pair_is_printed_with_its_value(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path, cost: float, options: tuple[str, ...], says: str
) -> None:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(pair_scenario(cost)), encoding="utf-8")
    out = " ".join(printed(capfd, str(path), *options, "--url", process).split())
    assert says in out
    if "--pending" not in options:
        assert "at most +0.400 can be gained by looking" in out


def test_looks_taken_from_a_place_are_counted(capfd: pytest.CaptureFixture[str], process: str) -> None:
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id)).id
        out = printed(capfd, "--session", session, "--url", process)
        assert "looks taken" not in out
        client.apply_scan(session, ScanRequest(sensor="Q2", scan=Scan(ranges=[0.5, 0.5, None, 1.0])))
    out = printed(capfd, "--session", session, "--url", process)
    assert "looks taken" in out
    taken = {
        line.split("│")[2].strip(): line.split("│")[-2].strip() for line in out.splitlines() if line.startswith("│")
    }
    assert taken == {"Q1": "0", "Q2": "1"}


def test_an_object_that_is_probably_absent_is_warned_of(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(data_scenario(absent=0.6)), encoding="utf-8")
    assert main(["rank", str(path), "--url", process]) == 0
    out, err = capfd.readouterr()
    assert "object at none of the poses: probability 0.600" in out
    assert "warning: probably-absent" in err
