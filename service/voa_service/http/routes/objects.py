"""Routes /v1/objects: meshes of objects, and their stable poses."""

from collections.abc import Sequence
from typing import Annotated

from annotated_types import Gt
from fastapi import APIRouter, File, Form, Query, Request, Response, UploadFile

from voa_msgs.base import Name
from voa_msgs.objects import LEAST_FACES, MeshFile, MeshType, Object, ObjectPage, Sha256, StablePoses, UpAxis
from voa_service.failures import InUse, InvalidMesh, InvalidRequest, NotFound, UnsupportedMeshType
from voa_service.http.calls import strict_route
from voa_service.http.openapi import problems
from voa_service.http.routes.responses import DEFAULT_PAGE, After, ObjectId, PageLimit, answer, created
from voa_service.services import Services

STL = "model/stl"
"""Media type of STL files."""
MostFaces = Annotated[
    int | None, Query(ge=LEAST_FACES, description="Bound on the triangles, to which the mesh is thinned.")
]
_FIELDS = ("file", "name", "scale", "up")


def routes(services: Services) -> APIRouter:
    """Make the routes that store and read meshes."""
    router = APIRouter(prefix="/v1/objects", tags=["objects"], route_class=strict_route(services.reader))
    objects = services.objects

    @router.post(
        "",
        status_code=201,
        response_model=Object,
        responses={
            200: {"model": Object, "description": "The same mesh was stored before."},
            **problems(UnsupportedMeshType, InvalidMesh),
        },
        response_description="The mesh was stored.",
    )
    async def create_object(
        request: Request,
        file: Annotated[UploadFile, File(description="Mesh file, whose name ends with .obj, .stl, .ply or .glb.")],
        name: Annotated[Name | None, Form(description="Name of the object; default: the name of the file.")] = None,
        scale: Annotated[
            float, Gt(0.0), Form(description="Metres per unit of the file: 0.001 for millimetres.", allow_inf_nan=False)
        ] = 1.0,
        up: Annotated[
            UpAxis | None,
            Form(description="Axis of the file that points up, which is turned to z; default: +Y for GLB, else +Z."),
        ] = None,
    ) -> Response:
        """Store the mesh of an object.

        The file is OBJ, STL, PLY or GLB, as the ending of its name says. The identifier is a digest of the mesh: the
        same mesh again gives the same identifier and status 200.
        """
        _check_fields([name for name, _ in (await request.form()).multi_items()])
        content = await file.read()
        filename = file.filename or ""
        return await created(services.meshes, lambda: objects.create(content, filename, name, scale, up))

    @router.get("", response_model=ObjectPage, response_description="A page of meshes, oldest first.")
    async def list_objects(
        limit: PageLimit = DEFAULT_PAGE,
        after: After = None,
        sha256: Annotated[
            Sha256 | None, Query(description="SHA-256 of the bytes of a mesh file: list only the mesh of that file.")
        ] = None,
        type: Annotated[MeshType | None, Query(description="Type of that file; required with `sha256`.")] = None,
        scale: Annotated[
            float | None,
            Query(
                gt=0.0, description="Metres per unit, as in the upload of that file; default: 1.", allow_inf_nan=False
            ),
        ] = None,
        up: Annotated[UpAxis | None, Query(description="Axis that points up, as in the upload of that file.")] = None,
    ) -> Response:
        """List the stored meshes, oldest first.

        With `sha256`, the list has the mesh that an upload of that file with the same `scale` and `up` produced, or no
        item where there was no such upload: a client can thereby avoid uploading a large file again. In a URL the `+`
        of `up` is written `%2B`.
        """
        return await answer(services.reads, lambda: objects.list(limit, after, sha256, type, scale, up))

    @router.get("/{id}", response_model=Object, responses=problems(NotFound), response_description="The mesh.")
    async def get_object(id: ObjectId) -> Response:
        """Read the description of a stored mesh."""
        return await answer(services.reads, lambda: objects.get(id))

    @router.delete(
        "/{id}",
        status_code=204,
        responses=problems(NotFound, InUse),
        response_description="The mesh was deleted.",
    )
    async def delete_object(id: ObjectId) -> Response:
        """Delete a mesh that no scenario needs."""
        await services.writes.run(lambda: objects.delete(id))
        return Response(status_code=204)

    @router.get(
        "/{id}/mesh",
        response_model=MeshFile,
        responses=problems(NotFound),
        response_description="The mesh, as a file in base64.",
    )
    async def get_mesh(id: ObjectId, most_faces: MostFaces = None) -> Response:
        """Read the mesh of an object as a binary STL file, in metres and with z up.

        `most_faces` thins the mesh for a picture: the result may have gaps.
        """
        return await answer(services.rests, lambda: objects.mesh(id, most_faces))

    @router.get(
        "/{id}/mesh.stl",
        response_class=Response,
        responses={200: {"content": {STL: {}}}, **problems(NotFound)},
        response_description="The mesh, as a binary STL file.",
    )
    async def get_mesh_file(id: ObjectId, most_faces: MostFaces = None) -> Response:
        """Read the file of `/v1/objects/{id}/mesh` itself, for programs that load a mesh by its address."""
        mesh = await services.rests.run(lambda: objects.mesh(id, most_faces))
        return Response(mesh.file, media_type=STL)

    @router.get(
        "/{id}/stable-poses",
        response_model=StablePoses,
        responses=problems(NotFound, InvalidMesh),
        response_description="The stable poses, the most probable first.",
    )
    async def get_stable_poses(id: ObjectId) -> Response:
        """Compute the poses in which an object rests on a table.

        Listed are the poses that withstand a tilt of nine degrees in any direction.
        """
        return await answer(services.rests, lambda: objects.stable_poses(id))

    return router


def _check_fields(given: Sequence[str]) -> None:
    """Refuse unknown form fields, and fields that are given twice."""
    for name in given:
        if name not in _FIELDS:
            raise InvalidRequest(f"body.{name}: no such field: expected one of {', '.join(_FIELDS)}")
        if given.count(name) > 1:
            raise InvalidRequest(f"body.{name}: expected once, got {given.count(name)} times")
