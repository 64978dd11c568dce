"""Objects: uploaded meshes, and the poses in which they rest on a table."""

import base64
import binascii
from datetime import datetime
from typing import Annotated, Literal

from pydantic import EncodedBytes, EncoderProtocol, Field, StringConstraints
from pydantic_core import PydanticCustomError

from voa_msgs.base import Message, Name, Page, Point3, Positive, Quaternion
from voa_msgs.warnings import ProbableMistake


class _Base64(EncoderProtocol):
    """Base64 (RFC 4648) that refuses other characters instead of skipping them."""

    @classmethod
    def decode(cls, data: bytes) -> bytes:
        try:
            return base64.b64decode(data, validate=True)
        except binascii.Error as error:
            raise PydanticCustomError("base64", "expected base64: {why}", {"why": str(error)}) from error

    @classmethod
    def encode(cls, value: bytes) -> bytes:
        return base64.b64encode(value)

    @classmethod
    def get_json_format(cls) -> str:
        return "base64"


UpAxis = Literal["+Y", "+Z"]
"""Axis of a mesh file that points up; stored meshes have z up."""


MeshType = Literal["obj", "stl", "ply", "glb"]
"""Type of a mesh file: the ending of its name, in lower case."""

Sha256 = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]
"""SHA-256 digest in 64 lower-case hexadecimal digits."""


LEAST_FACES = 100
"""Smallest bound on the triangles of a mesh that is read; with fewer, no object could be recognised."""


class ObjectUpload(Message):
    """Upload of a mesh file in JSON, for Zenoh, which has no multipart forms."""

    filename: Name
    """Name of the file; its ending says the type: obj, stl, ply or glb."""
    file: Annotated[bytes, EncodedBytes(encoder=_Base64), Field(strict=False)]
    """Content of the file, in base64."""
    name: Name | None = None
    """Name of the object; null: the name of the file."""
    scale: Positive = 1.0
    """Metres per unit of the file."""
    up: UpAxis | None = None
    """Axis of the file that points up, which is turned to z; null: +Y for GLB, as its standard says, else +Z."""


class Object(Message):
    """Stored mesh of an object."""

    id: str
    """Identifier: a digest of the vertices and faces, scaled to metres and with z up."""
    name: str
    """Name that was given at the upload, else the name of the file."""
    extents: Point3
    """Size of the bounding box along x, y and z of the mesh's own frame, metres."""
    faces: int
    """Number of triangles."""
    watertight: bool
    """True if the triangles enclose a volume without holes."""
    up: UpAxis = "+Z"
    """Axis of the uploaded file that points up, and became z."""
    sha256: str | None = None
    """SHA-256 of the bytes of the uploaded file, in a list that was filtered by it; null everywhere else."""
    warnings: list[ProbableMistake] = Field(default=[])
    """Probable mistakes in the mesh, such as a size that suggests millimetres; empty: none."""
    created_at: datetime
    """Time of the first upload of this mesh, UTC."""


class ObjectPage(Page):
    """Page of the list of stored meshes."""

    items: list[Object]
    """Meshes, oldest first."""


class MeshFile(Message):
    """Stored mesh as a file of triangles."""

    id: str
    """Identifier of the object."""
    type: Literal["stl"]
    """Type of the file: binary STL, in metres, with z up."""
    faces: int
    """Number of triangles of the file; below the object's own where the request bounds it."""
    file: Annotated[bytes, EncodedBytes(encoder=_Base64), Field(strict=False)]
    """Content of the file, in base64."""


class StablePose(Message):
    """Stable pose: a way in which the object rests on the table."""

    position: Point3
    """Position of the object's frame, metres; the centre of mass is above the world's origin."""
    quaternion_wxyz: Quaternion
    """Orientation of the object's frame in the world, as a unit quaternion w, x, y, z."""
    probability: float
    """Estimated probability that the object, dropped at random, comes to rest in this way."""


class StablePoses(Message):
    """Stable poses of an object on a table."""

    items: list[StablePose]
    """Physically distinct stable poses, the most probable first."""
