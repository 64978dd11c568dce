"""`voa rank` as a person reads it: tables, bars, ties, and the recommendation."""

import json
from pathlib import Path

import pytest

from voa_assets import path as asset
from voa_cli.main import main


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
