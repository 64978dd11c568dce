"""Composition of a console: settings, client, hub and pages become one application."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from fastapi import FastAPI
from fastapi.middleware.trustedhost import TrustedHostMiddleware
from nicegui import ui
from starlette.middleware.body_limit import RequestBodyLimitMiddleware

from voa_client import AsyncClient, Retries
from voa_console import new_object, now, robots, session
from voa_console.context import Console
from voa_console.guard import SameOrigin
from voa_console.settings import ConsoleSettings
from voa_console.watching.hub import Hub

_MOST_BODY_BYTES = 21_000_000
"""Bound on the body of a request: a mesh file of 20 MB, and the form around it."""
_TIMEOUT_S = 60.0
_ATTEMPT_S = 5.0
_RETRIES = Retries(most_s=1.0, within_s=1.0)
"""Retries for a person in front of a page: enough for a short disturbance, and a silent service is soon reported."""


def create(settings: ConsoleSettings) -> FastAPI:
    """Build the application of a console; there can be one in a process, because NiceGUI has one set of pages."""
    client = AsyncClient(settings.url, _TIMEOUT_S, _ATTEMPT_S, _RETRIES)
    console = Console(settings, client, Hub(client, recent_s=settings.recent_s))

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        polling = asyncio.create_task(console.hub.run(), name="voa-console-hub")
        try:
            yield
        finally:
            polling.cancel()
            with suppress(asyncio.CancelledError):
                await polling
            await client.close()

    app = FastAPI(lifespan=lifespan, docs_url=None, redoc_url=None, openapi_url=None)

    @app.get("/livez")
    async def is_alive() -> dict[str, str]:
        return {"status": "alive"}

    register(console)
    app.add_middleware(RequestBodyLimitMiddleware, max_body_size=_MOST_BODY_BYTES)
    app.add_middleware(SameOrigin)
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=settings.names, www_redirect=False)
    ui.run_with(app, title="VOA console", language="en-US", dark=None, show_welcome_message=False, favicon="🔦")
    return app


def register(console: Console) -> None:
    """Declare the pages of a console."""
    now.register(console)
    session.register(console)
    robots.register(console)
    new_object.register(console)
