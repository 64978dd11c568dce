"""Files of new objects for the browser: pictures, the page of the scenario, and the archive."""

import re
from pathlib import Path

from fastapi import HTTPException, Request
from fastapi.responses import FileResponse, Response
from nicegui import app, run

from voa_console.keys.admission import admitted_of
from voa_console.new_object.folders import archive
from voa_console.new_object.workshop import Workshop

_PICTURE = re.compile(r"(rest|side)-\d{1,3}\.png")
_NO_SCRIPTS = {
    "Content-Security-Policy": "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'",
    "X-Content-Type-Options": "nosniff",
}
"""Headers of a page that was made from a mesh file which somebody sent: it may run nothing."""


def register(workshop: Workshop) -> None:
    """Declare the addresses of the files.

    Args:
        workshop: with the new objects.
    """

    @app.get("/new/files/{id_}/{file}")
    async def serve(id_: str, file: str, request: Request) -> Response:
        bench = workshop.bench(id_, admitted_of(request).console.key)
        if bench is not None and _PICTURE.fullmatch(file) and (bench.folder / file).is_file():
            return FileResponse(bench.folder / file)
        made = None if bench is None or bench.job is None else bench.job.made
        if made is not None and file == "look.html" and (Path(made.folder) / file).is_file():
            return FileResponse(Path(made.folder) / file, headers=_NO_SCRIPTS)
        if made is not None and file == "scenario.zip":
            content = await run.io_bound(archive, Path(made.folder), made.name)
            disposition = f'attachment; filename="{made.name}.zip"'
            return Response(content, media_type="application/zip", headers={"Content-Disposition": disposition})
        raise HTTPException(404, "there is no such file, or no longer")
