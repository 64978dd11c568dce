"""Bench: its process ends when it has nothing to do, and starts again when it has."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.loops import run
from voa_console.new_object.bench import Bench
from voa_console.new_object.messages import Reply, Task
from voa_console.new_object.process import WorkerProcess
from voa_setup.previews.messages import MeshMeasure

MEASURE = MeshMeasure(name="part", faces=12, extents=(1.0, 1.0, 1.0), up="+Z", scales=[1.0])


class Process:
    """Process that measures at once, and notes its end."""

    def __init__(self) -> None:
        self.ended = asyncio.Event()

    @property
    def is_running(self) -> bool:
        return not self.ended.is_set()

    async def do(self, task: Task, seconds: float | None, report: Callable[[Reply], None]) -> str:
        assert (task.step, seconds is not None) == ("measure", True)
        report(Reply(text="measuring"))
        return MEASURE.model_dump_json()

    def kill(self) -> None:
        self.ended.set()


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Process, str | None]]:
    """Processes that benches have started, with their keys."""
    processes: list[tuple[Process, str | None]] = []

    async def start(url: str, log: Path, key: str | None) -> Process:
        processes.append((Process(), key))
        return processes[-1][0]

    monkeypatch.setattr(WorkerProcess, "start", start)
    return processes


def test_a_process_that_has_nothing_to_do_ends_and_is_started_again(
    started: list[tuple[Process, str | None]], tmp_path: Path
) -> None:
    async def whole() -> None:
        bench = Bench("0a", "http://service", tmp_path, key="of a browser", idle_s=0.0)
        for number in range(2):
            await bench.take(tmp_path / "part.stl")
            await asyncio.wait_for(started[number][0].ended.wait(), 30.0)
            assert bench.draft is not None, "the choices stay"
        await bench.close()

    run(whole())
    assert [key for _, key in started] == ["of a browser"] * 2


def test_a_process_stays_while_it_is_used(started: list[tuple[Process, str | None]], tmp_path: Path) -> None:
    async def whole() -> None:
        bench = Bench("0a", "http://service", tmp_path, idle_s=60.0)
        for _ in range(2):
            await bench.take(tmp_path / "part.stl")
        ((process, key),) = started
        assert (process.is_running, key) == (True, None)
        await bench.close()
        assert not process.is_running

    run(whole())
