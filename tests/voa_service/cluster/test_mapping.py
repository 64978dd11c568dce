"""Rankings on a cluster are those of one process, whatever happens to its workers."""

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import dask
import pytest
from distributed import Client

from tests.voa_service.local.documents import data_document, local, mesh_document, nothing
from voa_service.cluster.connecting import Cluster, cluster_at
from voa_service.cluster.mapping import ClusterMap, chunks
from voa_service.cluster.scene import Scene
from voa_service.failures import InvalidRequest, NotReady
from voa_service.local.document import read_document
from voa_service.local.ranking import Parts, ranked
from voa_service.local.reported import Report, ReportedMap
from voa_service.mapping.rankings import ParallelMap
from voa_service.versions import versions

SIMULATED = {"scans": "simulated", "samples": 4, "sensor_std": {"xy_m": 0.01, "yaw_rad": 0.02}}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    with cluster_at("local:2") as there:
        yield there


def unreported(done: int, total: int) -> None:
    """Report that nobody reads."""


def ranking(document: bytes, cluster: Cluster | None, report: Report = unreported) -> bytes:
    """Rank on a cluster, or on threads (None)."""

    def distribute(threads: ParallelMap, parts: Parts) -> ParallelMap:
        if cluster is None:
            return threads
        scene = Scene(parts.scenario, parts.object, parts.cache_bytes, versions())
        return ReportedMap(ClusterMap(cluster.client, scene, parts.model, parts.check), report)

    with local() as built:
        return ranked(built, read_document(document), distribute, nothing).body


def places(count: int) -> list[dict[str, Any]]:
    return [{"name": f"Q{i}", "x": 0.3, "y": 0.002 * i, "yaw_rad": 3.1, "cost": 0.0001 * i} for i in range(count)]


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"definition": "executed", "pending": ["Q1"]},
        SIMULATED,
        SIMULATED | {"pending": ["Q3", "Q3"]},
        {"method": "sampled", "outcomes": False},
    ],
    ids=["exact, with pairs", "exact, after a look under way", "simulated", "after looks under way", "sampled"],
)
def test_the_answer_is_that_of_threads_byte_for_byte(tmp_path: Path, cluster: Cluster, options: dict[str, Any]) -> None:
    document = mesh_document(tmp_path, {"belief": [0.4, 0.6], "outcomes": True} | options, sensors=places(20))
    assert ranking(document, cluster) == ranking(document, None)


def test_a_scenario_of_data_needs_no_mesh(cluster: Cluster) -> None:
    document = data_document({"belief": [0.2, 0.3, 0.5]})
    assert ranking(document, cluster) == ranking(document, None)


def test_a_worker_that_is_killed_loses_nothing(tmp_path: Path, cluster: Cluster) -> None:
    document = mesh_document(tmp_path, {"belief": None} | SIMULATED | {"samples": 64}, sensors=places(300))
    before = processes_of(cluster)
    killed: list[int] = []

    def kill_once(done: int, total: int) -> None:
        if not killed:
            killed.append(min(before))
            assert done < total
            os.kill(killed[0], signal.SIGKILL)

    assert ranking(document, cluster, kill_once) == ranking(document, None)
    assert killed
    cluster.client.wait_for_workers(2, timeout=120)
    assert killed[0] not in processes_of(cluster)


def processes_of(cluster: Cluster) -> set[int]:
    """Ids of the processes of the workers."""
    return set(cluster.client.run(os.getpid).values())


def mapped(client: Client, function: Callable[[Any], Any], items: list[Any]) -> list[Any]:
    """Apply a function to items on the workers of a client, beside a scenario."""
    results: list[Any] = []

    def distribute(threads: ParallelMap, parts: Parts) -> ParallelMap:
        scene = Scene(parts.scenario, parts.object, parts.cache_bytes, versions())
        results.extend(ClusterMap(client, scene, parts.model, parts.check)(function, items))
        return threads

    with local() as built:
        ranked(built, read_document(data_document({"belief": None, "lookahead": 1})), distribute, nothing)
    return results


def test_a_part_that_cannot_be_computed_is_a_failure_as_on_threads(cluster: Cluster) -> None:
    assert mapped(cluster.client, refusing(), [1, 2]) == [1, 2]
    with pytest.raises(InvalidRequest, match="expected a name, got 3"):
        mapped(cluster.client, refusing(), [1, 3])


def test_a_part_that_ends_its_workers_and_a_cluster_that_is_lost_are_failures() -> None:
    def ending(item: int) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    once = {"distributed.scheduler.allowed-failures": 0}
    with dask.config.set(once), cluster_at("local:1") as there:
        with pytest.raises(NotReady, match="has ended several workers"):
            mapped(there.client, ending, [1])
        there.client.shutdown()
        with pytest.raises(NotReady, match="the connection to the cluster was lost"):
            mapped(there.client, ending, [1])


def refusing() -> Callable[[int], int]:
    """A nested function, which is sent as code, that refuses the number 3."""

    def refuse(item: int) -> int:
        from voa_core.errors import InvalidInput  # noqa: PLC0415 - the function is sent without its module

        if item == 3:
            raise InvalidInput("item", "a name", str(item))
        return item

    return refuse


def test_chunks_are_small_enough_for_all_threads_to_end_together() -> None:
    assert chunks([], 2) == []
    assert chunks(range(5), 2) == [range(i, i + 1) for i in range(5)]
    assert [len(chunk) for chunk in chunks(range(100), 2)] == [6] * 16 + [4]
    assert max(len(chunk) for chunk in chunks(range(10_000), 2)) == 32
    assert [item for chunk in chunks(range(1_000), 3) for item in chunk] == list(range(1_000))
