"""Reads an untrusted mesh file in a worker process with limits, and checks the mesh that it returns."""

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
from voa_meshes import MESH_TYPES, UpAxis, turned_up, unit_hint
from voa_service.failures import Failure, InvalidMesh, NotReady, Overloaded, TooLarge, UnsupportedMeshType
from voa_service.meshes.children import Children
from voa_service.meshes.worker import OUT_OF_MEMORY, TOO_MANY_FACES
from voa_service.runtime.memory import MESH_NEEDS_MEBIBYTES

SMALLEST_M, LARGEST_M = 1e-3, 10.0
FARTHEST_M = 1_000.0
"""Largest distance of a vertex from the file's origin: beyond it, 32-bit coordinates are too coarse."""
_FEWEST_FACES = 4
_PASSED_ON = ("LANG", "LC_", "LD_LIBRARY_PATH", "OPENBLAS_", "PATH", "PYTHON", "SYSTEMROOT")


@dataclass(frozen=True)
class SubprocessMeshReader:
    """Implements `ports.MeshReader` by a process with limits for each file.

    Attributes:
        seconds: most time to read one file.
        mebibytes: address space of the process that reads it.
        faces: the most faces of a mesh.
        needs_mebibytes: address space that a mesh within the limits may need; where `mebibytes` is less, a mesh that
            exceeds it is answered as an overload, not as a mistake of the caller.
    """

    seconds: int
    mebibytes: int
    faces: int
    needs_mebibytes: int = MESH_NEEDS_MEBIBYTES
    _running: Children = field(default_factory=Children)

    def close(self) -> None:
        """End the worker processes, as the service stops."""
        self._running.close()

    def __call__(self, content: bytes, mesh_type: str, scale: float, up: UpAxis) -> Object:
        """Read a mesh file, scaled to metres and turned so that the axis `up` becomes z.

        Raises:
            Failure: the type is not supported, the file is not of that type or not usable, or it has too many faces; or
                the service has too little memory for it, or is stopping.
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
            raise _out_of_memory(f"no process could be started: {error}") from error
        if self._running.closed:
            raise NotReady("the service is stopping: try again", {"Retry-After": "2"})
        if done.returncode != 0:
            raise self._failure(done, mesh_type)
        with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
            return arrays["vertices"], arrays["faces"]

    def _failure(self, done: "subprocess.CompletedProcess[bytes]", mesh_type: str) -> Failure:
        """Explain why a worker process ended without a mesh: the file's fault, or too little memory here."""
        if done.returncode == TOO_MANY_FACES:
            count = int(done.stdout)
            return TooLarge(f"expected at most {self.faces} faces, got {count}: simplify the mesh")
        if done.returncode == -signal.SIGXCPU:
            return self._took_too_long()
        if done.returncode == -signal.SIGKILL:
            return _out_of_memory("the kernel ended the process that read it")
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        if done.returncode == OUT_OF_MEMORY or done.returncode < 0 or any("MemoryError" in line for line in lines):
            if self.mebibytes < self.needs_mebibytes:
                return _out_of_memory(f"{self.mebibytes} MiB of address space were too little")
            return InvalidMesh(f"reading it takes more than {self.mebibytes} MiB: simplify it")
        why = lines[-1][:300] if lines else f"its reader ended with {done.returncode}"
        return InvalidMesh(f"cannot read the {mesh_type.upper()} file: {why}")

    def _took_too_long(self) -> Failure:
        return InvalidMesh(f"reading the mesh took more than {self.seconds} s: simplify it")


def _out_of_memory(reason: str) -> Failure:
    """Make the failure of a mesh that the service has too little memory for, which is no mistake of the caller."""
    structlog.get_logger().error("a mesh was not read: too little memory", reason=reason)
    detail = f"the service has too little memory for this mesh at the moment ({reason}): try again"
    return Overloaded(detail, {"Retry-After": "5"})


def environment() -> dict[str, str]:
    """Select the environment variables of a worker process: those that it needs to run, and no secret."""
    return {name: value for name, value in os.environ.items() if name.startswith(_PASSED_ON)}


def _check_count(faces: int) -> None:
    """Refuse a mesh with too few faces to enclose a volume."""
    if faces < _FEWEST_FACES:
        raise InvalidMesh(f"expected at least {_FEWEST_FACES} faces, got {faces}: is it cut off?")


def _check_place(object_: Object, scale: float) -> None:
    """Refuse an object of a size that no arm grasps, or far from its file's origin."""
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
