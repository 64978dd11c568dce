"""The end of `voa demo`: its first session is kept, and shown in the console to those who want it."""

import io
import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import httpx2
import pytest
from rich.console import Console

from tests.support.serving import data_scenario
from voa_cli.demo_console import DATABASE, kept, offer_console
from voa_client import Client, ScenarioRequest, SessionRequest
from voa_client.local import local_service
from voa_fleet.show.interruption import TimeIsUp


def open_session(client: Client) -> str:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    return client.create_session(SessionRequest(scenario=scenario.id)).id


def sessions_of(client: Client) -> set[str]:
    return {summary.id for summary in client.list_sessions()}


def test_in_a_pipe_the_command_is_printed_and_nothing_is_waited_for(tmp_path: Path) -> None:
    out = io.StringIO()
    offer_console(tmp_path, "s1", Console(file=out, width=200), interactive=False)
    printed = out.getvalue()
    assert f"voa serve --console --database-url sqlite:///{tmp_path / DATABASE}\n" in printed
    assert "http://127.0.0.1:8080/sessions/s1" in printed
    assert "Enter" not in printed


def test_of_the_sessions_of_a_demo_the_first_is_kept_and_of_other_sessions_each(process: str) -> None:
    with Client(process) as client:
        other = open_session(client)
        with kept(client, lambda: first) as sweep:
            first = open_session(client)
            further = [open_session(client) for _ in range(3)]
            sweep()
            assert not sessions_of(client) & set(further)
            further.append(open_session(client))
        assert {other, first} <= sessions_of(client)
        assert not sessions_of(client) & set(further)


def test_a_demo_whose_time_is_up_keeps_the_first_session_alone(process: str) -> None:
    with Client(process) as client:
        with suppress(TimeIsUp), kept(client, lambda: first):
            first = open_session(client)
            further = open_session(client)
            raise TimeIsUp
        assert first in sessions_of(client)
        assert further not in sessions_of(client)


@pytest.mark.parametrize("answer", ["\n", None])
def test_enter_opens_the_session_and_ctrl_c_ends_it(answer: str | None, tmp_path: Path) -> None:
    with local_service(tmp_path, DATABASE) as url, Client(url) as client:
        session = open_session(client)
    program = (
        "from rich.console import Console; from pathlib import Path; from voa_cli.demo_console import offer_console;"
        f"offer_console(Path({str(tmp_path)!r}), {session!r}, Console(width=200), interactive=True)"
    )
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        while "press Enter" not in (line := process.stdout.readline()):
            assert line, "the demo ended without an offer"
        if answer is not None:
            process.stdin.write(answer)
            process.stdin.flush()
            printed = process.stdout.readline()
            where = re.search(r"http://127\.0\.0\.1:\d+/sessions/\w+", printed)
            assert where is not None, printed
            assert where[0].endswith(session)
            assert httpx2.get(where[0], timeout=60.0).status_code == 200
        process.send_signal(signal.SIGINT)
        rest = process.communicate(timeout=60.0)[0]
    assert process.returncode == 0
    assert "Traceback" not in rest
