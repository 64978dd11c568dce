"""`voa sessions`, and session files that replay elsewhere."""

import json
from pathlib import Path

import pytest

from voa_assets import path as asset_path
from voa_cli.main import main
from voa_cli.scenario_file import load_scenario
from voa_client import Client
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, Scan, ScanRequest, SessionRequest

MUG = asset_path("mug")


@pytest.fixture
def session(process: str) -> str:
    """A session with a scan, an outcome, a replaced belief and a scan from anywhere."""
    with Client(process) as client:
        scenario = load_scenario(client, MUG / "scenario.json")
        own = client.create_session(SessionRequest(scenario=scenario.id)).id
        ranges = client.predict(scenario.id).ranges[0][1]
        nothing = [index for index, value in enumerate(ranges) if value is None]
        client.apply_scan(own, ScanRequest(sensor="ENE", scan=Scan(ranges=ranges, no_return=nothing)))
        client.report_outcome(own, OutcomeRequest(grasp="TD0", success=False))
        client.put_belief(own, BeliefRequest(belief=None))
        client.apply_scan(own, ScanRequest(sensor="ENE", scan=Scan(ranges=ranges)))
    return own


def test_sessions_are_listed_shown_and_told(process: str, session: str, capsys: pytest.CaptureFixture[str]) -> None:
    for command in (["list"], ["show", session], ["history", session]):
        assert main(["sessions", *command, "--url", process]) == 0
    told = capsys.readouterr().out
    assert told.count(session) == 2
    assert "OI90" in told
    assert [kind in told for kind in ("prior", "scan", "outcome", "belief")] == [True] * 4


def test_json_is_one_document(process: str, session: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sessions", "list", "--json", "--url", process]) == 0
    assert session in [item["id"] for item in json.loads(capsys.readouterr().out)]
    assert main(["sessions", "history", session, "--json", "--url", process]) == 0
    assert [entry["version"] for entry in json.loads(capsys.readouterr().out)] == [0, 1, 2, 3, 4]


def test_an_exported_session_replays_on_another_service_to_the_same_belief(
    process: str, session: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sessions", "export", session, "--url", process]) == 0
    exported = tmp_path / "session.json"
    exported.write_text(capsys.readouterr().out, encoding="utf-8")
    assert main(["replay", str(exported), "--mesh", str(MUG / "mug.obj")]) == 0
    assert "believes exactly what the first one did" in " ".join(capsys.readouterr().out.split())


def test_a_session_whose_mesh_is_not_there_says_so(
    process: str, session: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sessions", "export", session, "--url", process]) == 0
    exported = tmp_path / "session.json"
    exported.write_text(capsys.readouterr().out, encoding="utf-8")
    assert main(["replay", str(exported)]) == 1
    assert "name its mesh, with `voa replay --mesh FILE`" in capsys.readouterr().err


def test_a_session_that_does_not_exist_and_a_file_that_is_none_are_errors(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sessions", "show", "nobody", "--url", process]) == 1
    assert "there is no session 'nobody'" in capsys.readouterr().err
    (tmp_path / "no.json").write_text("{}", encoding="utf-8")
    assert main(["replay", str(tmp_path / "no.json"), "--url", process]) == 1
    assert "scenario: expected, but it is not there" in capsys.readouterr().err
