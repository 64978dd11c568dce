"""Choice of where the parts of a ranking are computed, and of whether their results are kept."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from voa_service.failures import InvalidRequest
from voa_service.local.ranking import Distribute, Parts
from voa_service.local.reported import Report, ReportedMap
from voa_service.local.resumed import ResumedMap, folder_of
from voa_service.mapping.rankings import ParallelMap
from voa_service.versions import versions


@contextmanager
def distribution(cluster: str | None, resume: Path | None, report: Report) -> Iterator[Distribute]:
    """Give the function that says where the parts of a ranking are computed, for the length of a `with`.

    Args:
        cluster: address of a scheduler, or "local" with a number of processes; None: threads of this process.
        resume: folder that keeps the results of finished parts; None: they are not kept.
        report: called for each finished part.

    Raises:
        InvalidRequest: the address is not valid, or the packages for a cluster are not installed.
        NotReady: the cluster does not answer.
    """
    if cluster is None:
        yield lambda threads, parts: _observed(threads, parts, resume, report)
        return
    if find_spec("distributed") is None:
        raise InvalidRequest("a cluster needs dask.distributed: install the extra `cluster`")
    from voa_service.cluster.connecting import cluster_at  # noqa: PLC0415 - takes a second, and is an extra
    from voa_service.cluster.mapping import ClusterMap  # noqa: PLC0415 - takes a second, and is an extra
    from voa_service.cluster.scene import Scene  # noqa: PLC0415 - takes a second, and is an extra

    with cluster_at(cluster) as there:

        def distribute(_: ParallelMap, parts: Parts) -> ParallelMap:
            share = parts.cache_bytes // (there.on_this_machine or 1)
            scene = Scene(parts.scenario, parts.object, share, versions())
            return _observed(ClusterMap(there.client, scene, parts.model, parts.check), parts, resume, report)

        yield distribute


def _observed(parallel_map: ParallelMap, parts: Parts, resume: Path | None, report: Report) -> ParallelMap:
    """Let a map keep its results, where there is a folder for them, and report them."""
    if resume is not None:
        # The memory for the cache decides which weights are kept, and with it the last bit of some sums.
        ranking = {"request": parts.request, "scenario": parts.scenario.id, "cache_bytes": str(parts.cache_bytes)}
        parallel_map = ResumedMap(parallel_map, folder_of(resume, ranking | versions()))
    return ReportedMap(parallel_map, report)
