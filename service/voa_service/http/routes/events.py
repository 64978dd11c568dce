"""/v1/sessions/{id}/events: a session's versions as they come, as server-sent events."""

import asyncio
from collections.abc import AsyncIterator, Sequence
from typing import Annotated

import structlog
from fastapi import APIRouter, Header, Response
from fastapi.sse import format_sse_event
from starlette.responses import StreamingResponse
from starlette.types import Message, Send

from voa_service.failures import not_found
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.runtime.feeds import Feed, Feeds, Version
from voa_service.services import Services
from voa_service.usecases.pages import position

_ALIVE_SECONDS = 15.0
_STALLED_SECONDS = 30.0
"""A follower that takes nothing for so long, its buffers full, is dropped; it may come back with `Last-Event-ID`."""
_AGAIN_SECONDS = 0.25
_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}

LastEventId = Annotated[
    str | None, Header(alias="Last-Event-ID", description="The last version received: what came after it is sent.")
]


def routes(services: Services) -> APIRouter:
    """Follow a session."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))

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
        first = await services.feeds.first(id, seen)
        if first is None:
            raise not_found("session", id)
        events = events_of(services.feeds, id, seen, first)
        return EventStream(events, media_type="text/event-stream", headers=_HEADERS)

    return router


class EventStream(StreamingResponse):
    """A stream that ends where its reader takes nothing for long."""

    async def stream_response(self, send: Send) -> None:
        """Send what comes, each piece within `_STALLED_SECONDS`."""

        async def within(message: Message) -> None:
            async with asyncio.timeout(_STALLED_SECONDS):
                await send(message)

        try:
            await super().stream_response(within)
        except TimeoutError:
            structlog.get_logger().warning("a follower was dropped", stalled_seconds=_STALLED_SECONDS)


async def events_of(feeds: Feeds, id_: str, seen: int | None, first: Sequence[Version]) -> AsyncIterator[bytes]:
    """Write a session's versions as events: `first`, then every later one in order.

    Args:
        feeds: where later ones come from.
        id_: of the session.
        seen: the last version that the follower has; None: it has none, and `first` is the newest.
        first: read already.
    """
    async with feeds.following(id_) as feed:
        news: Sequence[Version] | None = first
        while True:
            for version in news or ():
                seen = version.number
                yield format_sse_event(event="session", id=str(seen), data_str=version.body)
            turn = feed.turn
            news = await _next(feed, seen)
            if news:
                continue
            if feed.gone:
                yield format_sse_event(event="deleted", data_str="{}")
            if feed.closed:
                return
            if not await _waited(turn):
                yield format_sse_event(comment="alive")


async def _next(feed: Feed, seen: int | None) -> Sequence[Version]:
    """The versions above `seen` that there are now; read from the store where the feed no longer has them all."""
    news = None if seen is None else feed.after(seen)
    while news is None and not feed.closed:
        news = await feed.missed(seen) or None
        if news is None:
            await asyncio.sleep(_AGAIN_SECONDS)
    return news or ()


async def _waited(turn: asyncio.Event) -> bool:
    """Whether something changed before it was time for a sign of life."""
    try:
        async with asyncio.timeout(_ALIVE_SECONDS):
            await turn.wait()
    except TimeoutError:
        return False
    return True
