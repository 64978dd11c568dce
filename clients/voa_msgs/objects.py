"""Meshes and how they rest."""

import base64
import binascii
from datetime import datetime
from typing import Annotated, Literal

from pydantic import EncodedBytes, EncoderProtocol, Field, StringConstraints
from pydantic_core import PydanticCustomError

from voa_msgs.base import Message, Name, Page, Point3, Positive, Quaternion
from voa_msgs.warnings import ProbableMistake


class _Base64(EncoderProtocol):
    """Base64 (RFC 4648); what is none is refused, not skipped."""

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
"""The axis of a mesh file that points up; stored meshes have z up."""


MeshType = Literal["obj", "stl", "ply", "glb"]
"""The ending of a mesh file's name, in lower case."""

Sha256 = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]
"""A digest in lower-case hexadecimal digits."""


class ObjectUpload(Message):
    """A mesh file where there are no forms (Zenoh)."""

    filename: Name
    """Its ending says which type it is: obj, stl, ply or glb."""
    file: Annotated[bytes, EncodedBytes(encoder=_Base64), Field(strict=False)]
    """The content, in base64."""
    name: Name | None = None
    """Null: the file's."""
    scale: Positive = 1.0
    """Metres per unit of the file."""
    up: UpAxis | None = None
    """Null: +Y for GLB, as its standard says, and +Z for the others. +Y is turned to z."""


class Object(Message):
    """A stored mesh."""

    id: str
    """Digest of vertices and faces after scale, with z up."""
    name: str
    extents: Point3
    """Size of the bounding box in the mesh's own frame, metres."""
    faces: int
    watertight: bool
    up: UpAxis = "+Z"
    """The axis of the uploaded file that became z."""
    sha256: str | None = None
    """Digest of the uploaded file's bytes, where a list was asked for the mesh of that file; null everywhere else."""
    warnings: list[ProbableMistake] = Field(default=[])
    created_at: datetime


class ObjectPage(Page):
    """Stored meshes, oldest first."""

    items: list[Object]


class StablePose(Message):
    """One way in which the object can rest on the table."""

    position: Point3
    """Of the object's frame, metres; the centre of mass is above the world's origin."""
    quaternion_wxyz: Quaternion
    probability: float


class StablePoses(Message):
    """The physically distinct ways to rest, most probable first."""

    items: list[StablePose]
