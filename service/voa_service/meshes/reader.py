"""Hands a mesh file to the worker process and checks what comes back."""

import io
import os
import signal
import subprocess
import sys
from dataclasses import dataclass, field

import numpy as np
import structlog
from numpy.typing import NDArray

from voa_core.errors import InvalidInput
from voa_core.objects import Object
from voa_meshes.parsing import MESH_TYPES
from voa_meshes.units import unit_hint
from voa_msgs.objects import UpAxis
from voa_service.failures import Failure, InvalidMesh, NotReady, Overloaded, TooLarge, UnsupportedMeshType
from voa_service.meshes.children import Children
from voa_service.meshes.worker import OUT_OF_MEMORY, TOO_MANY_FACES
from voa_service.runtime.memory import MESH_NEEDS_MEBIBYTES

SMALLEST_M, LARGEST_M = 1e-3, 10.0
FARTHEST_M = 1_000.0
"""From the file's origin: beyond it coordinates lose what the mathematics promises, and 32 bits of a file lose all."""
_FEWEST_FACES = 4
_PASSED_ON = ("LANG", "LC_", "LD_LIBRARY_PATH", "OPENBLAS_", "PATH", "PYTHON", "SYSTEMROOT")


@dataclass(frozen=True)
class SubprocessMeshReader:
    """A `ports.MeshReader`.

    Attributes:
        seconds: time to read one file.
        mebibytes: address space of the process that reads it.
        faces: the most faces of a mesh.
        needs_mebibytes: address space that a mesh within the limits may need; where `mebibytes` is less, a mesh that
            exceeds it is not the caller's fault.
    """

    seconds: int
    mebibytes: int
    faces: int
    needs_mebibytes: int = MESH_NEEDS_MEBIBYTES
    _running: Children = field(default_factory=Children)

    def close(self) -> None:
        """End the processes that read: the service is ending."""
        self._running.close()

    def __call__(self, content: bytes, mesh_type: str, scale: float, up: UpAxis) -> Object:
        """Read a file; +Y up is turned to z up.

        Raises:
            Failure: another type, a file that is not that type or not usable, or too many faces; or, not the
                caller's fault, too little memory here.
        """
        if mesh_type not in MESH_TYPES:
            raise UnsupportedMeshType(f"expected a file named *.{', *.'.join(MESH_TYPES)}, got *.{mesh_type}")
        if not content:
            raise InvalidMesh("expected a mesh, got an empty file")
        vertices, faces = self._parse(content, mesh_type)
        _check_count(len(faces))
        try:
            object_ = Object.from_arrays(turned_up(vertices, up), faces, scale)
        except InvalidInput as error:
            raise InvalidMesh(str(error)) from error
        _check_count(len(object_.faces))
        _check_place(object_, scale)
        return object_

    def _parse(self, content: bytes, mesh_type: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        command = [sys.executable, "-B", "-m", "voa_service.meshes.worker", mesh_type]
        command += [str(self.mebibytes), str(self.seconds), str(self.faces)]
        try:
            done = self._running.run(command, content, self.seconds, environment())
        except subprocess.TimeoutExpired as error:
            raise self._took_too_long() from error
        except (MemoryError, OSError) as error:
            raise _out_of_memory(f"no process for it: {error}") from error
        if self._running.closed:
            raise NotReady("the service is ending: ask again", {"Retry-After": "2"})
        if done.returncode != 0:
            raise self._failure(done, mesh_type)
        with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
            return arrays["vertices"], arrays["faces"]

    def _failure(self, done: "subprocess.CompletedProcess[bytes]", mesh_type: str) -> Failure:
        """Why the process ended without a mesh: the file's fault, or want of memory here."""
        if done.returncode == TOO_MANY_FACES:
            found = int(done.stdout)
            return TooLarge(f"expected at most {self.faces} faces, got {found}: simplify the mesh")
        if done.returncode == -signal.SIGXCPU:
            return self._took_too_long()
        if done.returncode == -signal.SIGKILL:
            return _out_of_memory("the kernel ended the process that read it")
        said = done.stderr.decode(errors="replace").strip().splitlines()
        if done.returncode == OUT_OF_MEMORY or done.returncode < 0 or any("MemoryError" in line for line in said):
            if self.mebibytes < self.needs_mebibytes:
                return _out_of_memory(f"{self.mebibytes} MiB were too little for it")
            return InvalidMesh(f"reading it takes more than {self.mebibytes} MiB: simplify it")
        why = said[-1][:300] if said else f"its reader ended with {done.returncode}"
        return InvalidMesh(f"cannot read the {mesh_type.upper()} file: {why}")

    def _took_too_long(self) -> Failure:
        return InvalidMesh(f"reading the mesh took more than {self.seconds} s: simplify it")


def _out_of_memory(what: str) -> Failure:
    """A mesh that could not be read for want of memory here, which is not its fault."""
    structlog.get_logger().error("a mesh was not read for want of memory", reason=what)
    detail = f"the service has too little memory for this mesh at the moment ({what}): try again"
    return Overloaded(detail, {"Retry-After": "5"})


def environment() -> dict[str, str]:
    """Pick the part of the environment that the process of untrusted bytes may know: how to run, and no secret."""
    return {name: value for name, value in os.environ.items() if name.startswith(_PASSED_ON)}


def turned_up(vertices: NDArray[np.float64], up: UpAxis) -> NDArray[np.float64]:
    """Vertices (v, 3) with the axis that is up in the file turned to z."""
    return vertices if up == "+Z" else vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]


def _check_count(faces: int) -> None:
    """Refuse what has too few faces to be a body."""
    if faces < _FEWEST_FACES:
        raise InvalidMesh(f"expected at least {_FEWEST_FACES} faces, got {faces}: is it cut off?")


def _check_place(object_: Object, scale: float) -> None:
    """Refuse an object of a size, or at a place, that no arm can have."""
    size = float(object_.extents.max())
    if not SMALLEST_M <= size <= LARGEST_M:
        expected = f"expected an object of {SMALLEST_M:g} to {LARGEST_M:g} m, got one of {size:g} m"
        raise InvalidMesh(f"{expected}: {unit_hint(size, scale)}")
    farthest = float(np.abs(object_.vertices).max())
    if farthest > FARTHEST_M:
        raise InvalidMesh(
            f"expected a mesh within {FARTHEST_M:g} m of its file's origin, got one at {farthest:g} m: "
            "move it to the origin (map coordinates do this)",
        )
