"""`voa sessions`, and session files that replay elsewhere."""

import json
import sys
from io import StringIO
from pathlib import Path

import pytest

from tests.support.quiet_robot import QuietRobot
from tests.support.serving import Service, data_scenario
from voa_assets import path as asset_path
from voa_cli import sessions
from voa_cli.main import main
from voa_client import Client, InProcessTransport
from voa_client.scenario_files import load_scenario
from voa_msgs.geometry import Spread
from voa_msgs.looks import LookAnnouncement
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, Scan, ScanRequest, SessionRequest
from voa_recordings.session_file import export_session, read_session_file, rebuild_session
from voa_service.rpc.entry import Rpc

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


def test_sessions_are_listed_and_shown_with_their_history(
    process: str, session: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for command in (["list"], ["show", session], ["history", session]):
        assert main(["sessions", *command, "--url", process]) == 0
    content = capsys.readouterr().out
    assert content.count(session) == 2
    assert "OI90" in content
    assert [kind in content for kind in ("prior", "scan", "outcome", "belief")] == [True] * 4


def test_json_is_one_document(process: str, session: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sessions", "list", "--json", "--url", process]) == 0
    assert session in [item["id"] for item in json.loads(capsys.readouterr().out)]
    assert main(["sessions", "history", session, "--json", "--url", process]) == 0
    assert [entry["version"] for entry in json.loads(capsys.readouterr().out)] == [0, 1, 2, 3, 4]


def test_a_list_names_the_scenario_and_fits_80_columns_with_ids_whole(
    process: str, session: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with Client(process) as client:
        long = client.create_scenario(ScenarioRequest.model_validate(data_scenario(name="a long name " * 10)))
        other = client.create_session(SessionRequest(scenario=long.id)).id
    assert main(["sessions", "list", "--url", process]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    [line] = [line for line in lines if session in line]
    assert " mug" in line
    assert any(other in line for line in lines)
    assert "…" not in "".join(lines)
    (headings,) = [line.split() for line in lines if line.split()[:1] == ["session"]]
    absences = [heading for heading in headings if heading == "absent"]  # of sessions of other tests
    assert headings == ["session", "scenario", "version", "grasp", "score", *absences, "updated"]
    assert main(["sessions", "list", "--json", "--url", process]) == 0
    items = {item["id"]: item for item in json.loads(capsys.readouterr().out)}
    assert (items[session]["scenario_name"], items[session]["robots"], items[session]["version"]) == ("mug", [], 4)
    assert items[other]["scenario_name"] == "a long name " * 10


def test_a_list_shows_whose_robots_scans_are(
    service: Service, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    scenario = service.create(data_scenario())
    for robot in ("tb3_1", "tb3_2"):
        service.inside.robots.mapped(robot, "scan", QuietRobot(), scenario=scenario)
    claimed = service.open(scenario, robots=["tb3_1", "tb3_2"])
    newer = service.open(scenario)
    own = Client(InProcessTransport(Rpc(service.inside)))
    monkeypatch.setattr(sessions, "Client", lambda url, retries: own)
    assert main(["sessions", "list", "--json"]) == 0
    items = {item["id"]: item["robots"] for item in json.loads(capsys.readouterr().out)}
    assert (items[claimed], items[newer]) == (["tb3_1", "tb3_2"], [])
    assert main(["sessions", "list"]) == 0
    content = capsys.readouterr().out.splitlines()
    assert max(map(len, content)) <= 80
    assert "tb3_1" in next(line for line in content if claimed in line)
    assert any("tb3_2" in line for line in content)
    monkeypatch.setattr(sys, "stdin", Terminal("y\n"))
    assert main(["sessions", "delete", claimed]) == 0
    assert f"delete {claimed} at version 0 (session of tb3_1, tb3_2) with" in capsys.readouterr().err


class Terminal(StringIO):
    """Words that a person types."""

    def isatty(self) -> bool:
        return True


def opened(process: str, count: int = 1) -> list[str]:
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        return [client.create_session(SessionRequest(scenario=scenario.id)).id for _ in range(count)]


def there(process: str, ids: list[str]) -> list[str]:
    """Return the ids of those sessions that the service still has."""
    with Client(process) as client:
        return [session.id for session in client.list_sessions() if session.id in ids]


@pytest.mark.parametrize("yes", ["--yes", "-y"])
def test_sessions_are_deleted_without_a_question_where_that_is_said(
    process: str, capsys: pytest.CaptureFixture[str], yes: str
) -> None:
    ids = opened(process, 3)
    assert main(["sessions", "delete", ids[0], ids[2], ids[0], yes, "--url", process]) == 0
    content = capsys.readouterr()
    assert content.out.splitlines() == [f"deleted {ids[0]}", f"deleted {ids[2]}"]
    assert content.err == ""
    assert there(process, ids) == [ids[1]]


@pytest.mark.parametrize(("typed", "deleted"), [("y\n", True), ("YES\n", True), ("\n", False), ("", False), ("n\n", 0)])
def test_a_person_confirms_before_sessions_are_deleted(
    process: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, typed: str, deleted: bool
) -> None:
    ids = opened(process)
    monkeypatch.setattr(sys, "stdin", Terminal(typed))
    assert main(["sessions", "delete", *ids, "--url", process]) == (0 if deleted else 1)
    content = capsys.readouterr()
    assert f"delete {ids[0]} at version 0 with the whole history? [y/N] " in content.err
    assert ("nothing deleted" in content.err) is not bool(deleted)
    assert there(process, ids) == ([] if deleted else ids)


def test_in_a_pipe_nothing_is_deleted_without_yes(
    process: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    ids = opened(process)
    monkeypatch.setattr(sys, "stdin", StringIO("y\n"))
    assert main(["sessions", "delete", *ids, "--url", process]) == 1
    assert f"add --yes to delete {ids[0]} at version 0" in capsys.readouterr().err
    assert there(process, ids) == ids


def test_where_one_session_is_not_there_none_is_deleted(process: str, capsys: pytest.CaptureFixture[str]) -> None:
    ids = opened(process)
    assert main(["sessions", "delete", *ids, "nobody", "--yes", "--url", process]) == 1
    assert "there is no session 'nobody'" in capsys.readouterr().err
    assert there(process, ids) == ids


def test_a_session_that_claimed_robots_replays_without_them(
    service: Service, process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario = service.create(data_scenario())
    service.inside.robots.mapped("live", "scan", QuietRobot(), scenario=scenario)
    session = service.open(scenario, robots=["live"])
    inside = Client(InProcessTransport(Rpc(service.inside)))
    exported = tmp_path / "session.json"
    exported.write_text(export_session(inside, session).model_dump_json(), encoding="utf-8")
    assert main(["replay", str(exported), "--url", process]) == 0, "where no such robot is mapped"
    assert rebuild_session(inside, read_session_file(exported)).same
    assert service.inside.robots.report("live").session == session, "a replay takes nobody's robots"


def test_an_exported_session_replays_on_another_service_to_the_same_belief(
    process: str, session: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sessions", "export", session, "--url", process]) == 0
    exported = tmp_path / "session.json"
    exported.write_text(capsys.readouterr().out, encoding="utf-8")
    assert main(["replay", str(exported), "--mesh", str(MUG / "mug.obj")]) == 0
    assert "its belief is exactly the recorded one" in " ".join(capsys.readouterr().out.split())


def test_a_session_whose_mesh_is_not_there_says_so(
    process: str, session: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sessions", "export", session, "--url", process]) == 0
    exported = tmp_path / "session.json"
    exported.write_text(capsys.readouterr().out, encoding="utf-8")
    assert main(["replay", str(exported)]) == 1
    assert "give its mesh with `voa replay --mesh FILE`" in capsys.readouterr().err


def test_a_session_that_does_not_exist_and_a_file_that_is_none_are_errors(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sessions", "show", "nobody", "--url", process]) == 1
    assert "there is no session 'nobody'" in capsys.readouterr().err
    (tmp_path / "no.json").write_text("{}", encoding="utf-8")
    assert main(["replay", str(tmp_path / "no.json"), "--url", process]) == 1
    assert "scenario: this field is required" in capsys.readouterr().err


def test_absence_places_and_looks_under_way_are_shown_where_there_are_any(
    process: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario(name="maybe", absent=0.25)))
        plain, own = (client.create_session(SessionRequest(scenario=scenario.id)).id for _ in range(2))
        client.apply_scan(own, ScanRequest(sensor="Q2", scan=Scan(ranges=[0.5, 0.5, None, 1.0])))
        absent = client.get_session(own).absent
        client.announce_look(own, LookAnnouncement(sensor="Q1", robot="scout"))
    assert absent is not None
    content = {}
    for command in (["list"], ["show", own], ["show", plain], ["history", own]):
        assert main(["sessions", *command, "--url", process]) == 0
        content[" ".join(command)] = capsys.readouterr().out
        lines = content[" ".join(command)].splitlines()
        assert max(len(line) for line in lines if "scenario" not in line) <= 80, "ids are not broken"
    lines = content["list"].splitlines()
    assert max(map(len, lines)) <= 80
    assert any(line.split()[:1] == ["session"] and "absent" in line.split() for line in lines)
    (line,) = [line for line in lines if plain in line]
    assert "0.25" in line.split()
    assert f"object at none of the poses: probability {absent:.3f}" in content[f"show {own}"]
    assert "looks: Q2 (1)" in content[f"show {own}"]
    assert "under way: Q1 by scout (until " in content[f"show {own}"]
    assert "looks:" not in content[f"show {plain}"]
    assert "under way" not in content[f"show {plain}"]
    assert "probability 0.250" in content[f"show {plain}"]
    entries = [line.split() for line in content[f"history {own}"].splitlines() if " prior " in line or " scan " in line]
    assert [entry[-1] for entry in entries] == ["0.25", f"{absent:.2f}"]


def test_scenarios_that_do_not_consider_absence_show_no_such_column(
    process: str, session: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for command in ("show", "history"):
        assert main(["sessions", command, session, "--url", process]) == 0
    assert "at none of the poses" not in (content := capsys.readouterr().out)
    assert "absent" not in content


def test_a_session_with_spread_absence_and_a_moved_object_is_rebuilt_to_the_bit(process: str, tmp_path: Path) -> None:
    with Client(process) as client:
        scenario = load_scenario(client, MUG / "scenario.json", spread=Spread(xy_m=0.005, yaw_rad=0.05), absent=0.1)
        own = client.create_session(SessionRequest(scenario=scenario.id)).id
        predicted = client.predict(scenario.id)
        for index, sensor in enumerate(predicted.sensors[:3]):
            ranges = predicted.ranges[index][1]
            nothing = [beam for beam, value in enumerate(ranges) if value is None]
            client.apply_scan(own, ScanRequest(sensor=sensor, scan=Scan(ranges=ranges, no_return=nothing)))
            if index == 0:
                client.report_outcome(own, OutcomeRequest(grasp="TD0", success=False, object_moved=0.3))
        path = tmp_path / "session.json"
        path.write_text(export_session(client, own).model_dump_json(), encoding="utf-8")
        rebuilt = rebuild_session(client, read_session_file(path))
        first = client.get_session(own)
    assert rebuilt.same
    assert rebuilt.session.absent == first.absent
    assert rebuilt.session.places == first.places
    assert first.absent is not None
    assert 0.0 < first.absent < 0.1
