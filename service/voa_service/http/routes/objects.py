"""/v1/objects."""

from collections.abc import Sequence
from typing import Annotated

from annotated_types import Gt
from fastapi import APIRouter, Form, Query, Request, Response, UploadFile

from voa_msgs.base import Name
from voa_msgs.objects import MeshType, Object, ObjectPage, Sha256, StablePoses, UpAxis
from voa_service.failures import InvalidRequest
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import DEFAULT_PAGE, After, PageLimit, answer, created
from voa_service.services import Services

_FIELDS = ("file", "name", "scale", "up")


def routes(services: Services) -> APIRouter:
    """Upload meshes, look at them."""
    router = APIRouter(prefix="/v1/objects", tags=["objects"], route_class=strict_route(services.reader))
    objects = services.objects

    @router.post(
        "",
        status_code=201,
        response_model=Object,
        responses={
            200: {"model": Object, "description": "The same mesh is there"},
            **problems(400, 413, 415, 422, 503),
        },
    )
    async def create_object(
        request: Request,
        file: UploadFile,
        name: Annotated[Name | None, Form(description="Default: the file's name.")] = None,
        scale: Annotated[float, Gt(0.0), Form(description="Metres per unit of the file.", allow_inf_nan=False)] = 1.0,
        up: Annotated[
            UpAxis | None,
            Form(description="The file's axis that is up, +Y is turned to z. Default: +Y for GLB, +Z for the others."),
        ] = None,
    ) -> Response:
        """Store a mesh: OBJ, STL, PLY or GLB, by the file's ending."""
        _check_fields([name for name, _ in (await request.form()).multi_items()])
        content = await file.read()
        filename = file.filename or ""
        return await created(services.meshes, lambda: objects.create(content, filename, name, scale, up))

    @router.get("", response_model=ObjectPage, responses=problems(422, 503))
    async def list_objects(
        limit: PageLimit = DEFAULT_PAGE,
        after: After = None,
        sha256: Annotated[Sha256 | None, Query(description="Of the bytes of a mesh file: only its mesh.")] = None,
        type: Annotated[MeshType | None, Query(description="The ending of that file's name; with `sha256`.")] = None,
        scale: Annotated[
            float | None, Query(gt=0.0, description="As in its upload; default 1.", allow_inf_nan=False)
        ] = None,
        up: Annotated[UpAxis | None, Query(description="As in its upload, `%2BZ` or `%2BY`.")] = None,
    ) -> Response:
        """List all meshes, oldest first; or the mesh that a file became, for whoever would upload it again.

        With `sha256` the list has one item, which is what an upload of that file with that `scale` and `up` would be
        answered; or none, where it was never uploaded so.
        """
        return await answer(services.reads, lambda: objects.list(limit, after, sha256, type, scale, up))

    @router.get("/{id}", response_model=Object, responses=problems(404, 422, 503))
    async def get_object(id: str) -> Response:
        """One mesh."""
        return await answer(services.reads, lambda: objects.get(id))

    @router.get("/{id}/stable-poses", response_model=StablePoses, responses=problems(404, 422, 503))
    async def get_stable_poses(id: str) -> Response:
        """List the ways in which the object rests on the table and withstands nine degrees of tilt in any direction."""
        return await answer(services.rests, lambda: objects.stable_poses(id))

    return router


def _check_fields(given: Sequence[str]) -> None:
    """Refuse form fields that there are not, and such as come twice."""
    for name in given:
        if name not in _FIELDS:
            raise InvalidRequest(f"body.{name}: no such field: expected one of {', '.join(_FIELDS)}")
        if given.count(name) > 1:
            raise InvalidRequest(f"body.{name}: expected once, got {given.count(name)} times")
