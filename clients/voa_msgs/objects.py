"""Meshes and how they rest."""

from datetime import datetime
from typing import Annotated

from pydantic import Base64Bytes, Field

from voa_msgs.base import Message, Name, Page, Point3, Positive, Quaternion


class ObjectUpload(Message):
    """A mesh file where there are no forms (Zenoh)."""

    filename: Name
    """Its ending says which type it is: obj, stl, ply or glb."""
    file: Annotated[Base64Bytes, Field(strict=False)]
    """The content, in base64."""
    name: Name | None = None
    """Null: the file's."""
    scale: Positive = 1.0
    """Metres per unit of the file."""


class Object(Message):
    """A stored mesh."""

    id: str
    """Digest of vertices and faces after scale."""
    name: str
    extents: Point3
    """Size of the bounding box in the mesh's own frame, metres."""
    faces: int
    watertight: bool
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
