"""`make load` in its short form: it starts a service, plays robots, and reports."""

import json
import subprocess
import sys
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]


def test_a_few_sessions_are_carried_and_reported(tmp_path: Path) -> None:
    out = tmp_path / "load.json"
    command = [sys.executable, "-m", "tests.load", "--short", "--out", str(out)]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "one process on SQLite" in done.stdout
    report = json.loads(out.read_text())
    (step,) = report["services"]["one process on SQLite"]
    assert step["sessions"] == 4
    assert step["scans"] > 0
    assert step["refused"] == {}
    assert 0.0 < step["p50_ms"] <= step["p99_ms"]
    assert 0.0 < step["cpu_ms_per_scan"] < 1e3
    assert step["cpu_s"]["robots"] > 0.0
