"""Objects: upload a mesh, look at it, ask how it can rest."""

from dataclasses import dataclass, replace
from pathlib import PurePath

from voa_core.errors import VoaError
from voa_core.objects import Object as Mesh
from voa_core.stable_poses import propose_stable_poses
from voa_msgs.objects import Object, ObjectPage, StablePose, StablePoses, UpAxis
from voa_service.cache import Cache
from voa_service.failures import INVALID_MESH, TOO_LARGE, Failure, not_found
from voa_service.mapping import object_message
from voa_service.meshes.mistakes import default_up, extent_mistakes, up_mistakes
from voa_service.ports import Clock, MeshReader, Store, StoredObject
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
            raise Failure(TOO_LARGE, f"expected a file of at most {self.limits.upload_bytes} bytes")
        path = PurePath(filename)
        called = name or path.stem[:_LONGEST_NAME] or "object"
        mesh_type = path.suffix.lower().removeprefix(".")
        applied = up or default_up(mesh_type)
        mesh = self.read(content, mesh_type, scale, applied)
        there, new = self.store.put_object(StoredObject(mesh, called, self.now(), applied))
        answer = object_message(replace(there, up=applied))
        doubts = extent_mistakes(mesh, scale) + ([] if up else up_mistakes(mesh, applied))
        return answer.model_copy(update={"warnings": doubts}), new

    def get(self, id_: str) -> Object:
        """One mesh."""
        return object_message(self._stored(id_))

    def list(self, limit: int, after: str | None) -> ObjectPage:
        """All meshes, oldest first."""
        return ObjectPage(**page(self.store.list_objects, object_message, limit, after))

    def stable_poses(self, id_: str) -> StablePoses:
        """List how it can rest on the table, worked out once while the cache has room."""
        mesh = self._stored(id_).object
        return self.cache.get(("stable-poses", id_), lambda: _Proposal(_proposed(mesh))).poses

    def _stored(self, id_: str) -> StoredObject:
        stored = self.store.get_object(id_)
        if stored is None:
            raise not_found("object", id_)
        return stored


def _proposed(mesh: Mesh) -> StablePoses:
    try:
        proposed = propose_stable_poses(mesh)
    except VoaError as error:
        raise Failure(INVALID_MESH, str(error)) from error
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
