"""The process `python -m voa_service.local`: its lines, its exit status, and signals."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.support.waiting import wait_for
from tests.voa_service.local.documents import data_document, mesh_document
from voa_msgs.problems import Problem
from voa_msgs.rankings import Ranking

COMMAND = [sys.executable, "-m", "voa_service.local"]


def run(document: bytes, options: Sequence[str] = (), **environment: str) -> tuple[int, list[Any]]:
    """Run the process on a document; returns its exit status and its lines."""
    command = [*COMMAND, *options]
    ended = subprocess.run(command, input=document, stdout=subprocess.PIPE, env=os.environ | environment, check=False)
    return ended.returncode, [json.loads(line) for line in ended.stdout.splitlines()]


def test_progress_comes_first_and_the_result_last() -> None:
    status, lines = run(data_document({"belief": None, "lookahead": 1}))
    assert status == 0
    assert lines[:-1] == [{"progress": {"done": done, "total": 2}} for done in (1, 2)]
    result = lines[-1]["result"]
    assert len(Ranking.model_validate(result["ranking"]).ranking) == 2
    assert [warning["kind"] for warning in result["warnings"]] == ["no-workspace"]


def test_a_mistake_is_a_problem_document() -> None:
    status, [line] = run(data_document({"belief": [1.0]}))
    assert status == 1
    problem = Problem.model_validate(line["problem"])
    assert (problem.type, problem.status) == ("urn:voa:problem:invalid-request", 422)


def test_a_wrong_setting_ends_it_with_2() -> None:
    assert run(b"", VOA_PRECISION="float16") == (2, [])


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_in_order(tmp_path: Path, sent: signal.Signals) -> None:
    # Enough work for minutes, so that the signal comes in the midst of it; the parts end it at their next check.
    document = mesh_document(tmp_path, {"belief": None, "scans": "simulated", "samples": 512}, sensors=places(2_000))
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    with subprocess.Popen(
        COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=os.environ | {"TMPDIR": str(temporary)}
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(document)
        process.stdin.close()
        assert b"progress" in process.stdout.readline()
        assert list(temporary.iterdir()) != []
        process.send_signal(sent)
        lines = process.stdout.readlines()
        assert process.wait() == 130
    assert all(b"progress" in line for line in lines)
    assert list(temporary.iterdir()) == [], "the temporary database is removed"


def test_what_a_killed_process_has_finished_on_a_cluster_is_not_computed_again(tmp_path: Path) -> None:
    document = mesh_document(tmp_path, {"belief": None, "scans": "simulated", "samples": 64}, sensors=places(100))
    command = [*COMMAND, "--cluster", "local:2", "--resume", str(tmp_path / "parts")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(document)
        process.stdin.close()
        while json.loads(process.stdout.readline())["progress"]["done"] < 10:
            pass
        workers = descendants(process.pid)
        process.kill()
    wait_for(lambda: not any(Path(f"/proc/{worker}").exists() for worker in workers), "the end of the workers", 60.0)
    kept = {file: file.stat().st_mtime_ns for file in (tmp_path / "parts").rglob("*.pickle")}
    assert 10 <= len(kept) < 100
    status, lines = run(document, options=command[3:])
    assert status == 0
    assert [line["progress"]["done"] for line in lines[:-1]] == list(range(1, 101))
    assert {file: file.stat().st_mtime_ns for file in kept} == kept
    assert lines[-1] == run(document)[1][-1], "the result is that of one process"


def places(count: int) -> list[dict[str, Any]]:
    return [{"name": f"Q{i}", "x": 0.3, "y": 1e-4 * i, "yaw_rad": 3.1} for i in range(count)]


def descendants(process: int) -> set[int]:
    """Ids of the processes that a process has started, and of those that they have."""
    parents = {
        int(folder.name): int((folder / "stat").read_text().rpartition(")")[2].split()[1])
        for folder in Path("/proc").iterdir()
        if folder.name.isdecimal() and (folder / "stat").is_file()
    }
    below = {child for child, parent in parents.items() if parent == process}
    return below.union(*(descendants(child) for child in below))
