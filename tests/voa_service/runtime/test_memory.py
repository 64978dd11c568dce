"""The memory that there is is found where the system says so, and the parts of the service fit into it."""

from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import serving
from voa_connections.settings import MEBIBYTE
from voa_service.runtime.memory import MESH_NEEDS_MEBIBYTES, AvailableMemory, MemoryBudget, available_memory, budget
from voa_service.settings import Settings


def machine(root: Path, cgroup: str | None = None, **limits: str) -> Path:
    """A root folder of a machine of 8 GiB, with the limits of cgroups by path."""
    (root / "proc/self").mkdir(parents=True)
    (root / "proc/meminfo").write_text(f"MemTotal: {8 * 1024 * 1024} kB\nMemFree: 12 kB\n")
    if cgroup is not None:
        (root / "proc/self/cgroup").write_text(cgroup)
    for path, limit in limits.items():
        file = root / "sys/fs/cgroup" / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(limit)
    return root


V1 = "5:memory:/lab/voa\n2:cpu,cpuacct:/elsewhere\n0::/\n"
V2 = "0::/lab/voa\n"
UNLIMITED = "9223372036854771712\n"


@pytest.mark.parametrize(
    ("cgroup", "limits", "expected"),
    [
        (None, {}, (8192, "machine")),
        (V2, {}, (8192, "machine")),
        (V2, {"lab/voa/memory.max": f"{2**30}\n", "lab/memory.max": "max\n"}, (1024, "cgroup")),
        (V2, {"lab/voa/memory.max": "max\n", "lab/memory.max": f"{2**29}\n"}, (512, "cgroup")),
        (V2, {"memory.max": f"{2**30}\n"}, (1024, "cgroup")),  # in a container, the mount is its own group
        (V2, {"lab/voa/memory.max": f"{2**40}\n"}, (8192, "machine")),
        (V1, {"memory/lab/voa/memory.limit_in_bytes": f"{2**30}\n"}, (1024, "cgroup")),
        (V1, {"memory/lab/voa/memory.limit_in_bytes": UNLIMITED}, (8192, "machine")),
        (V1, {"memory/memory.limit_in_bytes": f"{2**30}\n"}, (1024, "cgroup")),
        (V1, {"memory/elsewhere/memory.limit_in_bytes": f"{2**20}\n"}, (8192, "machine")),
    ],
)
def test_the_smallest_memory_limit_applies(
    tmp_path: Path, cgroup: str | None, limits: dict[str, str], expected: tuple[int, str]
) -> None:
    assert available_memory(Settings(), machine(tmp_path, cgroup, **limits)) == AvailableMemory(*expected)  # type: ignore[arg-type] # fields of several types


def test_the_setting_wins(tmp_path: Path) -> None:
    root = machine(tmp_path, V2, **{"memory.max": f"{2**30}\n"})
    assert available_memory(Settings(memory_mebibytes=3000), root) == AvailableMemory(3000, "setting")


def test_this_machine_has_memory() -> None:
    assert available_memory(Settings()).mebibytes > 256


def divided(mebibytes: int, processors: int = 8, **settings: Any) -> MemoryBudget:
    return budget(Settings(**settings), AvailableMemory(mebibytes, "machine"), processors)


@pytest.mark.parametrize("mebibytes", [1024, 1500, 2048, 3000, 4096, 8192, 24_000, 500_000])
@pytest.mark.parametrize("processors", [1, 2, 16, 256])
def test_the_defaults_fit(mebibytes: int, processors: int) -> None:
    budget = divided(mebibytes, processors)
    assert budget.sum_mebibytes <= mebibytes
    assert 1 <= budget.workers <= processors
    assert budget.mesh >= MESH_NEEDS_MEBIBYTES
    assert budget.cache >= 32


def test_a_large_machine_has_the_usual_sizes() -> None:
    budget = divided(64_000, 16)
    assert (budget.cache, budget.workers, budget.mesh, budget.meshes) == (2_048, 16, 2_048, 2)


def test_what_is_said_explicitly_holds_even_if_the_sum_does_not_fit() -> None:
    budget = divided(1024, cache_mebibytes=2_000, workers=7, mesh_mebibytes=900)
    assert (budget.cache, budget.workers, budget.mesh) == (2_000, 7, 900)
    assert budget.sum_mebibytes > 1024


def test_the_service_is_built_so_and_says_so(tmp_path: Path) -> None:
    with serving(tmp_path, memory_mebibytes=1024, workers=1, cache_mebibytes=77) as service:
        memory = service.get("/readyz")["memory"]
        assert service.inside.objects.cache.budget == 77 * MEBIBYTE
    assert (memory["total_mebibytes"], memory["source"], memory["cache_mebibytes"]) == (1024, "setting", 77)
    parts = ("process", "cache", "workers", "meshes", "bodies")
    assert memory["sum_mebibytes"] == sum(memory[f"{part}_mebibytes"] for part in parts)
