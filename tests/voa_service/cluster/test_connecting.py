"""Connections to clusters, and addresses that lead to none."""

import os
import socket
from contextlib import nullcontext

import pytest
from distributed import LocalCluster

from voa_service.cluster import connecting
from voa_service.cluster.connecting import cluster_at
from voa_service.failures import InvalidRequest, NotReady


def test_a_scheduler_is_reached_by_its_address_and_needs_workers() -> None:
    with LocalCluster(
        n_workers=0, host="127.0.0.1", dashboard_address=None, scheduler_kwargs={"dashboard_address": "127.0.0.1:0"}
    ) as own:
        none = "has no workers: start some with `dask worker tcp://"
        with pytest.raises(NotReady, match=none), cluster_at(own.scheduler_address):
            pass
        own.scale(1)
        own.wait_for_workers(1, timeout=120)
        with cluster_at(own.scheduler_address) as cluster:
            assert cluster.on_this_machine is None
            assert cluster.client.submit(sum, [1, 2]).result() == 3


@pytest.mark.parametrize("address", ["local:0", "local:many", "local:-1", "nothing://a:1"])
def test_an_address_that_is_not_valid_is_refused(address: str) -> None:
    with pytest.raises(InvalidRequest, match="expected"), cluster_at(address, patience_s=1.0):
        pass


def test_where_nobody_listens_it_says_so() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    with pytest.raises(NotReady, match=f"no scheduler of a cluster answers at {address}"):  # noqa: SIM117
        with cluster_at(address, patience_s=1.0):
            pass


def timed_out() -> RuntimeError:
    """Return the error of a worker that does not answer in time, as dask raises it: from another one."""
    error = RuntimeError("Nanny failed to start.")
    error.__cause__ = TimeoutError()
    return error


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (BlockingIOError(11, "Resource temporarily unavailable"), "Resource temporarily unavailable"),
        (TimeoutError(), r"\(TimeoutError\)"),
        (timed_out(), "Nanny failed to start. < TimeoutError"),
    ],
)
@pytest.mark.parametrize("failing", ["LocalCluster", "Client"])
def test_workers_that_cannot_be_started_are_no_defect_of_the_service(
    monkeypatch: pytest.MonkeyPatch, failing: str, error: Exception, reason: str
) -> None:
    closed = list[bool]()

    class Started:
        """A cluster without workers."""

        def __init__(self, **_: object) -> None:
            """Start nothing."""

        def __enter__(self) -> "Started":
            return self

        def __exit__(self, *_: object) -> None:
            closed.append(True)

    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(connecting, "LocalCluster", Started)
    monkeypatch.setattr(connecting, failing, fail)
    with pytest.raises(NotReady, match=f"3 worker processes could not be started .*{reason}.*Use fewer workers"):  # noqa: SIM117
        with cluster_at("local:3"):
            pass
    assert closed == ([True] if failing == "Client" else [])


def test_an_error_of_the_work_on_a_cluster_stays_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connecting, "LocalCluster", lambda **_: nullcontext())
    monkeypatch.setattr(connecting, "Client", lambda *_, **__: nullcontext())
    with pytest.raises(TimeoutError, match="of the work"), cluster_at("local:1"):
        raise TimeoutError("of the work")


def test_workers_on_this_machine_keep_the_memory_that_one_place_frees_for_the_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Dask's own environment for them lets malloc give everything back, which takes as long as the computation."""
    monkeypatch.delenv("MALLOC_TRIM_THRESHOLD_", raising=False)  # another test's workers may have left it
    with cluster_at("local:1") as cluster:
        (environment,) = cluster.client.run(lambda: dict(os.environ)).values()
    assert "MALLOC_TRIM_THRESHOLD_" not in environment
    assert environment["OPENBLAS_NUM_THREADS"] == "1"
