"""`voa doctor --json`, and what it found."""

import json
import socket
import time

import pytest

from voa_cli.main import main

LIMIT_SECONDS = 20.0
"""The command promises 15; the machine may be busy."""

Findings = dict[str, dict[str, str]]


def examined(capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, Findings]:
    """The exit code, and the findings by check."""
    began = time.monotonic()
    code = main(["doctor", "--json", *options])
    assert time.monotonic() - began < LIMIT_SECONDS
    content = json.loads(capsys.readouterr().out)
    result = {finding["check"]: finding for finding in content["findings"]}
    assert code == int(any(finding["state"] == "wrong" for finding in result.values()))
    assert content["healthy"] is (code == 0)
    assert all(finding["advice"] for finding in result.values() if finding["state"] != "ok")
    return code, result


def wrong(result: Findings) -> dict[str, str]:
    """List what was seen of all that is wrong, by check."""
    return {check: finding["seen"] for check, finding in result.items() if finding["state"] == "wrong"}


def free_port() -> int:
    """A port that nobody listens at."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return int(listening.getsockname()[1])
