"""`voa rank` with a scenario file, a belief, a session."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.serving import box_obj, data_scenario, mesh_scenario
from voa_assets import path as asset
from voa_cli.main import main
from voa_client import Client
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import SessionRequest


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(data_scenario()), encoding="utf-8")
    return path


def ranked(capfd: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main(["rank", *arguments, "--json"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    return json.loads(out)


def test_a_file_a_belief_and_a_session_give_the_same_ranking(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    belief = [0.2, 0.3, 0.5]
    beside = file.with_name("belief.json")
    beside.write_text(json.dumps({"belief": belief}), encoding="utf-8")
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id, prior=belief))
    found = [
        ranked(capfd, str(file), "--belief", "0.2,0.3,0.5", "--url", process),
        ranked(capfd, str(file), "--belief", str(beside), "--url", process),
        ranked(capfd, "--session", session.id, "--url", process),
    ]
    assert [ranking.pop("version") for ranking in found] == [None, None, 0]
    assert found[0] == found[1] == found[2]
    assert {look["sensor"] for look in found[0]["ranking"]} == {"Q1", "Q2"}


def test_without_a_belief_it_is_the_scenario_s_prior(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    uniform = ranked(capfd, str(file), "--belief", ",".join([str(1 / 3)] * 3), "--url", process)
    own = ranked(capfd, str(file), "--url", process)
    assert own["expected_score_before"] == pytest.approx(uniform["expected_score_before"])
    voa = [{look["sensor"]: look["voa"] for look in ranking["ranking"]} for ranking in (own, uniform)]
    assert voa[0] == pytest.approx(voa[1])


def test_definition_and_grasps_are_passed_on(capfd: pytest.CaptureFixture[str], process: str, file: Path) -> None:
    ranking = ranked(capfd, str(file), "--definition", "executed", "--grasps", "G2", "--url", process)
    assert (ranking["definition"], ranking["best_grasp_before"]) == ("executed", "G2")


def test_a_mesh_beside_the_file_is_uploaded(capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path) -> None:
    (tmp_path / "box.obj").write_text(box_obj(), encoding="utf-8")
    (tmp_path / "scenario.json").write_text(json.dumps(mesh_scenario("box.obj")), encoding="utf-8")
    ranking = ranked(capfd, str(tmp_path / "scenario.json"), "--url", process)
    assert {look["sensor"] for look in ranking["ranking"]} == {"E", "N"}


def test_a_person_reads_a_table(capfd: pytest.CaptureFixture[str], process: str) -> None:
    assert main(["rank", str(asset("mug/scenario.json")), "--url", process]) == 0
    out = capfd.readouterr().out
    assert "best grasp without a look: TD90, expected score 0.400" in out
    assert "look from" in out


@pytest.mark.parametrize(
    "arguments", [[], ["a.json", "--session", "s"], ["--session", "s"], ["--session", "s", "--belief", "1"]]
)
def test_what_does_not_go_together_is_a_usage_error(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["rank", *arguments])
    assert ended.value.code == 2
    assert "usage: voa rank" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "No such file"),
        ("{", "is not JSON"),
        ("[]", "scenario.json"),
        ('{"name": "a"}', "poses"),
        (json.dumps(data_scenario(object="missing.obj")), "no object 'missing.obj'"),
        (b"\xff\xfe", "scenario.json"),
    ],
)
def test_a_scenario_file_that_is_wrong_is_said_so(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: str | bytes | None, says: str
) -> None:
    path = tmp_path / "scenario.json"
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert main(["rank", str(path), "--url", process]) == 1
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("voa rank: ")
    assert says in err


@pytest.mark.parametrize("belief", ["a,b,c", "", "0.5;0.5"])
def test_a_belief_that_is_none_is_said_so(
    capfd: pytest.CaptureFixture[str], process: str, file: Path, belief: str
) -> None:
    assert main(["rank", str(file), "--url", process, "--belief", belief]) == 1
    assert "--belief: expected" in capfd.readouterr().err


def test_a_belief_that_does_not_sum_to_1_is_refused_by_the_service(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    assert main(["rank", str(file), "--url", process, "--belief", "0.1,0.1,0.1"]) == 1
    assert "within 1e-6 of 1" in capfd.readouterr().err
