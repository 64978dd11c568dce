"""The part of a glTF 2.0 document that defines triangles; materials, textures, cameras and animations are ignored."""

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.alias_generators import to_camel

from voa_meshes.triangles import UnreadableMesh

Count = Annotated[int, Field(strict=True, ge=0)]
Index = Count
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]


class _Part(BaseModel):
    model_config = ConfigDict(alias_generator=to_camel, extra="ignore", frozen=True)

    extensions: dict[str, Any] = {}


class Asset(_Part):
    """The version of glTF that a file is written in."""

    version: str
    min_version: str | None = None


class Buffer(_Part):
    """A buffer of bytes: at a URI, or in the file itself where it has none."""

    byte_length: Count
    uri: str | None = None


class BufferView(_Part):
    """A part of a buffer, in bytes."""

    buffer: Index
    byte_offset: Count = 0
    byte_length: Count
    byte_stride: Count | None = None


class SparseIndices(_Part):
    """Indices of the elements of a sparse accessor that differ from its buffer view's."""

    buffer_view: Index
    byte_offset: Count = 0
    component_type: int


class SparseValues(_Part):
    """Values of the elements of a sparse accessor that differ from its buffer view's."""

    buffer_view: Index
    byte_offset: Count = 0


class Sparse(_Part):
    """The sparse part of an accessor: elements that differ from its buffer view's."""

    count: Count
    indices: SparseIndices
    values: SparseValues


class Accessor(_Part):
    """An accessor: numbers in a buffer view; without a view all are 0."""

    buffer_view: Index | None = None
    byte_offset: Count = 0
    component_type: int
    normalized: bool = False
    count: Count
    type: str
    sparse: Sparse | None = None


class Primitive(_Part):
    """A primitive: triangles, or points or lines, over the positions of vertices."""

    attributes: dict[str, Index]
    indices: Index | None = None
    mode: int = 4
    targets: list[dict[str, Index]] = []


class Mesh(_Part):
    """A mesh: primitives, and how much of each morph target is added to them."""

    primitives: list[Primitive]
    weights: list[Number] = []


class Node(_Part):
    """A node of a scene: a frame relative to its parent's, and the mesh in it."""

    children: list[Index] = []
    mesh: Index | None = None
    skin: Index | None = None
    matrix: Annotated[list[Number], Field(min_length=16, max_length=16)] | None = None
    translation: Annotated[list[Number], Field(min_length=3, max_length=3)] = [0.0, 0.0, 0.0]
    rotation: Annotated[list[Number], Field(min_length=4, max_length=4)] = [0.0, 0.0, 0.0, 1.0]
    scale: Annotated[list[Number], Field(min_length=3, max_length=3)] = [1.0, 1.0, 1.0]
    weights: list[Number] | None = None


class Scene(_Part):
    """A scene: the nodes at its root."""

    nodes: list[Index] = []


class Document(_Part):
    """The document of a glTF file."""

    asset: Asset
    extensions_required: list[str] = []
    buffers: list[Buffer] = []
    buffer_views: list[BufferView] = []
    accessors: list[Accessor] = []
    meshes: list[Mesh] = []
    nodes: list[Node] = []
    scenes: list[Scene] = []
    scene: Index | None = None


_NAMES = {
    "KHR_draco_mesh_compression": "Draco compression",
    "EXT_meshopt_compression": "meshopt compression",
    "KHR_meshopt_compression": "meshopt compression",
}
DRACO, MESHOPT = "KHR_draco_mesh_compression", ("EXT_meshopt_compression", "KHR_meshopt_compression")
INSTANCING, VISIBILITY = "EXT_mesh_gpu_instancing", "KHR_node_visibility"
_SUPPORTED = (INSTANCING, VISIBILITY, "KHR_mesh_quantization")
_APPEARANCE = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp")
"""Prefixes of the names of extensions that do not change the shape of a mesh."""


def named(extension: str) -> str:
    """Return the name of an extension for a message."""
    return f"{_NAMES[extension]} ({extension})" if extension in _NAMES else f"the glTF extension {extension[:80]!a}"


def read_document(text: bytes) -> Document:
    """Read a glTF document, and refuse required extensions that this package does not support.

    Raises:
        UnreadableMesh: the document is not glTF 2.0, or requires an extension that would change the shape.
    """
    try:
        document = Document.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(step) for step in first["loc"])[:80]
        raise UnreadableMesh(
            f"its glTF document is not as expected: {where}: {first['msg']}".replace("\n", " ")
        ) from error
    versions = {document.asset.version, document.asset.min_version or document.asset.version}
    if any(not version.startswith("2.") for version in versions) or document.asset.min_version not in (None, "2.0"):
        raise UnreadableMesh(f"expected glTF 2.0, got {', '.join(sorted(versions))[:40]!a}")
    for extension in document.extensions_required:
        if extension not in _SUPPORTED and not extension.startswith(_APPEARANCE):
            raise UnreadableMesh(f"{named(extension)} is not supported: export the mesh without it")
    return document
