"""Connections to a scheduler of dask.distributed, and clusters of worker processes on this machine."""

import logging
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import dask
from distributed import Client, LocalCluster

from voa_service.failures import InvalidRequest, NotReady
from voa_service.runtime.memory import processors

LOCAL = "local"
_CONFIGURATION = {
    "distributed.admin.large-graph-warning-threshold": "1 GiB",  # a scene is sent as a part of the graph
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    # What a scheduler and workers do at intervals, for a dashboard that is not there, takes as long as the ranking's
    # own messages; and chunks wait at the scheduler until a worker is free, so that none has to be stolen.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.scheduler.work-stealing-interval": "1s",
    "distributed.scheduler.active-memory-manager.start": False,
    # Without dask's threshold of malloc, by which a worker gives all freed memory back to the system: the next place
    # would have to wait for as much again.
    "distributed.nanny.pre-spawn-environ": {"OMP_NUM_THREADS": 1, "MKL_NUM_THREADS": 1, "OPENBLAS_NUM_THREADS": 1},
}


@dataclass(frozen=True)
class Cluster:
    """A connection to a cluster.

    Attributes:
        client: of its scheduler.
        on_this_machine: number of workers that share this machine; None: they have machines of their own.
    """

    client: Client
    on_this_machine: int | None


@contextmanager
def cluster_at(address: str, patience_s: float = 30.0) -> Iterator[Cluster]:
    """Connect to a cluster for the length of a `with`.

    Args:
        address: of a scheduler ("tcp://10.0.0.7:8786"), or "local" or "local:4" for so many worker processes on this
            machine, by default one for each processor.
        patience_s: time for which a connection to a scheduler is tried.

    Raises:
        InvalidRequest: the address is not valid.
        NotReady: no scheduler answers there, it has no workers, or workers cannot be started on this machine.
    """
    kind, _, count = address.partition(":")
    logging.getLogger("distributed").setLevel(logging.ERROR)  # a lost worker is no event for the user of a ranking
    with dask.config.set(_CONFIGURATION):
        if kind != LOCAL:
            with _client(address, patience_s) as client:
                if not client.nthreads():
                    raise NotReady(
                        f"the scheduler at {address} has no workers: start some with `dask worker {address}`"
                    )
                yield Cluster(client, None)
            return
        if count and not (count.isdecimal() and int(count) > 0):
            raise InvalidRequest(f"expected {LOCAL}:N with a number of processes, got {address!r}")
        workers = int(count) if count else processors()
        with _workers_here(workers) as client:
            yield Cluster(client, workers)


@contextmanager
def _workers_here(count: int) -> Iterator[Client]:
    """Start worker processes on this machine, connected to a scheduler of their own, for the length of a `with`.

    Raises:
        NotReady: they cannot be started.
    """
    with ExitStack() as running:
        try:
            folder = running.enter_context(tempfile.TemporaryDirectory(prefix="voa-workers-"))
            started = LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address=None,
                scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
                silence_logs=logging.ERROR,
                memory_limit=0,
                local_directory=folder,
            )
            running.enter_context(started)
            client = running.enter_context(Client(started, set_as_default=False))
        except (OSError, RuntimeError) as error:  # a timeout is an OSError; dask raises RuntimeError from other errors
            raise NotReady(
                f"{count} worker processes could not be started on this machine ({_reasons(error)}): is there enough "
                f"memory, and may a user have so many processes and open files? Use fewer workers ({LOCAL}:N), or rank "
                "without a cluster, on the threads of one process"
            ) from error
        yield client


def _reasons(error: BaseException) -> str:
    """Describe an error and those that it comes from, the first of them last."""
    described = f"{type(error).__name__}: {error}".removesuffix(": ")
    before = error.__cause__ or error.__context__
    return described if before is None else f"{described} < {_reasons(before)}"


@contextmanager
def _client(address: str, patience_s: float) -> Iterator[Client]:
    """Connect to a scheduler for the length of a `with`; raises InvalidRequest or NotReady."""
    try:
        client = Client(address, timeout=patience_s, set_as_default=False)
    except ValueError as error:
        raise InvalidRequest(
            f"expected tcp://HOST:PORT of a scheduler, {LOCAL} or {LOCAL}:N, got {address!r}"
        ) from error
    except OSError as error:
        raise NotReady(f"no scheduler of a cluster answers at {address}: {error}") from error
    with client:
        yield client
