"""/v1/sessions/{id}/events: a session's versions as they come, as server-sent events."""

import time
from collections.abc import AsyncIterator
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Header, Response
from fastapi.sse import format_sse_event
from starlette.responses import StreamingResponse

from voa_service.failures import Failure
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.services import Services
from voa_service.usecases.pages import position

_LOOK_SECONDS = 0.25  # how late a version that another process made may be
_ALIVE_SECONDS = 15.0
_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}

LastEventId = Annotated[
    str | None, Header(alias="Last-Event-ID", description="The last version received: what came after it is sent.")
]


def routes(services: Services) -> APIRouter:
    """Follow a session."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))
    sessions = services.sessions

    @router.get(
        "/sessions/{id}/events",
        response_class=StreamingResponse,
        responses={
            200: {
                "content": {"text/event-stream": {"schema": {"type": "string"}}},
                "description": "Versions, without end",
            },
            **problems(404, 422, 503),
        },
    )
    async def follow_session(id: str, last_event_id: LastEventId = None) -> Response:
        """The current state first, then each new version, whoever made it: `event: session`, its version as `id`.

        With `Last-Event-ID` every version after that one. `event: deleted` ends the stream.
        """
        seen = None if last_event_id is None else position(last_event_id)
        await services.quick.run(lambda: sessions.state(id))
        return StreamingResponse(_events(services, id, seen), media_type="text/event-stream", headers=_HEADERS)

    return router


async def _events(services: Services, id_: str, seen: int | None) -> AsyncIterator[bytes]:
    spoke = time.monotonic()
    with services.changes.watching(id_) as watch:
        while not watch.closed:
            try:
                news = await services.quick.run(partial(services.sessions.since, id_, seen))
            except Failure:  # overloaded: later
                news = []
            if news is None:
                yield format_sse_event(event="deleted", data_str="{}")
                return
            for session in news:
                seen = session.version
                yield format_sse_event(event="session", id=str(seen), data_str=session.model_dump_json())
            if news or time.monotonic() - spoke > _ALIVE_SECONDS:
                spoke = time.monotonic()
                if not news:
                    yield format_sse_event(comment="alive")
            await watch.wait(_LOOK_SECONDS)
