"""Untrusted meshes are read in a process with limits; what happens there stays there."""

import json
import os
import struct
import subprocess
import sys
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.support.serving import box_obj
from tests.support.waiting import wait_for
from tests.voa_meshes.files import POINTS, Gltf
from voa_service.failures import Failure
from voa_service.meshes.reader import SubprocessMeshReader, environment

BOX = box_obj().encode()


def reader(seconds: int = 30, mebibytes: int = 1024, faces: int = 1000) -> SubprocessMeshReader:
    return SubprocessMeshReader(seconds, mebibytes, faces)


def test_a_mesh_is_read_and_scaled() -> None:
    mesh = reader()(BOX, "obj", 2.0, "+Z")
    assert len(mesh.faces) == 12
    assert mesh.extents == pytest.approx([0.08, 0.12, 0.10])
    assert mesh.watertight


def test_faces_are_limited() -> None:
    assert len(reader(faces=12)(BOX, "obj", 1.0, "+Z").faces) == 12
    with pytest.raises(Failure, match="at most 11 faces, got 12") as refused:
        reader(faces=11)(BOX, "obj", 1.0, "+Z")
    assert refused.value.status == 413


LONG_POLYGON = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + b" 1 2 3" * 700_000


def test_a_mesh_that_takes_more_than_any_usable_one_is_the_callers_fault() -> None:
    with pytest.raises(Failure, match="takes more than 400 MiB: simplify it") as refused:
        reader(mebibytes=400)(LONG_POLYGON, "obj", 1.0, "+Z")
    assert (refused.value.kind, refused.value.status) == ("invalid-mesh", 422)


@pytest.mark.parametrize(("mebibytes", "mesh"), [(16, BOX), (300, LONG_POLYGON)])
def test_a_mesh_that_fails_for_want_of_memory_here_is_not_the_callers_fault(mebibytes: int, mesh: bytes) -> None:
    with pytest.raises(Failure, match=f"{mebibytes} MiB of address space were too little") as refused:
        reader(mebibytes=mebibytes)(mesh, "obj", 1.0, "+Z")
    assert (refused.value.kind, refused.value.status) == ("overloaded", 503)
    assert int(refused.value.headers["Retry-After"]) >= 1


def interpreter(monkeypatch: pytest.MonkeyPatch, folder: Path, program: str) -> None:
    """Have meshes read by another program."""
    script = folder / "python"
    script.write_text(f"#!{sys.executable}\n{program}\n")
    script.chmod(0o700)
    monkeypatch.setattr(sys, "executable", str(script))


@pytest.mark.parametrize(("which", "status"), [("SIGKILL", 503), ("SIGXCPU", 422)])
def test_whoever_ended_the_process_decides_whose_fault_it_is(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, which: str, status: int
) -> None:
    interpreter(monkeypatch, tmp_path, f"import os, signal\nos.kill(os.getpid(), signal.{which})")
    with pytest.raises(Failure) as refused:
        reader()(BOX, "obj", 1.0, "+Z")
    assert refused.value.status == status


def test_the_kernel_would_end_the_process_before_the_service() -> None:
    program = (
        "from voa_service.meshes.worker import main\n"
        "main('obj', 2048, 30, 1000)\n"
        "import sys\n"
        "sys.exit(open('/proc/self/oom_score_adj').read())\n"
    )
    # Coverage in the process could not write its data there, and would say so.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE")}
    done = subprocess.run([sys.executable, "-c", program], input=BOX, capture_output=True, env=environment, check=False)
    assert done.stderr.split() == [b"1000"]


def test_a_service_that_ends_ends_the_processes_that_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    interpreter(monkeypatch, tmp_path, f"import signal\nopen({str(begun)!r}, 'w').close()\nsignal.pause()")
    own = reader()
    with ThreadPoolExecutor(1) as pool:
        call = pool.submit(own, BOX, "obj", 1.0, "+Z")
        wait_for(begun.exists, "the process")
        own.close()
        with pytest.raises(Failure) as refused:
            call.result(30)
    assert (refused.value.kind, refused.value.status) == ("not-ready", 503)
    with pytest.raises(Failure, match="stopping"):
        own(BOX, "obj", 1.0, "+Z")


def test_time_is_limited(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    # A mesh type that is read for ever: an interpreter that waits on a pipe that nobody writes to.
    interpreter(monkeypatch, tmp_path, "import signal\nsignal.pause()")
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
        "main('obj', 2048, 30, 1000)\n"
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
    variables = environment()
    assert "secret" not in "".join(variables.values())
    assert variables["PYTHONPATH"] == "somewhere"
    assert "PATH" in variables


def test_a_file_that_says_much_in_few_bytes_costs_its_reader_alone() -> None:
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"count": 3, "type": "VEC3", "componentType": 5126},
            {"count": 9_000_000, "type": "SCALAR", "componentType": 5125},
        ],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    file = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text
    tracemalloc.start()
    with pytest.raises(Failure, match="at most 1000 faces, got 3000000") as refused:
        reader()(file, "glb", 1.0, "+Z")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert refused.value.status == 413
    assert most < 2 * 2**20


@pytest.mark.parametrize("count", [2**31 + 1, 10**18])
def test_a_count_that_no_file_can_hold_is_refused_by_name(count: int) -> None:
    made = Gltf()
    made.mesh(made.triangles(POINTS))
    made.document["accessors"][0]["count"] = count
    del made.document["accessors"][0]["bufferView"]
    with pytest.raises(Failure, match=f"at most {2**31} elements, got {count}"):
        reader()(made.file(), "glb", 1.0, "+Z")


def test_an_index_of_thousands_of_digits_is_none() -> None:
    with pytest.raises(Failure, match="expected the vertices of a face"):
        reader()(BOX + b"f " + b"9" * 5000 + b" 1 2\n", "obj", 1.0, "+Z")


@pytest.mark.parametrize("elements", [20_000, 400_000])
def test_a_header_without_end_is_refused_at_once(elements: int) -> None:
    header = b"ply\nformat ascii 1.0\n" + b"".join(b"element e%d 0\n" % i for i in range(elements)) + b"end_header\n"
    with pytest.raises(Failure, match="a header of at most 10000 lines"):
        reader()(header, "ply", 1.0, "+Z")
