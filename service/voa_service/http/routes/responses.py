"""Answers as bytes, made in the worker thread that computed them; and what pages are asked for with."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Annotated, Any

from fastapi import Query, Request, Response
from pydantic import BaseModel

from voa_msgs.large_json import dumped
from voa_service.http.headers import etag
from voa_service.runtime.queues import WorkQueue
from voa_store.records import StoredResponse

PageLimit = Annotated[int, Query(ge=1, le=1000, description="Most items of the page.")]
After = Annotated[str | None, Query(description="`next` of the page before; without it, from the start.")]
DEFAULT_PAGE = 100
_CLIENT_GONE = 499  # for the log: it is never sent


async def answer(queue: WorkQueue, work: Callable[[], BaseModel], *, exclude_unset: bool = False) -> Response:
    """The message that `work` gives, as JSON."""
    body = await queue.run(lambda: dumped(work(), exclude_unset=exclude_unset))
    return Response(body, media_type="application/json")


async def unless_gone(request: Request, work: Coroutine[Any, Any, Response]) -> Response:
    """The response that `work` gives; `work` is cancelled when the client goes, and nobody gets the response then."""
    working = asyncio.ensure_future(work)
    leaving = asyncio.ensure_future(_gone(request))
    try:
        await asyncio.wait({working, leaving}, return_when=asyncio.FIRST_COMPLETED)
        return working.result() if working.done() else Response(status_code=_CLIENT_GONE)
    finally:
        for task in (working, leaving):
            task.cancel()
        await asyncio.gather(working, leaving, return_exceptions=True)


async def _gone(request: Request) -> None:
    """Return when the client has gone; its body was received before."""
    while (await request.receive())["type"] != "http.disconnect":
        pass


async def created(queue: WorkQueue, work: Callable[[], tuple[BaseModel, bool]]) -> Response:
    """The same, 201 where it is new and 200 where the same content was there."""

    def both() -> tuple[bytes, bool]:
        message, new = work()
        return dumped(message), new

    body, new = await queue.run(both)
    return Response(body, 201 if new else 200, media_type="application/json")


async def versioned(queue: WorkQueue, work: Callable[[], StoredResponse], status: int = 200) -> Response:
    """What a write was answered, with the session's version as ETag."""
    done = await queue.run(work)
    return Response(done.body, status, etag(done.version), "application/json")
