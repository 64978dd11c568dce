"""Memory of the service, divided among its parts so that the sum of their bounds fits.

The bounds are reached together only when everything is full at once: the cache, every worker at its largest block of
weights, every mesh file at its limit, and the bodies of requests.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from voa_connections.settings import MEBIBYTE
from voa_msgs.problems import Memory
from voa_service.settings import Settings

Source = Literal["setting", "cgroup", "machine"]

PROCESS_MEBIBYTES = 288
"""Memory of the process after its first ranking: interpreter, libraries, compiled kernels, the pages of its threads."""
WORKER_MEBIBYTES = 96
"""Memory of a worker in a ranking: a block of weights (16 MiB, or 32 MiB of a kept matrix) and what computes it."""
MESH_NEEDS_MEBIBYTES = 320
"""Address space that a mesh within the limits never exceeds (measured: 240 MiB for 200 000 faces, 20 MB)."""
_MOST_CACHE, _MOST_MESH, _MOST_BODIES = 2_048, 2_048, 4_096
_LEAST_CACHE, _LEAST_BODIES = 32, 64
_MOST_MESHES = 2
_USABLE = 0.92  # the rest is for memory that allocators keep, and for page tables
_UNLIMITED = 2**60
"""Bytes from which on the limit of a cgroup of version 1 means that there is none."""


@dataclass(frozen=True)
class AvailableMemory:
    """Memory that the service may use.

    Attributes:
        mebibytes: its size.
        source: of the figure: a setting, the limit of the cgroup, or the memory of the machine.
    """

    mebibytes: int
    source: Source


@dataclass(frozen=True)
class MemoryBudget:
    """Memory that each part of the service may hold, in MiB.

    Attributes:
        available: memory that the service may use.
        cache: for cuts, predictions and weights that are kept.
        workers: number of threads for rankings, of WORKER_MEBIBYTES each.
        meshes: number of mesh files that are read at a time.
        mesh: address space of the process that reads a mesh file.
        bodies: for the bodies of all requests that are received, parsed and validated.
    """

    available: AvailableMemory
    cache: int
    workers: int
    meshes: int
    mesh: int
    bodies: int

    @property
    def sum_mebibytes(self) -> int:
        """Sum of the bounds of all parts, in MiB."""
        parts = self.cache + self.workers * WORKER_MEBIBYTES + self.meshes * self.mesh + self.bodies
        return PROCESS_MEBIBYTES + parts

    def message(self) -> Memory:
        """State the budget as data, for `/readyz` and `voa doctor`."""
        return Memory(
            total_mebibytes=self.available.mebibytes,
            source=self.available.source,
            sum_mebibytes=self.sum_mebibytes,
            process_mebibytes=PROCESS_MEBIBYTES,
            cache_mebibytes=self.cache,
            workers_mebibytes=self.workers * WORKER_MEBIBYTES,
            meshes_mebibytes=self.meshes * self.mesh,
            bodies_mebibytes=self.bodies,
        )


def budget(settings: Settings, available: AvailableMemory, processors: int) -> MemoryBudget:
    """Divide the available memory among the parts of the service; explicit settings win, whatever the sum.

    Of the memory that the process itself leaves, a quarter is for bodies, a quarter for workers, and the rest for the
    cache, after the least that a mesh file needs, or up to a quarter for two larger ones where there is plenty.
    """
    left = max(0, int(_USABLE * available.mebibytes) - PROCESS_MEBIBYTES)
    bodies = _within(left // 4, _LEAST_BODIES, _MOST_BODIES)
    mesh = settings.mesh_mebibytes or _within(left // 4, MESH_NEEDS_MEBIBYTES, _MOST_MESH)
    meshes = _within(left // 4 // mesh, 1, _MOST_MESHES)
    workers = settings.workers or _within(left // 4 // WORKER_MEBIBYTES, 1, processors)
    rest = left - bodies - meshes * mesh - workers * WORKER_MEBIBYTES
    cache = settings.cache_mebibytes or _within(rest, _LEAST_CACHE, _MOST_CACHE)
    return MemoryBudget(available, cache, workers, meshes, mesh, bodies)


def available_memory(settings: Settings, root: Path = Path("/")) -> AvailableMemory:
    """Find the memory that the service may use: the setting, else the smaller of the cgroup's limit and the machine's.

    Args:
        settings: its `memory_mebibytes` wins where it is set.
        root: folder that holds `proc` and `sys`.
    """
    if settings.memory_mebibytes is not None:
        return AvailableMemory(settings.memory_mebibytes, "setting")
    machine = _machine(root)
    group = _cgroup(root)
    if group is not None and group < machine:
        return AvailableMemory(max(1, group // MEBIBYTE), "cgroup")
    return AvailableMemory(max(1, machine // MEBIBYTE), "machine")


def processors() -> int:
    """Count the processors that this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _within(value: int, least: int, most: int) -> int:
    return max(least, min(value, most))


def _machine(root: Path) -> int:
    """Return the memory of the machine, in bytes."""
    try:
        for line in (root / "proc/meminfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("MemTotal:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _cgroup(root: Path) -> int | None:
    """Return the smallest limit, in bytes, of this process's cgroup and its ancestors; None where none has a limit."""
    try:
        lines = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:
        return None
    limits = []
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            limits += _limits(root / "sys/fs/cgroup", path, "memory.max")
        elif "memory" in controllers.split(","):
            limits += _limits(root / "sys/fs/cgroup/memory", path, "memory.limit_in_bytes")
    return min(limits, default=None)


def _limits(mount: Path, path: str, name: str) -> list[int]:
    """List the limits, in bytes, of a cgroup and its ancestors, as far as this process can see them.

    In a container the mount point is the cgroup itself, whatever its path on the host.
    """
    own = mount / path.lstrip("/")
    folders = [folder for folder in (own, *own.parents) if folder.is_relative_to(mount)]
    limits = []
    for folder in folders:
        try:
            value = int((folder / name).read_text(encoding="ascii"))
        except (OSError, ValueError):  # not there, or "max"
            continue
        if value < _UNLIMITED:
            limits.append(value)
    return limits
