"""`voa prune` deletes whole sessions by age, and says which."""

import argparse
import json
from datetime import timedelta
from pathlib import Path

import pytest

from tests.support.serving import data_scenario
from voa_cli.prune import age, main
from voa_client import Client, NotFoundError
from voa_client.local import local_service
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import SessionRequest


def opened(client: Client) -> str:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    return client.create_session(SessionRequest(scenario=scenario.id)).id


def test_only_old_sessions_are_deleted_and_a_dry_run_deletes_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with local_service(tmp_path) as url, Client(url) as client:
        session = opened(client)
        assert main(["--older-than", "1h", "--url", url]) == 0
        assert capsys.readouterr().out.startswith("0 sessions deleted: last moved before 20")
        assert main(["--older-than", "0h", "--dry-run", "--json", "--url", url]) == 0
        listed = json.loads(capsys.readouterr().out)
        assert listed["dry_run"]
        assert session in listed["sessions"]
        assert client.get_session(session).version == 0
        assert main(["--older-than", "0h", "--url", url]) == 0
        *lines, last = capsys.readouterr().out.splitlines()
        assert any(line.startswith(f"{session}  version 0, last moved 20") for line in lines)
        assert last.startswith(f"{len(lines)} session")
        with pytest.raises(NotFoundError):
            client.get_session(session)


@pytest.mark.parametrize(
    ("text", "expected"),
    [("12h", timedelta(hours=12)), ("30d", timedelta(days=30)), ("1.5w", timedelta(days=10.5)), ("0d", timedelta(0))],
)
def test_ages(text: str, expected: timedelta) -> None:
    assert age(text) == expected


@pytest.mark.parametrize("text", ["", "30", "30 d", "-1d", "1m", "9999999999d"])
def test_other_texts_are_no_age(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="expected"):
        age(text)


def test_a_service_that_is_not_there_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--older-than", "30d", "--url", "http://127.0.0.1:9"]) == 1
    assert capsys.readouterr().err.startswith("voa prune: ")
