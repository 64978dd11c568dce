"""Meshes for browsers: fetched from the service once, thinned, and kept within a limit."""

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable

from fastapi import FastAPI, HTTPException, Request, Response

from voa_client import NotFoundError, VoaClientError

MOST_FACES = 5_000
"""Most faces of a mesh in a page; the service thins meshes that have more."""
_MOST_BYTES = 64 * 2**20
_YEAR_S = 31_536_000
Fetch = Callable[[str], Awaitable[bytes]]
"""Function that fetches the mesh of an object as a binary STL file."""


class MeshCache:
    """Meshes by object, the least recently used of which are dropped above a limit.

    Args:
        fetch: fetches the mesh of an object.
        most_bytes: most memory of all meshes.
    """

    def __init__(self, fetch: Fetch, most_bytes: int = _MOST_BYTES) -> None:
        self._fetch = fetch
        self._most = most_bytes
        self._meshes: OrderedDict[str, bytes] = OrderedDict()
        self._locks: dict[str, asyncio.Lock] = {}

    async def get(self, object_id: str) -> bytes:
        """Return the mesh of an object; concurrent calls fetch it once; raises VoaClientError."""
        lock = self._locks.setdefault(object_id, asyncio.Lock())
        try:
            async with lock:
                if object_id not in self._meshes:
                    self._meshes[object_id] = await self._fetch(object_id)
                self._meshes.move_to_end(object_id)
                mesh = self._meshes[object_id]
                self._drop()
                return mesh
        finally:
            if not lock.locked():
                self._locks.pop(object_id, None)

    def _drop(self) -> None:
        """Drop meshes, the least recently used first, while they need too much memory."""
        while len(self._meshes) > 1 and sum(map(len, self._meshes.values())) > self._most:
            self._meshes.popitem(last=False)


def mesh_url(object_id: str) -> str:
    """Return the address of the mesh of an object, below the console's own."""
    return f"/meshes/{object_id}.stl"


def serve_meshes(app: FastAPI, cache_of: Callable[[Request], MeshCache]) -> None:
    """Add the route that gives browsers the mesh of an object; an object never changes, so that they may keep it.

    Args:
        app: the application.
        cache_of: returns the cache for a request.
    """

    @app.get("/meshes/{object_id}.stl", include_in_schema=False)
    async def mesh(object_id: str, request: Request) -> Response:
        try:
            content = await cache_of(request).get(object_id)
        except NotFoundError as error:
            raise HTTPException(404, f"the service has no object {object_id}") from error
        except VoaClientError as error:
            raise HTTPException(503, str(error)) from error
        return Response(content, media_type="model/stl", headers={"Cache-Control": f"private, max-age={_YEAR_S}"})
