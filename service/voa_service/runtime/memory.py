"""How much memory the service has, and what it gives to its parts so that the sum fits.

The sum is of upper bounds, reached only when everything is full at once: the cache, every worker in its largest block
of weights, every mesh being read at its limit, and bodies in flight.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from voa_msgs.problems import Memory
from voa_service.settings import MEBIBYTE, Settings

Source = Literal["setting", "cgroup", "machine"]

PROCESS_MEBIBYTES = 288
"""The process itself, after its first ranking: interpreter, libraries, compiled kernels, the pages of its threads."""
WORKER_MEBIBYTES = 96
"""One worker in a ranking: a block of weights (16 MiB, or 32 MiB of a matrix that is kept) and what makes it."""
MESH_NEEDS_MEBIBYTES = 320
"""Address space that a mesh within the limits never exceeds (measured: 240 MiB for 200 000 faces, 20 MB)."""
_MOST_CACHE, _MOST_MESH, _MOST_BODIES = 2_048, 2_048, 4_096
_LEAST_CACHE, _LEAST_BODIES = 32, 64
_MOST_MESHES = 2
_USABLE = 0.92  # the rest: what allocators hold on to, and the page tables
_UNLIMITED = 2**60
"""From which on a cgroup of version 1 means that there is no limit."""


@dataclass(frozen=True)
class Found:
    """Memory that the service may use.

    Attributes:
        mebibytes: how much.
        source: who says so.
    """

    mebibytes: int
    source: Source


@dataclass(frozen=True)
class MemoryBudget:
    """Memory that each part of the service may hold, in MiB.

    Attributes:
        found: what there is.
        cache: cuts, predictions and weights that are kept.
        workers: threads for rankings, WORKER_MEBIBYTES each.
        meshes: mesh files that are read at a time.
        mesh: address space of the process that reads one.
        bodies: requests that are received, parsed and validated, all together.
    """

    found: Found
    cache: int
    workers: int
    meshes: int
    mesh: int
    bodies: int

    @property
    def sum_mebibytes(self) -> int:
        """Everything at once."""
        parts = self.cache + self.workers * WORKER_MEBIBYTES + self.meshes * self.mesh + self.bodies
        return PROCESS_MEBIBYTES + parts

    def message(self) -> Memory:
        """State the budget as data, for `/readyz` and `voa doctor`."""
        return Memory(
            total_mebibytes=self.found.mebibytes,
            source=self.found.source,
            sum_mebibytes=self.sum_mebibytes,
            process_mebibytes=PROCESS_MEBIBYTES,
            cache_mebibytes=self.cache,
            workers_mebibytes=self.workers * WORKER_MEBIBYTES,
            meshes_mebibytes=self.meshes * self.mesh,
            bodies_mebibytes=self.bodies,
        )


def budget(settings: Settings, found: Found, processors: int) -> MemoryBudget:
    """Divide the memory among the parts; what the settings say explicitly holds, whatever the sum.

    Of what the process itself leaves: a quarter for bodies, the least that a mesh needs (more, and a second mesh at a
    time, where there is plenty), a quarter for workers, the rest for the cache.
    """
    left = max(0, int(_USABLE * found.mebibytes) - PROCESS_MEBIBYTES)
    bodies = _within(left // 4, _LEAST_BODIES, _MOST_BODIES)
    mesh = settings.mesh_mebibytes or _within(left // 4, MESH_NEEDS_MEBIBYTES, _MOST_MESH)
    meshes = _within(left // 4 // mesh, 1, _MOST_MESHES)
    workers = settings.workers or _within(left // 4 // WORKER_MEBIBYTES, 1, processors)
    rest = left - bodies - meshes * mesh - workers * WORKER_MEBIBYTES
    cache = settings.cache_mebibytes or _within(rest, _LEAST_CACHE, _MOST_CACHE)
    return MemoryBudget(found, cache, workers, meshes, mesh, bodies)


def find(settings: Settings, root: Path = Path("/")) -> Found:
    """Find the memory that the service may use: the setting, else the least of cgroup and machine.

    Args:
        settings: of which `memory_mebibytes` wins.
        root: where `proc` and `sys` are.
    """
    if settings.memory_mebibytes is not None:
        return Found(settings.memory_mebibytes, "setting")
    machine = _machine(root)
    group = _cgroup(root)
    if group is not None and group < machine:
        return Found(max(1, group // MEBIBYTE), "cgroup")
    return Found(max(1, machine // MEBIBYTE), "machine")


def processors() -> int:
    """Count the processors that this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _within(value: int, least: int, most: int) -> int:
    return max(least, min(value, most))


def _machine(root: Path) -> int:
    """Bytes of memory of the machine."""
    try:
        for line in (root / "proc/meminfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("MemTotal:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _cgroup(root: Path) -> int | None:
    """The least limit, in bytes, of this process's cgroup and those above it; None: there is none."""
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
    """The limits of a group and those above it, as far as this process sees them.

    In a container the mount is the group's own, whatever its path on the host is.
    """
    own = mount / path.lstrip("/")
    folders = [folder for folder in (own, *own.parents) if folder.is_relative_to(mount)]
    found = []
    for folder in folders:
        try:
            value = int((folder / name).read_text(encoding="ascii"))
        except (OSError, ValueError):  # not there, or "max"
            continue
        if value < _UNLIMITED:
            found.append(value)
    return found
