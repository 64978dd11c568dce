"""GLB: the triangles of a glTF 2.0 scene, in one file."""

import struct
from collections.abc import Iterator

import numpy as np

from voa_meshes.gltf import DRACO, INSTANCING, VISIBILITY, Document, Mesh, Node, Primitive, named, read_document
from voa_meshes.gltf_buffers import Buffers, item
from voa_meshes.triangles import Floats, Indices, Triangles, UnreadableMesh

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_HEADER = struct.Struct("<4sII")
_CHUNK = struct.Struct("<II")
_MODES = {0: "points", 1: "lines", 2: "line loops", 3: "line strips"}


def read_glb(content: bytes) -> Triangles:
    """Read the meshes of a GLB file's scene, where its nodes put them; axes stay the file's.

    Raises:
        UnreadableMesh: the file is not glTF 2.0, not whole, or uses an extension that this reader does not support.
    """
    text, binary = _chunks(content)
    document = read_document(text)
    buffers = Buffers(document, binary)
    vertices, faces, known = [], [], 0
    shapes: dict[tuple[int, tuple[float, ...]], Triangles] = {}
    for node, matrix in _placed(document, buffers):
        assert node.mesh is not None  # noqa: S101 - those without are not placed
        mesh = item(document.meshes, node.mesh, "mesh")
        weights = tuple(mesh.weights if node.weights is None else node.weights)
        if (node.mesh, weights) not in shapes:
            shapes[node.mesh, weights] = _shape(mesh, weights, buffers)
        shape = shapes[node.mesh, weights]
        vertices.append(shape.vertices @ matrix[:3, :3].T + matrix[:3, 3])
        mirrored = np.linalg.det(matrix[:3, :3]) < 0.0
        faces.append((shape.faces[:, ::-1] if mirrored else shape.faces) + known)
        known += len(shape.vertices)
    if not faces:
        raise UnreadableMesh("its scene has no mesh")
    return Triangles(np.concatenate(vertices), np.concatenate(faces))


def _chunks(content: bytes) -> tuple[bytes, bytes | None]:
    """Split a GLB file into its JSON document and its binary buffer, if it has one."""
    if len(content) < _HEADER.size:
        raise UnreadableMesh("expected the header of a GLB file")
    magic, version, length = _HEADER.unpack_from(content)
    if magic != b"glTF":
        raise UnreadableMesh(
            "expected a file that begins with 'glTF' (a .gltf file, with its buffers in other files, is not GLB)"
        )
    if version != 2:
        raise UnreadableMesh(f"expected glTF 2, got version {version}")
    if length > len(content):
        raise UnreadableMesh(f"the header says {length} bytes, the file has {len(content)}: is it cut off?")
    chunks: list[tuple[int, bytes]] = []
    at = _HEADER.size
    while at + _CHUNK.size <= length:
        size, kind = _CHUNK.unpack_from(content, at)
        at += _CHUNK.size
        if at + size > length:
            raise UnreadableMesh(f"a chunk claims {size} bytes, only {length - at} are left: is the file cut off?")
        chunks.append((kind, content[at : at + size]))
        at += size
    if not chunks or chunks[0][0] != _JSON:
        raise UnreadableMesh("expected a chunk of JSON first")
    return chunks[0][1], next((data for kind, data in chunks[1:2] if kind == _BIN), None)


def _placed(document: Document, buffers: Buffers) -> Iterator[tuple[Node, Floats]]:
    """Yield the nodes of the scene that have a mesh, each with its matrix (4, 4) to the scene; once per instance."""
    if document.scene is None and len(document.scenes) != 1:
        raise UnreadableMesh(
            f"it has {len(document.scenes)} scenes and does not say which of them to show: export one scene"
        )
    roots = item(document.scenes, document.scene or 0, "scene").nodes
    waiting = [(index, np.eye(4)) for index in reversed(roots)]
    seen: set[int] = set()
    while waiting:
        index, parent = waiting.pop()
        if index in seen:
            raise UnreadableMesh(f"node {index} is a child of two nodes, or of itself")
        seen.add(index)
        node = item(document.nodes, index, "node")
        if node.extensions.get(VISIBILITY, {}) == {"visible": False}:
            continue
        matrix = parent @ _matrix(node, index)
        if node.mesh is not None:
            if node.skin is not None:
                raise UnreadableMesh(f"a skin (node {index}) is not supported: export the mesh without its bones")
            for instance in _instances(node, index, buffers):
                yield node, matrix @ instance
        waiting += [(child, matrix) for child in reversed(node.children)]


def _matrix(node: Node, index: int) -> Floats:
    """Return the transform (4, 4) from a node's frame to its parent's."""
    if node.matrix is None:
        own = np.array([node.translation]), np.array([node.rotation]), np.array([node.scale])
        return _transforms(*own, index).reshape(4, 4)
    matrix = np.array(node.matrix, dtype=np.float64).reshape(4, 4).T
    if not np.allclose(matrix[3], [0.0, 0.0, 0.0, 1.0], rtol=0.0, atol=1e-6):
        raise UnreadableMesh(f"node {index}: expected 0, 0, 0, 1 in the last row of its matrix")
    return matrix


