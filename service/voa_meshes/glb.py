"""GLB: the triangles of a glTF 2.0 scene, in one file."""

import struct
from collections.abc import Iterator

import numpy as np

from voa_meshes.gltf import DRACO, INSTANCING, VISIBILITY, Document, Mesh, Node, Primitive, named, read_document
from voa_meshes.gltf_buffers import Buffers, item
from voa_meshes.triangles import Floats, Indices, Triangles, Unreadable

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_HEADER = struct.Struct("<4sII")
_CHUNK = struct.Struct("<II")
_MODES = {0: "points", 1: "lines", 2: "line loops", 3: "line strips"}


def read_glb(content: bytes) -> Triangles:
    """Read the meshes of a GLB file's scene, where its nodes put them; axes stay the file's.

    Raises:
        Unreadable: the file is not glTF 2.0, not whole, or has something whose shape is not known here.
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
        raise Unreadable("its scene has no mesh")
    return Triangles(np.concatenate(vertices), np.concatenate(faces))


def _chunks(content: bytes) -> tuple[bytes, bytes | None]:
    """The document and the binary buffer."""
    if len(content) < _HEADER.size:
        raise Unreadable("expected the header of a GLB file")
    magic, version, length = _HEADER.unpack_from(content)
    if magic != b"glTF":
        raise Unreadable("expected a file that begins with 'glTF' (a .gltf file with others beside it is none)")
    if version != 2:
        raise Unreadable(f"expected glTF 2, got version {version}")
    if length > len(content):
        raise Unreadable(f"the header says {length} bytes, the file has {len(content)}: is it cut off?")
    found: list[tuple[int, bytes]] = []
    at = _HEADER.size
    while at + _CHUNK.size <= length:
        size, kind = _CHUNK.unpack_from(content, at)
        at += _CHUNK.size
        if at + size > length:
            raise Unreadable(f"a chunk says {size} bytes, the file has {length - at}: is it cut off?")
        found.append((kind, content[at : at + size]))
        at += size
    if not found or found[0][0] != _JSON:
        raise Unreadable("expected a chunk of JSON first")
    return found[0][1], next((data for kind, data in found[1:2] if kind == _BIN), None)


def _placed(document: Document, buffers: Buffers) -> Iterator[tuple[Node, Floats]]:
    """The nodes of the scene with a mesh, and where they are; one per instance."""
    if document.scene is None and len(document.scenes) != 1:
        raise Unreadable(f"it has {len(document.scenes)} scenes and does not say which is meant")
    roots = item(document.scenes, document.scene or 0, "scene").nodes
    waiting = [(index, np.eye(4)) for index in reversed(roots)]
    seen: set[int] = set()
    while waiting:
        index, parent = waiting.pop()
        if index in seen:
            raise Unreadable(f"node {index} is below two nodes, or below itself")
        seen.add(index)
        node = item(document.nodes, index, "node")
        if node.extensions.get(VISIBILITY, {}) == {"visible": False}:
            continue
        matrix = parent @ _matrix(node, index)
        if node.mesh is not None:
            if node.skin is not None:
                raise Unreadable(f"a skin (node {index}) is not supported: export the mesh without its bones")
            for instance in _instances(node, index, buffers):
                yield node, matrix @ instance
        waiting += [(child, matrix) for child in reversed(node.children)]


def _matrix(node: Node, index: int) -> Floats:
    """Where a node is in its parent's frame, (4, 4)."""
    if node.matrix is None:
        own = np.array([node.translation]), np.array([node.rotation]), np.array([node.scale])
        return _transforms(*own, index).reshape(4, 4)
    matrix = np.array(node.matrix, dtype=np.float64).reshape(4, 4).T
    if not np.allclose(matrix[3], [0.0, 0.0, 0.0, 1.0], rtol=0.0, atol=1e-6):
        raise Unreadable(f"node {index}: expected 0, 0, 0, 1 in the last row of its matrix")
    return matrix


