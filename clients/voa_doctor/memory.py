"""Check of the service's memory: the limits of its parts against the memory of its machine or container."""

from collections.abc import Iterator

from voa_doctor.findings import Finding
from voa_msgs.problems import Memory

_SOURCES = {"setting": "VOA_MEMORY_MEBIBYTES", "cgroup": "its container's or unit's limit", "machine": "the machine"}


def check_memory(memory: Memory | None) -> Iterator[Finding]:
    """Compare the sum of the service's memory limits with its memory; no finding if it does not report them."""
    if memory is None:
        return
    parts = (
        f"process {memory.process_mebibytes}, cache {memory.cache_mebibytes}, workers {memory.workers_mebibytes}, "
        f"meshes {memory.meshes_mebibytes}, bodies {memory.bodies_mebibytes}"
    )
    available = f"{memory.total_mebibytes} MiB ({_SOURCES[memory.source]})"
    seen = f"at most {memory.sum_mebibytes} MiB ({parts}) of {available}"
    if memory.sum_mebibytes <= memory.total_mebibytes:
        yield Finding("memory", "ok", seen)
        return
    advice = "set VOA_CACHE_MEBIBYTES, VOA_WORKERS or VOA_MESH_MEBIBYTES lower, or give the service more memory"
    yield Finding("memory", "warning", seen, advice)
