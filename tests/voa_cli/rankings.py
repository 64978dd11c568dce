"""Rankings by `voa rank --json`, for tests."""

import json
from pathlib import Path
from typing import Any

import pytest

from voa_cli.main import main


def ranked(capfd: pytest.CaptureFixture[str], *arguments: str) -> Any:
    """Run `voa rank --json`, and return the document."""
    assert main(["rank", *arguments, "--json"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    return json.loads(out)


def values(capfd: pytest.CaptureFixture[str], process: str, path: Path, *more: str) -> dict[str, float]:
    """Rank a scenario file, and return the VOA of each sensor configuration."""
    assert main(["rank", str(path), "--url", process, "--json", *more]) == 0
    return {look["sensor"]: look["voa"] for look in json.loads(capfd.readouterr().out)["ranking"]}
