"""`make load` in its short form: it starts services, plays robots by HTTP and Zenoh, and reports."""

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
    report = json.loads(out.read_text())
    assert list(report["services"]) == ["one process on SQLite", "scans by Zenoh"]
    for name, (step,) in report["services"].items():
        assert name in done.stdout
        assert (step["sessions"], step["refused"]) == (4, {})
        assert step["scans"] > 0
        assert 0.0 < step["p50_ms"] <= step["p99_ms"]
        assert 0.0 < step["cpu_ms_per_scan"] < 1e3
        assert step["cpu_s"]["robots"] > 0.0
