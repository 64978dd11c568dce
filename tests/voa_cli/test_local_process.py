"""`voa rank --local`: the ranking of a service, without one."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.serving import box_obj, data_scenario, mesh_scenario
from tests.voa_cli.rankings import ranked
from voa_cli import local_process
from voa_cli.local_process import LocalRankingFailed, rank_locally
from voa_cli.main import main
from voa_msgs.rankings import VoaRequest
from voa_msgs.scenarios import ScenarioRequest


@pytest.fixture
def mesh_file(tmp_path: Path) -> Path:
    (tmp_path / "box.obj").write_text(box_obj(40.0, 60.0, 50.0), encoding="utf-8")
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(mesh_scenario("box.obj", scale=0.001)), encoding="utf-8")
    return path


def test_the_ranking_is_that_of_a_service(capfd: pytest.CaptureFixture[str], process: str, mesh_file: Path) -> None:
    options = ["--belief", "0.4,0.6", "--from", "E", "--cost-per-m", "0.1", "--sensor-std", "0.01,1", "--samples", "4"]
    of_service = ranked(capfd, str(mesh_file), "--url", process, *options)
    assert of_service["scans"] == "simulated"
    assert ranked(capfd, str(mesh_file.parent), "--local", *options) == of_service
    on_cluster = ["--cluster", "local:1", "--resume", str(mesh_file.parent / "parts")]
    assert ranked(capfd, str(mesh_file), *on_cluster, *options) == of_service
    assert list((mesh_file.parent / "parts").rglob("*.pickle")) != []


def test_without_a_mesh_it_prints_the_table_and_warnings(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(data_scenario(min_gain=0.9)), encoding="utf-8")
    assert main(["rank", str(path), "--local"]) == 0
    out, err = capfd.readouterr()
    assert "no look's net value is more than min_gain 0.9" in " ".join(out.split())
    assert "there is no workspace" in " ".join(err.split())


def test_progress_is_reported_as_parts_are_finished() -> None:
    scenario, reports = ScenarioRequest.model_validate(data_scenario()), list[tuple[int, int]]()
    request = VoaRequest(lookahead=1)
    ranking, _ = rank_locally(scenario, None, None, request, lambda done, total: reports.append((done, total)))
    assert len(ranking.ranking) == 2
    assert reports == [(1, 2), (2, 2)]


def test_a_mistake_is_one_line(capfd: pytest.CaptureFixture[str], mesh_file: Path) -> None:
    assert main(["rank", str(mesh_file), "--local", "--grasps", "G9"]) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("voa rank: Unknown name in the request: ")
    assert "G9" in line
    assert main(["rank", str(mesh_file), "--cluster", "local:none"]) == 1
    assert "expected local:N with a number of processes, got 'local:none'" in capfd.readouterr().err


def test_a_process_that_ends_early_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = ScenarioRequest.model_validate(data_scenario())
    monkeypatch.setattr(local_process, "_MODULE", "voa_service.no_such_module")
    with pytest.raises(LocalRankingFailed, match="ended early, with status 1"):
        rank_locally(scenario, None, None, VoaRequest(), lambda done, total: None)


def test_without_the_service_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(local_process, "find_spec", lambda name: None)
    scenario = ScenarioRequest.model_validate(data_scenario())
    with pytest.raises(LocalRankingFailed, match=r"pip install .*\[service\]"):
        rank_locally(scenario, None, None, VoaRequest(), lambda done, total: None)


def test_an_interrupt_ends_the_process_that_ranks(tmp_path: Path, mesh_file: Path) -> None:
    places = [{"name": f"Q{i}", "x": 0.3, "y": 1e-4 * i, "yaw_rad": 3.1} for i in range(2_000)]
    mesh_file.write_text(json.dumps(mesh_scenario("box.obj", scale=0.001, sensors=places)), encoding="utf-8")
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    code = (
        "import signal, sys, voa_cli.local_process as p\n"
        "from voa_cli.rank import main\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)  # a process in the background ignores Ctrl-C\n"
        "original = p._last_line\n"
        "def printing(process, document, _):\n"
        "    return original(process, document, lambda done, total: print(process.pid, flush=True))\n"
        "p._last_line = printing\n"
        "main(sys.argv[1:])\n"
    )
    command = [sys.executable, "-c", code, str(mesh_file), "--local", "--scans", "simulated", "--samples", "512"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=os.environ | {"TMPDIR": str(temporary)}) as process:
        assert process.stdout is not None
        ranking_process = int(process.stdout.readline())
        process.send_signal(signal.SIGINT)  # as `kill` does: to this process alone, not to its group
        assert len(process.stdout.readlines()) < len(places) // 2, "the ranking goes on"
        assert process.wait() != 0
    with pytest.raises(ProcessLookupError):
        os.kill(ranking_process, 0)
    assert list(temporary.iterdir()) == []