def _instances(node: Node, index: int, buffers: Buffers) -> Floats:
    """Return the transforms (n, 4, 4) of the copies of a node's mesh; the identity alone where it is not instanced."""
    if INSTANCING not in node.extensions:
        return np.eye(4)[None]
    extension = node.extensions[INSTANCING]
    attributes = extension.get("attributes") if isinstance(extension, dict) else None
    kinds = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}
    if not isinstance(attributes, dict) or not all(type(each) is int and each >= 0 for each in attributes.values()):
        raise UnreadableMesh(f"node {index}: expected attributes of {INSTANCING}")
    given = {name: buffers.vectors(attributes[name], kinds[name]) for name in kinds if name in attributes}
    counts = {len(values) for values in given.values()}
    if len(counts) != 1:
        raise UnreadableMesh(f"node {index}: expected as many values in each attribute of {INSTANCING}")
    count = counts.pop()
    usual = {"TRANSLATION": [0.0, 0.0, 0.0], "ROTATION": [0.0, 0.0, 0.0, 1.0], "SCALE": [1.0, 1.0, 1.0]}
    placed = [given.get(name, np.tile(usual[name], (count, 1))) for name in kinds]
    return _transforms(placed[0], placed[1], placed[2], index)


def _transforms(translations: Floats, rotations: Floats, scales: Floats, index: int) -> Floats:
    """Make matrices (n, 4, 4) from translations (n, 3), quaternions x, y, z, w (n, 4) and scales (n, 3)."""
    lengths = np.linalg.norm(rotations, axis=1)
    if not (np.abs(lengths - 1.0) < 0.05).all():
        raise UnreadableMesh(f"node {index}: expected a quaternion of length 1 for its rotation")
    x, y, z, w = (rotations / lengths[:, None]).T
    turned = np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
    matrices = np.tile(np.eye(4), (len(translations), 1, 1))
    matrices[:, :3, :3] = turned.transpose(2, 0, 1) * scales[:, None, :]
    matrices[:, :3, 3] = translations
    return matrices


def _shape(mesh: Mesh, weights: tuple[float, ...], buffers: Buffers) -> Triangles:
    """Join the primitives of a mesh in its own frame, with its morph targets added by their weights."""
    vertices, faces, known = [], [], 0
    for primitive in mesh.primitives:
        points = _points(primitive, weights, buffers)
        faces.append(_triangles(primitive, len(points), buffers) + known)
        vertices.append(points)
        known += len(points)
    if not faces:
        raise UnreadableMesh("a mesh has no primitives")
    return Triangles(np.concatenate(vertices), np.concatenate(faces))


def _points(primitive: Primitive, weights: tuple[float, ...], buffers: Buffers) -> Floats:
    if "POSITION" not in primitive.attributes:
        raise UnreadableMesh("a primitive has no POSITION")
    index = primitive.attributes["POSITION"]
    accessor = item(buffers.document.accessors, index, "accessor")
    if DRACO in primitive.extensions and accessor.buffer_view is None:
        raise UnreadableMesh(f"{named(DRACO)} is not supported: export the mesh without it")
    points = buffers.vectors(index, "VEC3")
    if primitive.targets and weights and len(weights) != len(primitive.targets):
        raise UnreadableMesh(f"a mesh has {len(weights)} weights for {len(primitive.targets)} morph targets")
    for target, weight in zip(primitive.targets, weights, strict=False):
        if weight != 0.0 and "POSITION" in target:
            moved = buffers.vectors(target["POSITION"], "VEC3")
            if len(moved) != len(points):
                raise UnreadableMesh(f"a morph target has {len(moved)} vertices, its mesh {len(points)}")
            points = points + weight * moved
    return points


def _triangles(primitive: Primitive, vertices: int, buffers: Buffers) -> Indices:
    """Return the triangles (f, 3) of a primitive that is a list, a strip or a fan of triangles."""
    if primitive.mode in _MODES:
        raise UnreadableMesh(
            f"{_MODES[primitive.mode]} (mode {primitive.mode}) are not a surface: export triangles alone"
        )
    corners = np.arange(vertices) if primitive.indices is None else buffers.indices(primitive.indices)
    if len(corners) and corners.max() >= vertices:
        raise UnreadableMesh(f"a primitive refers to vertex {corners.max()}, of vertices 0 to {vertices - 1}")
    if primitive.mode == 4:
        if len(corners) % 3:
            raise UnreadableMesh(f"expected 3 corners for each triangle, got {len(corners)}")
        return corners.reshape(-1, 3)
    ahead = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    if primitive.mode == 5:
        ahead[1::2] = ahead[1::2][:, [1, 0, 2]]
        return ahead
    if primitive.mode == 6:
        ahead[:, 0] = corners[:1]
        return ahead
    raise UnreadableMesh(f"glTF has no mode {primitive.mode}")
