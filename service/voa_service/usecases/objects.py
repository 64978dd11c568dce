"""Objects: upload a mesh, look at it, ask how it can rest."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import PurePath

from voa_core.errors import VoaError
from voa_core.objects import Object as Mesh
from voa_core.stable_poses import propose_stable_poses
from voa_meshes import default_up
from voa_msgs.objects import MeshType, Object, ObjectPage, StablePose, StablePoses, UpAxis
from voa_service.failures import InvalidMesh, InvalidRequest, TooLarge, not_found
from voa_service.mapping.scenarios import listed_object_message, object_message
from voa_service.meshes.mistakes import extent_mistakes, up_mistakes
from voa_service.ports import Clock, MeshReader, Store, StoredObject, Upload
from voa_service.runtime.cache import Cache
from voa_service.settings import Limits
from voa_service.usecases.pages import page

_LONGEST_NAME = 128
_BYTES_PER_POSE = 1_024


@dataclass(frozen=True)
class _Proposal:
    """Stable poses as a `cache.Sized`."""

    poses: StablePoses

    @property
    def nbytes(self) -> int:
        """In bytes, roughly."""
        return _BYTES_PER_POSE * (1 + len(self.poses.items))


@dataclass(frozen=True)
class Objects:
    """Everything about meshes."""

    store: Store
    read: MeshReader
    cache: Cache
    now: Clock
    limits: Limits

    def create(
        self, content: bytes, filename: str, name: str | None, scale: float, up: UpAxis | None = None
    ) -> tuple[Object, bool]:
        """Store a mesh, called by its file's name if it has no other; and whether it is new."""
        if len(content) > self.limits.upload_bytes:
            raise TooLarge(f"expected a file of at most {self.limits.upload_bytes} bytes")
        path = PurePath(filename)
        called = name or path.stem[:_LONGEST_NAME] or "object"
        mesh_type = path.suffix.lower().removeprefix(".")
        upload = Upload(hashlib.sha256(content).hexdigest(), mesh_type, scale, up or default_up(mesh_type))
        mesh = self.read(content, mesh_type, scale, upload.up)
        there, new = self.store.put_object(StoredObject(mesh, called, self.now(), upload.up))
        self.store.put_upload(upload, there.object.digest)
        return _uploaded(there, upload, stated=up is not None), new

    def find(self, sha256: str, mesh_type: MeshType, scale: float, up: UpAxis | None) -> ObjectPage:
        """Find the mesh that a file became when it was uploaded, so that nobody needs to upload it again.

        Args:
            sha256: of the file's bytes.
            mesh_type: the ending of its name.
            scale: metres per unit of the file.
            up: the axis of the file that is up; None: that of its type.

        Returns:
            One mesh, with what its upload is answered and `sha256`; or none, where that was never uploaded.
        """
        upload = Upload(sha256, mesh_type, scale, up or default_up(mesh_type))
        there = self.store.find_upload(upload)
        if there is None:
            return ObjectPage(items=[], next=None)
        found = _uploaded(there, upload, stated=up is not None)
        return ObjectPage(items=[found.model_copy(update={"sha256": sha256})], next=None)

    def get(self, id_: str) -> Object:
        """One mesh."""
        return object_message(self._stored(id_))

    def list(
        self,
        limit: int,
        after: str | None,
        sha256: str | None = None,
        mesh_type: MeshType | None = None,
        scale: float | None = None,
        up: UpAxis | None = None,
    ) -> ObjectPage:
        """List all meshes, oldest first; or with `sha256` the one that a file became, as `find` does.

        Raises:
            Failure: `after` is not a cursor, or the file is half described.
        """
        if sha256 is None:
            if (mesh_type, scale, up) != (None, None, None):
                raise InvalidRequest("type, scale and up describe a mesh file: expected its sha256 beside them")
            return ObjectPage(**page(self.store.list_objects, listed_object_message, limit, after))
        if mesh_type is None or after is not None:
            raise InvalidRequest("sha256 asks for the mesh of one file: expected its type beside it, and no `after`")
        return self.find(sha256, mesh_type, 1.0 if scale is None else scale, up)

    def stable_poses(self, id_: str) -> StablePoses:
        """List how it can rest on the table, worked out once while the cache has room."""
        mesh = self._stored(id_).object
        return self.cache.get(("stable-poses", id_), lambda: _Proposal(_proposed(mesh))).poses

    def _stored(self, id_: str) -> StoredObject:
        stored = self.store.get_object(id_)
        if stored is None:
            raise not_found("object", id_)
        return stored


def _uploaded(there: StoredObject, upload: Upload, *, stated: bool) -> Object:
    """Answer an upload: the mesh that is there, and what is probably wrong with how the file was read.

    Args:
        there: the mesh.
        upload: the file, and how it was read.
        stated: whether the caller said which axis is up.
    """
    mesh = there.object
    doubts = extent_mistakes(mesh.extents.tolist(), upload.scale) + (
        [] if stated else up_mistakes(mesh.vertices, upload.up)
    )
    return object_message(replace(there, up=upload.up)).model_copy(update={"warnings": doubts})


def _proposed(mesh: Mesh) -> StablePoses:
    try:
        proposed = propose_stable_poses(mesh)
    except VoaError as error:
        raise InvalidMesh(str(error)) from error
    return StablePoses(
        items=[
            StablePose(
                position=list(pose.position),
                quaternion_wxyz=list(pose.quaternion_wxyz),
                probability=pose.probability,
            )
            for pose in proposed
        ]
    )