def _instances(node: Node, index: int, buffers: Buffers) -> Floats:
    """Where the copies of a node's mesh are in its frame, (n, 4, 4); one at its origin unless it says so."""
    if INSTANCING not in node.extensions:
        return np.eye(4)[None]
    said = node.extensions[INSTANCING]
    attributes = said.get("attributes") if isinstance(said, dict) else None
    kinds = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}
    if not isinstance(attributes, dict) or not all(type(each) is int and each >= 0 for each in attributes.values()):
        raise Unreadable(f"node {index}: expected attributes of {INSTANCING}")
    given = {name: buffers.vectors(attributes[name], kinds[name]) for name in kinds if name in attributes}
    counts = {len(values) for values in given.values()}
    if len(counts) != 1:
        raise Unreadable(f"node {index}: expected as many values in each attribute of {INSTANCING}")
    count = counts.pop()
    usual = {"TRANSLATION": [0.0, 0.0, 0.0], "ROTATION": [0.0, 0.0, 0.0, 1.0], "SCALE": [1.0, 1.0, 1.0]}
    placed = [given.get(name, np.tile(usual[name], (count, 1))) for name in kinds]
    return _transforms(placed[0], placed[1], placed[2], index)


def _transforms(translations: Floats, rotations: Floats, scales: Floats, index: int) -> Floats:
    """Matrices (n, 4, 4) from translations (n, 3), quaternions x, y, z, w (n, 4) and scales (n, 3)."""
    lengths = np.linalg.norm(rotations, axis=1)
    if not (np.abs(lengths - 1.0) < 0.05).all():
        raise Unreadable(f"node {index}: expected a quaternion of length 1 for its rotation")
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
    """A mesh in its own frame, its morph targets added as far as the weights say."""
    vertices, faces, known = [], [], 0
    for primitive in mesh.primitives:
        points = _points(primitive, weights, buffers)
        faces.append(_triangles(primitive, len(points), buffers) + known)
        vertices.append(points)
        known += len(points)
    if not faces:
        raise Unreadable("a mesh has no primitives")
    return Triangles(np.concatenate(vertices), np.concatenate(faces))


def _points(primitive: Primitive, weights: tuple[float, ...], buffers: Buffers) -> Floats:
    if "POSITION" not in primitive.attributes:
        raise Unreadable("a primitive has no POSITION")
    index = primitive.attributes["POSITION"]
    accessor = item(buffers.document.accessors, index, "accessor")
    if DRACO in primitive.extensions and accessor.buffer_view is None:
        raise Unreadable(f"{named(DRACO)} is not supported: export the mesh without it")
    points = buffers.vectors(index, "VEC3")
    if primitive.targets and weights and len(weights) != len(primitive.targets):
        raise Unreadable(f"a mesh has {len(weights)} weights for {len(primitive.targets)} morph targets")
    for target, weight in zip(primitive.targets, weights, strict=False):
        if weight != 0.0 and "POSITION" in target:
            moved = buffers.vectors(target["POSITION"], "VEC3")
            if len(moved) != len(points):
                raise Unreadable(f"a morph target has {len(moved)} vertices, its mesh {len(points)}")
            points = points + weight * moved
    return points


def _triangles(primitive: Primitive, vertices: int, buffers: Buffers) -> Indices:
    """The triangles of a primitive, of a list, a strip or a fan."""
    if primitive.mode in _MODES:
        raise Unreadable(f"{_MODES[primitive.mode]} (mode {primitive.mode}) are no surface: export triangles alone")
    corners = np.arange(vertices) if primitive.indices is None else buffers.indices(primitive.indices)
    if len(corners) and corners.max() >= vertices:
        raise Unreadable(f"a primitive refers to vertex {corners.max()}, of vertices 0 to {vertices - 1}")
    if primitive.mode == 4:
        if len(corners) % 3:
            raise Unreadable(f"expected 3 corners for each triangle, got {len(corners)}")
        return corners.reshape(-1, 3)
    ahead = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    if primitive.mode == 5:
        ahead[1::2] = ahead[1::2][:, [1, 0, 2]]
        return ahead
    if primitive.mode == 6:
        ahead[:, 0] = corners[:1]
        return ahead
    raise Unreadable(f"glTF has no mode {primitive.mode}")
