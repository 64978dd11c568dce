"""Responses that are serialised in the worker thread that computed them, and parameters that several routes share."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Annotated, Any

from fastapi import Path, Query, Request, Response
from pydantic import BaseModel

from voa_service.http.headers import etag
from voa_service.requests.large_json import dumped
from voa_service.runtime.queues import WorkQueue
from voa_store.records import StoredResponse

PageLimit = Annotated[int, Query(ge=1, le=1000, description="Largest number of items on the page.")]
After = Annotated[str | None, Query(description="Cursor: `next` of the previous page; without it, the first page.")]
DEFAULT_PAGE = 100
"""Number of items on a page, unless the request states it."""
ObjectId = Annotated[str, Path(description="Identifier of the object.")]
ScenarioId = Annotated[str, Path(description="Identifier of the scenario.")]
SessionId = Annotated[str, Path(description="Identifier of the session.")]
RobotName = Annotated[str, Path(description="Name of the robot in the mapping of robots.")]
_CLIENT_GONE = 499  # for the log: it is never sent


async def answer(queue: WorkQueue, work: Callable[[], BaseModel], *, exclude_unset: bool = False) -> Response:
    """Respond with the message that `work` returns, as JSON."""
    body = await queue.run(lambda: dumped(work(), exclude_unset=exclude_unset))
    return Response(body, media_type="application/json")


async def unless_gone(request: Request, work: Coroutine[Any, Any, Response]) -> Response:
    """Respond with what `work` returns, or cancel `work` when the client disconnects."""
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
    """Return when the client has disconnected; the body must have been received before."""
    while (await request.receive())["type"] != "http.disconnect":
        pass


async def created(queue: WorkQueue, work: Callable[[], tuple[BaseModel, bool]]) -> Response:
    """Respond with the message that `work` returns: status 201 if it is new, 200 if it was stored before."""

    def both() -> tuple[bytes, bool]:
        message, new = work()
        return dumped(message), new

    body, new = await queue.run(both)
    return Response(body, 201 if new else 200, media_type="application/json")


async def versioned(queue: WorkQueue, work: Callable[[], StoredResponse], status: int = 200) -> Response:
    """Respond with the session that `work` returns, with its version as ETag."""
    done = await queue.run(work)
    return Response(done.body, status, etag(done.version), "application/json")
