"""Page /, for a person who opens the address of the service in a browser."""

from fastapi import FastAPI, Request, Response
from starlette.responses import RedirectResponse

from voa_service.console import ConsolePort

_HEADERS = {"Cache-Control": "no-store"}


def install(app: FastAPI, console: ConsolePort) -> None:
    """Redirect `/` to the console where one runs, else to `/docs`; as these pages, it is not in the OpenAPI document.

    Args:
        app: the application.
        console: returns the port of the console that runs beside the service; None: none runs.
    """

    async def lead_on(request: Request) -> Response:
        port = console()
        where = "/docs" if port is None else str(request.url.replace(port=port))
        return RedirectResponse(where, headers=_HEADERS)

    app.add_route("/", lead_on, methods=["GET"], include_in_schema=False)
