"""Objects: upload, read and list meshes, write them as files, and propose the poses in which they can rest."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import PurePath

from voa_meshes import default_up
from voa_msgs.objects import MeshFile, MeshType, Object, ObjectPage, StablePoses, UpAxis
from voa_service.failures import InvalidRequest, TooLarge, not_found
from voa_service.mapping.objects import listed_object_message, mesh_file, object_message, stable_poses_message
from voa_service.meshes.mistakes import extent_mistakes, up_mistakes
from voa_service.ports import Clock, MeshReader, Store
from voa_service.runtime.cache import Cache
from voa_service.settings import Limits
from voa_service.usecases.pages import page
from voa_store.records import StoredObject, Upload

_LONGEST_NAME = 128
_BYTES_PER_POSE = 1_024


@dataclass(frozen=True)
class _Proposal:
    """Stable poses as an entry of the cache."""

    poses: StablePoses

    @property
    def nbytes(self) -> int:
        """Approximate size in bytes."""
        return _BYTES_PER_POSE * (1 + len(self.poses.items))


@dataclass(frozen=True)
class _Thinned:
    """Thinned mesh as an entry of the cache."""

    mesh: MeshFile

    @property
    def nbytes(self) -> int:
        """Size in bytes."""
        return len(self.mesh.file)


@dataclass(frozen=True)
class Objects:
    """Use cases about objects.

    Attributes:
        store: where meshes are kept.
        read: reads an untrusted mesh file.
        cache: keeps stable poses.
        now: clock.
        limits: of requests.
    """

    store: Store
    read: MeshReader
    cache: Cache
    now: Clock
    limits: Limits

    def create(
        self, content: bytes, filename: str, name: str | None, scale: float, up: UpAxis | None = None
    ) -> tuple[Object, bool]:
        """Store a mesh; True if it is new.

        Args:
            content: of the mesh file.
            filename: its ending is the type of the file; it names the object where `name` is None.
            name: of the object.
            scale: metres per unit of the file.
            up: axis of the file that becomes z; None: the usual one of its type.

        Raises:
            Failure: the file is too large, or not a usable mesh.
        """
        if len(content) > self.limits.upload_bytes:
            raise TooLarge(f"expected a file of at most {self.limits.upload_bytes} bytes, got {len(content)}")
        path = PurePath(filename)
        object_name = name or path.stem[:_LONGEST_NAME] or "object"
        mesh_type = path.suffix.lower().removeprefix(".")
        upload = Upload(hashlib.sha256(content).hexdigest(), mesh_type, scale, up or default_up(mesh_type))
        mesh = self.read(content, mesh_type, scale, upload.up)
        stored, new = self.store.put_object(StoredObject(mesh, object_name, self.now(), upload.up))
        self.store.put_upload(upload, stored.object.digest)
        return _uploaded(stored, upload, stated=up is not None), new

    def find(self, sha256: str, mesh_type: MeshType, scale: float, up: UpAxis | None) -> ObjectPage:
        """Find the mesh that a file became when it was uploaded, so that it need not be uploaded again.

        Args:
            sha256: of the file's bytes.
            mesh_type: ending of its name.
            scale: metres per unit of the file.
            up: axis of the file that is up; None: the usual one of its type.

        Returns:
            One mesh, equal to the response to its upload, with `sha256`; or none, if the file was never uploaded.
        """
        upload = Upload(sha256, mesh_type, scale, up or default_up(mesh_type))
        stored = self.store.find_upload(upload)
        if stored is None:
            return ObjectPage(items=[], next=None)
        uploaded = _uploaded(stored, upload, stated=up is not None)
        return ObjectPage(items=[uploaded.model_copy(update={"sha256": sha256})], next=None)

    def get(self, id_: str) -> Object:
        """Read an object.

        Raises:
            NotFound: there is no such object.
        """
        return object_message(self._stored(id_))

    def delete(self, id_: str) -> None:
        """Delete an object that no scenario needs.

        Raises:
            NotFound: there is no such object.
            InUse: a scenario needs it.
        """
        if not self.store.delete_object(id_):
            raise not_found("object", id_)

    def list(
        self,
        limit: int,
        after: str | None,
        sha256: str | None = None,
        mesh_type: MeshType | None = None,
        scale: float | None = None,
        up: UpAxis | None = None,
    ) -> ObjectPage:
        """List objects, oldest first, in pages; or, given the `sha256` of a file, find its mesh as `find` does.

        Raises:
            InvalidRequest: `after` is not a cursor, or the description of the file is incomplete.
        """
        if sha256 is None:
            if (mesh_type, scale, up) != (None, None, None):
                raise InvalidRequest("type, scale and up describe a mesh file: expected its sha256 beside them")
            return ObjectPage(**page(self.store.list_objects, listed_object_message, limit, after))
        if mesh_type is None or after is not None:
            raise InvalidRequest("sha256 selects the mesh of one file: expected its type beside it, and no `after`")
        return self.find(sha256, mesh_type, 1.0 if scale is None else scale, up)

    def mesh(self, id_: str, most_faces: int | None = None) -> MeshFile:
        """Read the mesh of an object as an STL file; thinned meshes are computed once and kept.

        Args:
            id_: of the object.
            most_faces: bound on the triangles, to which the mesh is thinned; None: every triangle.

        Raises:
            NotFound: there is no such object.
        """
        mesh = self._stored(id_).object
        if most_faces is None or len(mesh.faces) <= most_faces:
            return mesh_file(mesh, None)
        return self.cache.get(("mesh", id_, most_faces), lambda: _Thinned(mesh_file(mesh, most_faces))).mesh

    def stable_poses(self, id_: str) -> StablePoses:
        """List the poses in which an object can rest on the table; they are computed once and kept.

        Raises:
            NotFound: there is no such object.
            InvalidMesh: the mesh cannot rest.
        """
        mesh = self._stored(id_).object
        return self.cache.get(("stable-poses", id_), lambda: _Proposal(stable_poses_message(mesh))).poses

    def _stored(self, id_: str) -> StoredObject:
        stored = self.store.get_object(id_)
        if stored is None:
            raise not_found("object", id_)
        return stored


def _uploaded(stored: StoredObject, upload: Upload, *, stated: bool) -> Object:
    """Build the response to an upload: the mesh, with warnings about probable mistakes in how the file was read.

    Args:
        stored: the mesh.
        upload: the file and its options.
        stated: True if the caller stated which axis is up.
    """
    mesh = stored.object
    warnings = extent_mistakes(mesh.extents.tolist(), upload.scale) + (
        [] if stated else up_mistakes(mesh.vertices, upload.up)
    )
    return object_message(replace(stored, up=upload.up)).model_copy(update={"warnings": warnings})
