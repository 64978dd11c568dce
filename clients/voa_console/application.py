"""Composition of a console: settings, client, hub and pages become one application."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial

from fastapi import FastAPI
from fastapi.middleware.trustedhost import TrustedHostMiddleware
from nicegui import app as pages
from nicegui import ui
from starlette.middleware.body_limit import RequestBodyLimitMiddleware

from voa_client import AsyncClient, Retries
from voa_console import new_object, now, robots, session
from voa_console.context import Console
from voa_console.drawing.meshes import MOST_FACES, MeshCache, serve_meshes
from voa_console.guard import SameOrigin
from voa_console.keys import key_page
from voa_console.keys.access import Access
from voa_console.keys.admission import Admission, admitted_of
from voa_console.keys.forms import serve_forms
from voa_console.settings import ConsoleSettings

_MOST_BODY_BYTES = 21_000_000
"""Bound on the body of a request: a mesh file of 20 MB, and the form around it."""
_TIMEOUT_S = 60.0
_ATTEMPT_S = 5.0
_RETRIES = Retries(most_s=1.0, within_s=1.0)
"""Retries for a person in front of a page: enough for a short disturbance, and a silent service is soon reported."""


def create(settings: ConsoleSettings) -> FastAPI:
    """Build the application of a console; there can be one in a process, because NiceGUI has one set of pages."""
    access = Access(settings, lambda key: AsyncClient(settings.url, _TIMEOUT_S, _ATTEMPT_S, _RETRIES, key=key))

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        access.start()
        try:
            yield
        finally:
            await access.close()

    app = FastAPI(lifespan=lifespan, docs_url=None, redoc_url=None, openapi_url=None)

    @app.get("/livez")
    async def is_alive() -> dict[str, str]:
        return {"status": "alive"}

    serve_forms(app, access)
    register(access)
    app.add_middleware(Admission, access=access)
    app.add_middleware(RequestBodyLimitMiddleware, max_body_size=_MOST_BODY_BYTES)
    app.add_middleware(SameOrigin)
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=settings.names, www_redirect=False)
    ui.run_with(app, title="VOA console", language="en-US", dark=None, show_welcome_message=False, favicon="🔦")
    return app


def register(access: Access) -> None:
    """Declare the pages of a console, and the route of the meshes that they show.

    Args:
        access: of browsers to them.
    """
    key_page.register(access)
    now.register()
    session.register()
    robots.register()
    new_object.register(access)
    serve_meshes(pages, lambda request: admitted_of(request).console.part(_meshes_of))


def _meshes_of(console: Console) -> MeshCache:
    """Make the cache of meshes that the pages of a key share."""
    return MeshCache(partial(console.client.object_mesh, most_faces=MOST_FACES))
