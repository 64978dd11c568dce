"""The worker process: does tasks, refuses broken files, and ends with all that it started."""

import asyncio
import os
import signal
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from tests.support.loops import run
from tests.support.meshes import box, written
from tests.support.waiting import wait_for
from voa_console.new_object.draft import Draft
from voa_console.new_object.messages import Reply, Task
from voa_console.new_object.process import TaskFailed, WorkerProcess
from voa_setup.previews.messages import MeshMeasure

NOBODY = "http://127.0.0.1:9"


def task(mesh: Path, step: str = "measure") -> Task:
    return Task(step=step, draft=Draft(mesh=str(mesh)), folder=str(mesh.parent))  # type: ignore[arg-type] # a parameter of the test


def with_process(folder: Path, use: Callable[[WorkerProcess], Awaitable[None]], key: str | None = None) -> None:
    """Use a process whose service nobody serves; it is gone afterwards."""

    async def whole() -> None:
        process = await WorkerProcess.start(NOBODY, folder / "log", key)
        try:
            await use(process)
        finally:
            process.kill()
            await process._process.wait()

    run(whole())


def silent(_: Reply) -> None:
    """Receive a reply, and do nothing."""


def test_a_mesh_is_measured_and_a_broken_file_is_refused_in_one_process(tmp_path: Path) -> None:
    mesh = written(box(100.0, 40.0, 25.0), tmp_path / "part.stl")
    (tmp_path / "broken.stl").write_bytes(b"no mesh")
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")

    async def use(process: WorkerProcess) -> None:
        measure = MeshMeasure.model_validate_json(await process.do(task(mesh), 60.0, silent))
        assert measure.extents == pytest.approx((100.0, 40.0, 25.0))
        assert measure.scales[0] == 0.001
        with pytest.raises(TaskFailed, match=r"broken\.stl"):
            await process.do(task(tmp_path / "broken.stl"), 60.0, silent)
        with pytest.raises(TaskFailed, match="is flat"):
            await process.do(task(tmp_path / "flat.obj", "rests"), 60.0, silent)
        small = Task(step="rests", draft=Draft(mesh=str(mesh), scale=0.001), folder=str(tmp_path))
        with pytest.raises(TaskFailed, match="The service does not respond"):
            await process.do(small, 60.0, silent)
        assert process.is_running

    with_process(tmp_path, use)


def test_a_task_that_takes_too_long_ends_the_process(tmp_path: Path) -> None:
    mesh = written(box(0.1, 0.04, 0.025), tmp_path / "part.stl")

    async def use(process: WorkerProcess) -> None:
        with pytest.raises(TaskFailed, match=r"took more than 0\.01 s"):
            await process.do(task(mesh), 0.01, silent)
        await process._process.wait()
        with pytest.raises(TaskFailed, match="has ended"):
            await process.do(task(mesh), 60.0, silent)

    with_process(tmp_path, use)


def test_the_process_ends_with_its_parent(tmp_path: Path) -> None:
    async def use(process: WorkerProcess) -> None:
        stdin = process._process.stdin
        assert stdin is not None
        stdin.close()
        assert await asyncio.wait_for(process._process.wait(), 60.0) == -signal.SIGKILL

    with_process(tmp_path, use)


def test_of_the_secrets_of_the_console_only_the_key_for_the_service_reaches_the_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VOA_KEY", "for the service")
    monkeypatch.setenv("VOA_DATABASE_URL", "secret")
    monkeypatch.setenv("VOA_ZENOH__PASSWORD", "secret")

    async def use(process: WorkerProcess) -> None:
        file = Path(f"/proc/{process._process.pid}/environ")
        content = await asyncio.to_thread(wait_for, file.read_bytes, "an environment")
        assert b"PATH=" in content
        assert b"secret" not in content
        assert b"VOA_KEY=for the service" in content
        assert os.getpgid(process._process.pid) == process._process.pid

    with_process(tmp_path, use)


def test_the_key_of_a_browser_takes_the_place_of_the_console_s_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VOA_KEY_FILE", "of the console")

    async def use(process: WorkerProcess) -> None:
        content = await asyncio.to_thread(
            wait_for, Path(f"/proc/{process._process.pid}/environ").read_bytes, "an environment"
        )
        assert b"VOA_KEY=of a browser" in content
        assert b"of the console" not in content
        command = await asyncio.to_thread(Path(f"/proc/{process._process.pid}/cmdline").read_bytes)
        assert b"of a browser" not in command

    with_process(tmp_path, use, "of a browser")


@pytest.mark.parametrize("part", ["mujoco", "trimesh"])
def test_a_console_without_the_extra_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    (tmp_path / "absent").mkdir()
    (tmp_path / "absent" / f"{part}.py").write_text(f"raise ImportError('No module named {part}')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "absent"))
    mesh = written(box(0.1, 0.04, 0.025), tmp_path / "part.stl")

    async def use(process: WorkerProcess) -> None:
        with pytest.raises(TaskFailed, match=rf"needs the extra setup \(No module named {part}\)\. Install it: pip"):
            await process.do(task(mesh), 60.0, silent)

    with_process(tmp_path, use)
