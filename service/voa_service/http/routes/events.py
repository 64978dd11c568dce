"""Route /v1/sessions/{id}/events: the versions of a session as server-sent events."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import suppress
from typing import Annotated

import structlog
from fastapi import APIRouter, Header, Request, Response
from fastapi.sse import format_sse_event
from starlette.responses import StreamingResponse
from starlette.types import Message, Send

from voa_service.failures import NotFound, not_found
from voa_service.http.authentication import caller_of
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import SessionId
from voa_service.runtime.feeds import Feed, Feeds, Version
from voa_service.services import Services
from voa_service.usecases.pages import position

_ALIVE_SECONDS = 15.0
_STALLED_SECONDS = 30.0
"""Seconds after which a follower that reads nothing is disconnected; it can reconnect with `Last-Event-ID`."""
_AGAIN_SECONDS = 0.25
_CHECK_SECONDS = 1.0
"""Interval at which the key of a follower that waits is checked."""
_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}

LastEventId = Annotated[
    str | None,
    Header(alias="Last-Event-ID", description="Last version that was received: the versions after it are sent."),
]


def routes(services: Services) -> APIRouter:
    """Make the route by which clients follow a session."""
    router = APIRouter(prefix="/v1", tags=["sessions"], route_class=strict_route(services.reader))

    @router.get(
        "/sessions/{id}/events",
        response_class=StreamingResponse,
        responses={
            200: {
                "content": {"text/event-stream": {"schema": {"type": "string"}}},
                "description": "The versions of the session as server-sent events, until it is deleted.",
            },
            **problems(NotFound),
        },
    )
    async def follow_session(id: SessionId, http: Request, last_event_id: LastEventId = None) -> Response:
        """Follow the versions of a session as server-sent events.

        The current version is sent first, then each new version, whichever process stored it: `event: session`, with
        the version as `id` and the session as `data`. With `Last-Event-ID`, every version after that one is sent.
        `event: deleted` ends the stream. The stream also ends when the caller's key is revoked or expires.
        """
        seen = None if last_event_id is None else position(last_event_id)
        first = await services.feeds.first(id, seen)
        if first is None:
            raise not_found("session", id)
        caller = caller_of(http)
        events = events_of(services.feeds, id, seen, first, lambda: services.gate.keyring.is_valid(caller))
        return EventStream(events, media_type="text/event-stream", headers=_HEADERS)

    return router


class EventStream(StreamingResponse):
    """Stream that ends when its client reads nothing for `_STALLED_SECONDS`."""

    async def stream_response(self, send: Send) -> None:
        """Send each piece of the stream, or end it when sending takes longer than `_STALLED_SECONDS`."""

        async def within(message: Message) -> None:
            async with asyncio.timeout(_STALLED_SECONDS):
                await send(message)

        try:
            await super().stream_response(within)
        except TimeoutError:
            structlog.get_logger().warning(
                "a follower that read nothing was disconnected", stalled_seconds=_STALLED_SECONDS
            )


async def events_of(
    feeds: Feeds, id_: str, seen: int | None, first: Sequence[Version], is_allowed: Callable[[], bool]
) -> AsyncIterator[bytes]:
    """Write the versions of a session as events: those in `first`, then every newer one in order.

    Args:
        feeds: source of the newer versions.
        id_: identifier of the session.
        seen: newest version that the follower has; None: it has none, and `first` is the newest.
        first: versions that were read already.
        is_allowed: returns False once the follower's key is no longer valid, which ends the events.
    """
    async with feeds.following(id_) as feed:
        news: Sequence[Version] | None = first
        while True:
            for version in news or ():
                if not is_allowed():
                    return
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
            if not await _waited(turn, is_allowed) and is_allowed():
                yield format_sse_event(comment="alive")
            if not is_allowed():
                return


async def _next(feed: Feed, seen: int | None) -> Sequence[Version]:
    """Return the versions above `seen`, from the store where the feed no longer holds all of them."""
    news = None if seen is None else feed.after(seen)
    while news is None and not feed.closed:
        news = await feed.missed(seen) or None
        if news is None:
            await asyncio.sleep(_AGAIN_SECONDS)
    return news or ()


async def _waited(turn: asyncio.Event, is_allowed: Callable[[], bool]) -> bool:
    """True if the feed changed before a keep-alive comment was due, or the follower's key was no longer valid."""
    until = time.monotonic() + _ALIVE_SECONDS
    while is_allowed() and (left := until - time.monotonic()) > 0.0:
        with suppress(TimeoutError):
            async with asyncio.timeout(min(left, _CHECK_SECONDS)):
                await turn.wait()
                return True
    return False
