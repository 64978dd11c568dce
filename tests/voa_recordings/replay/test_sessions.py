"""Sessions in recordings: rebuilt as far as they were recorded, and what is missing is said."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer
from pydantic import BaseModel

from tests.support.serving import data_scenario
from tests.voa_recordings.files.bags import START_NS
from voa_assets import path as asset_path
from voa_cli.main import main
from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import OutcomeRequest, Scan, ScanRequest, SessionRequest
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.files.sessions import topic_of
from voa_recordings.files.writer import RecordingWriter

TYPES = RosTypes()
MUG = asset_path("mug")

SessionMessage = tuple[str, str, BaseModel | bytes]
"""Session, kind, message."""


@pytest.fixture(scope="module")
def content(process: str) -> list[SessionMessage]:
    """Messages of a session with three versions, in the order of a recording."""
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        begun = client.create_session(SessionRequest(scenario=scenario.id))
        own = begun.id
        scan = ScanRequest(sensor="Q1", scan=Scan(ranges=[0.5, 0.5, None, 1.0], no_return=[2]))
        client.apply_scan(own, scan)
        first = client.get_session(own)
        client.report_outcome(own, OutcomeRequest(grasp="G1", success=False))
        beliefs = [begun, first, client.get_session(own)]
        history = list(client.history(own))
    result: list[SessionMessage] = [("s1", "scenario", scenario)]
    for state, entry in zip(beliefs, history, strict=True):
        result += [("s1", "belief", state), ("s1", "history", entry)]
    return result


def written(path: Path, messages: Iterable[SessionMessage]) -> Path:
    with path.open("wb") as file:
        writer = RecordingWriter(file, TYPES)
        for session, what, message in messages:
            body = message if isinstance(message, bytes) else message.model_dump_json().encode()
            topic = topic_of(session, what)
            writer.add_json(topic, body, log_ns=START_NS, publish_ns=START_NS, key=topic)
        writer.finish()
    return path


def replayed(capsys: pytest.CaptureFixture[str], process: str, path: Path, *more: str) -> tuple[int, list[Any]]:
    code = main(["replay", str(path), "--url", process, "--json", *more])
    out, err = capsys.readouterr()
    assert err == ""
    sessions: list[Any] = json.loads(out)["sessions"]
    return code, sessions


def test_all_of_it(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: list[SessionMessage]
) -> None:
    code, [again] = replayed(capsys, process, written(tmp_path / "x.mcap", content))
    assert (code, again["same"], again["session"]["version"], again["lacks"]) == (0, True, 2, None)


def test_an_older_recording_with_json_channels_gives_the_same(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: list[SessionMessage]
) -> None:
    path = tmp_path / "old.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        for session, what, message in content:
            assert isinstance(message, BaseModel)
            schema = writer.register_schema(type(message).__name__, "jsonschema", b"{}")
            channel = writer.register_channel(topic_of(session, what), "json", schema)
            writer.add_message(channel, START_NS, message.model_dump_json().encode(), START_NS)
        writer.finish()
    old = replayed(capsys, process, path)
    new = replayed(capsys, process, written(tmp_path / "new.mcap", content))
    assert [(code, item["same"], item["session"]["belief"]) for code, (item,) in (old, new)] == [
        (0, True, old[1][0]["session"]["belief"])
    ] * 2


@pytest.mark.parametrize(
    ("left_out", "version"),
    [([-1], 1), ([-2], 1), ([3], 2), ([3, 5], 0), ([4, 6], 0)],
    ids=["last history", "last belief", "a belief between", "all but the first belief", "all but the first history"],
)
def test_a_session_is_rebuilt_as_far_as_it_is_complete(
    capsys: pytest.CaptureFixture[str],
    process: str,
    tmp_path: Path,
    content: list[SessionMessage],
    left_out: list[int],
    version: int,
) -> None:
    gone = {index % len(content) for index in left_out}
    kept = [message for index, message in enumerate(content) if index not in gone]
    code, [again] = replayed(capsys, process, written(tmp_path / "x.mcap", kept))
    assert (code, again["same"], again["session"]["version"]) == (0, True, version)


@pytest.mark.parametrize(("left_out", "lacks"), [(0, "its scenario"), (2, "no version has both")])
def test_a_session_that_lacks_something_is_named(
    capsys: pytest.CaptureFixture[str],
    process: str,
    tmp_path: Path,
    content: list[SessionMessage],
    left_out: int,
    lacks: str,
) -> None:
    kept = [message for index, message in enumerate(content) if index != left_out]
    path = written(tmp_path / "x.mcap", kept)
    code, [again] = replayed(capsys, process, path)
    assert (code, again["same"], again["session"]) == (1, None, None)
    assert again["lacks"].startswith(lacks)
    assert main(["replay", str(path), "--url", process]) == 1
    assert f"session s1 cannot be rebuilt: {lacks}" in " ".join(capsys.readouterr().out.split())


def test_another_belief_is_an_error(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: list[SessionMessage]
) -> None:
    session, what, last = content[-2]
    assert isinstance(last, BaseModel)
    otherwise = last.model_copy(update={"belief": [0.2, 0.3, 0.5]})
    path = written(tmp_path / "x.mcap", [*content, (session, what, otherwise)])
    code, [again] = replayed(capsys, process, path)
    assert (code, again["same"]) == (1, False)
    assert main(["replay", str(path), "--url", process]) == 1
    assert "its belief DIFFERS from the recorded one" in " ".join(capsys.readouterr().out.split())


def test_a_message_that_is_none_is_an_error(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: list[SessionMessage]
) -> None:
    path = written(tmp_path / "x.mcap", [*content, ("s1", "history", b"{}")])
    assert main(["replay", str(path), "--url", process]) == 1
    assert "/voa/s1/history: version: this field is required" in capsys.readouterr().err


def test_a_mesh_is_given_where_the_service_has_none(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: list[SessionMessage]
) -> None:
    with Client(process) as client:
        scenario = load_scenario(client, MUG / "scenario.json")
        session = client.create_session(SessionRequest(scenario=scenario.id))
        mug: list[SessionMessage] = [("s2", "scenario", scenario), ("s2", "belief", session)]
        mug += [("s2", "history", entry) for entry in client.history(session.id)]
    path = written(tmp_path / "x.mcap", [*mug, *content])
    assert main(["replay", str(path)]) == 1
    assert "give its mesh with `voa replay --mesh FILE`" in capsys.readouterr().err
    assert main(["replay", str(path), "--mesh", str(MUG / "mug.obj")]) == 0
    assert " ".join(capsys.readouterr().out.split()).count("its belief is exactly the recorded one") == 2
    alone = written(tmp_path / "y.mcap", content)
    assert main(["replay", str(alone), "--url", process, "--mesh", str(MUG / "mug.obj")]) == 1
    assert "but the sessions need none" in capsys.readouterr().err
