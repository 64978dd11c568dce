"""Untrusted meshes are read in a process with limits; what happens there stays there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.serving import box_obj
from voa_service.failures import Failure
from voa_service.meshes.reader import SubprocessMeshReader, environment

BOX = box_obj().encode()


def reader(seconds: int = 30, mebibytes: int = 1024, faces: int = 1000) -> SubprocessMeshReader:
    return SubprocessMeshReader(seconds, mebibytes, faces)


def test_a_mesh_is_read_and_scaled() -> None:
    found = reader()(BOX, "obj", 2.0, "+Z")
    assert len(found.faces) == 12
    assert found.extents == pytest.approx([0.08, 0.12, 0.10])
    assert found.watertight


def test_faces_are_limited() -> None:
    assert len(reader(faces=12)(BOX, "obj", 1.0, "+Z").faces) == 12
    with pytest.raises(Failure, match="at most 11 faces, got 12") as refused:
        reader(faces=11)(BOX, "obj", 1.0, "+Z")
    assert refused.value.status == 413


def test_memory_is_limited() -> None:
    with pytest.raises(Failure) as refused:
        reader(mebibytes=16)(BOX, "obj", 1.0, "+Z")
    assert refused.value.kind == "invalid-mesh"


def test_time_is_limited(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    # A mesh type that is read for ever: an interpreter that waits on a pipe that nobody writes to.
    sleeper = tmp_path / "python"
    sleeper.write_text(f"#!{sys.executable}\nimport signal\nsignal.pause()\n")
    sleeper.chmod(0o700)
    monkeypatch.setattr(sys, "executable", str(sleeper))
    with pytest.raises(Failure, match="more than 1 s") as refused:
        reader(seconds=1)(BOX, "obj", 1.0, "+Z")
    assert (refused.value.kind, refused.value.status) == ("invalid-mesh", 422)


@pytest.mark.parametrize("mesh_type", ["", "zip", "off", "dae", "exe", "../obj"])
def test_other_types_never_reach_the_process(monkeypatch: pytest.MonkeyPatch, mesh_type: str) -> None:
    monkeypatch.setattr(sys, "executable", "/nonexistent")
    with pytest.raises(Failure) as refused:
        reader()(BOX, mesh_type, 1.0, "+Z")
    assert refused.value.status == 415


def test_the_process_can_write_no_file(tmp_path: Path) -> None:
    program = (
        "import io, sys\n"
        "from voa_service.meshes.worker import main\n"
        "main('obj', 2048, 30)\n"
        "try:\n"
        "    io.open('left.txt', 'w', buffering=1).write('behind\\n')\n"
        "except OSError as error:\n"
        "    sys.exit(f'refused: {error.strerror}')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], input=BOX, capture_output=True, env=os.environ, check=False, cwd=tmp_path
    )
    assert done.stdout  # the mesh was read
    assert b"refused: File too large" in done.stderr


def test_the_process_that_reads_knows_no_secret(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VOA_DATABASE_URL", "postgresql://user:secret@host/voa")
    monkeypatch.setenv("PYTHONPATH", "somewhere")
    told = environment()
    assert "secret" not in "".join(told.values())
    assert told["PYTHONPATH"] == "somewhere"
    assert "PATH" in told
