"""Meshes for browsers: fetched once, kept within a limit, and failures as statuses of HTTP."""

import asyncio

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from voa_client import UnreachableError
from voa_console.drawing.meshes import MeshCache, mesh_url, serve_meshes


class Meshes:
    """Source of meshes that counts its calls."""

    def __init__(self, size: int = 10) -> None:
        self.calls: list[str] = []
        self._size = size

    async def fetch(self, object_id: str) -> bytes:
        self.calls.append(object_id)
        await asyncio.sleep(0)
        if object_id == "away":
            raise UnreachableError("the service does not run")
        return object_id.encode()[:1] * self._size


def test_concurrent_requests_fetch_a_mesh_once() -> None:
    meshes = Meshes()
    cache = MeshCache(meshes.fetch)

    async def together() -> list[bytes]:
        return await asyncio.gather(*(cache.get("mug") for _ in range(5)))

    assert asyncio.run(together()) == [b"m" * 10] * 5
    assert meshes.calls == ["mug"]


def test_the_least_recently_used_mesh_is_dropped_above_the_limit() -> None:
    meshes = Meshes()
    cache = MeshCache(meshes.fetch, most_bytes=25)

    async def one_after_the_other() -> None:
        for name in ("a", "b", "a", "c", "a", "b"):
            await cache.get(name)

    asyncio.run(one_after_the_other())
    assert meshes.calls == ["a", "b", "c", "b"]


def test_a_failure_is_not_kept() -> None:
    meshes = Meshes()
    cache = MeshCache(meshes.fetch)
    for _ in range(2):
        with pytest.raises(UnreachableError):
            asyncio.run(cache.get("away"))
    assert meshes.calls == ["away", "away"]


def test_the_route_serves_a_mesh_that_browsers_may_keep_and_503_without_the_service() -> None:
    app = FastAPI()
    cache = MeshCache(Meshes().fetch)
    serve_meshes(app, lambda _: cache)
    with TestClient(app) as http:
        answer = http.get(mesh_url("mug"))
        assert answer.content == b"m" * 10
        assert "max-age=31536000" in answer.headers["cache-control"]
        assert http.get(mesh_url("away")).status_code == 503
