"""Workshop: the benches of all new objects that are on the pages of this console."""

import secrets
import shutil
import tempfile
import time
from collections import Counter
from pathlib import Path

from voa_console.new_object.bench import Bench

MOST = 8
"""Most new objects at a time, of all keys together: each may have a process."""


class Workshop:
    """The new objects of this console; pages that are closed and opened again show them as they are.

    Args:
        url: address of the service.
    """

    def __init__(self, url: str) -> None:
        self._url = url
        self._benches: dict[str, Bench] = {}

    def benches(self, key: str | None = None) -> list[Bench]:
        """List the benches of a key that have a mesh, the last used first; None: of the console's own key."""
        used = [bench for bench in self._benches.values() if bench.draft is not None and bench.key == key]
        return sorted(used, key=lambda bench: -bench.used_at)

    def bench(self, id_: str, key: str | None = None) -> Bench | None:
        """Return the bench of that identifier; None: there is none of that key, or no longer."""
        bench = self._benches.get(id_)
        return bench if bench is not None and bench.key == key else None

    def making(self) -> Bench | None:
        """Return the bench whose scenario is being made; None: none is."""
        return next((bench for bench in self._benches.values() if bench.is_making), None)

    async def new(self, key: str | None = None) -> Bench:
        """Make an empty bench; beyond the most that there may be, another one ends that is not being made.

        Of those of the same key, or else of the key that has most, the one that waits for the longest time ends.

        Args:
            key: that a browser gave; None: the console's own.
        """
        waiting = [bench for bench in self._benches.values() if not bench.is_making]
        if len(self._benches) >= MOST and waiting:
            have = Counter(bench.key for bench in waiting)
            await self.remove(min(waiting, key=lambda bench: (bench.key != key, -have[bench.key], bench.used_at)))
        id_ = secrets.token_hex(8)
        folder = Path(tempfile.mkdtemp(prefix="voa-console-"))
        self._benches[id_] = Bench(id_, self._url, folder, used_at=time.monotonic(), key=key)
        return self._benches[id_]

    async def remove(self, bench: Bench) -> None:
        """End a bench, with its processes and its own folder; a folder that a person named stays."""
        self._benches.pop(bench.id, None)
        await bench.close()
        shutil.rmtree(bench.folder, ignore_errors=True)

    async def forget(self, key: str | None) -> None:
        """End the benches of a key that a browser gave, with their processes."""
        for bench in [each for each in self._benches.values() if key is not None and each.key == key]:
            await self.remove(bench)

    async def close(self) -> None:
        """End all benches."""
        for bench in list(self._benches.values()):
            await self.remove(bench)
