"""A map over the parts of a ranking whose function is applied by the workers of a cluster, in chunks."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

from distributed import Client, KilledWorker
from distributed.client import ClosedClientError

from voa_service.cluster.scene import Scene
from voa_service.cluster.sending import dumped, loaded, named_parts
from voa_service.failures import NotReady
from voa_service.guard import guarded
from voa_service.mapping.models import Model
from voa_service.runtime.queues import Check

A = TypeVar("A")
B = TypeVar("B")

_CHUNKS_OF_THREAD = 8
"""Chunks for each thread of the cluster: so many that the threads end at nearly the same time."""
_MOST_IN_CHUNK = 32


@dataclass(frozen=True, eq=False)
class SentFunction:
    """A function on its way to the workers, each of which reads it once.

    Attributes:
        content: the function as bytes.
    """

    content: bytes

    def of(self, scene: Scene) -> Callable[[Any], Any]:
        """Return the function, which works on the scene of this process."""
        if "function" not in self.__dict__:
            self.__dict__["function"] = loaded(self.content, named_parts(scene.model, _wanted))
        function: Callable[[Any], Any] = self.__dict__["function"]
        return function

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what is sent: the bytes alone."""
        return SentFunction, (self.content,)


@dataclass(frozen=True, eq=False)
class ClusterMap:
    """A `map` that applies a function on the workers of a cluster; a chunk whose worker is lost is computed again.

    Attributes:
        client: of the scheduler.
        scene: scenario of the ranking.
        model: its mathematics in this process, which the functions of the ranking hold.
        check: of the ranking, which its functions hold; workers compute without it.
    """

    client: Client
    scene: Scene
    model: Model
    check: Check

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterator[B]:
        """Yield the results in the order of the items.

        Raises:
            Failure: a part cannot be computed, or the cluster is lost.
        """
        listed, sent = list(items), SentFunction(dumped(function, named_parts(self.model, self.check)))
        futures: list[Any] = []
        try:
            futures.append(self.client.submit(_given, sent, pure=False))
            futures += [
                self.client.submit(computed, self._scene_there, futures[0], chunk, pure=False)
                for chunk in chunks(listed, sum(self.client.nthreads().values()))
            ]
            for future in futures[1:]:
                yield from future.result()
        except KilledWorker as error:
            raise NotReady(f"a part of the ranking has ended several workers: too little memory? ({error})") from error
        except (CancelledError, ClosedClientError, OSError) as error:
            raise NotReady(f"the connection to the cluster was lost: {error}") from error
        finally:
            if self.client.status == "running":
                self.client.cancel(futures)

    @cached_property
    def _scene_there(self) -> Any:
        """Scene in the memory of the workers, which get it from each other, and again from here if it is lost."""
        return self.client.submit(_given, self.scene, pure=False)


def chunks(items: Sequence[A], threads: int) -> list[Sequence[A]]:
    """Split items into chunks of nearly equal sizes, at least 8 for each thread where there are so many items.

    Args:
        items: in their order.
        threads: of all workers together.
    """
    size = max(1, min(_MOST_IN_CHUNK, len(items) // (_CHUNKS_OF_THREAD * max(1, threads))))
    return [items[start : start + size] for start in range(0, len(items), size)]


@guarded()
def computed(scene: Scene, sent: SentFunction, items: Sequence[Any]) -> list[Any]:
    """Apply a function to items, on a worker.

    Raises:
        Failure: an item cannot be computed.
    """
    function = sent.of(scene)
    return [function(item) for item in items]


def _given(value: A) -> A:
    """Return a value: the task by which a worker has it, and by which it is sent again once it is lost."""
    return value


def _wanted() -> None:
    """Check of a ranking on a worker: every part is wanted."""
