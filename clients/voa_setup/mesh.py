"""The mesh of an object: read from a file, in metres, z up, with its origin at the centre of mass."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.objects import Object
from voa_core.winding import outward_faces
from voa_fleet.world.meshes import Mesh
from voa_msgs.objects import UpAxis
from voa_setup.errors import UnlikelySize, UnusableMesh

ENDINGS = ("stl", "obj", "ply", "glb", "off")
"""Types of mesh files, as in the ending of a file's name."""
MOST_FACES = 200_000
"""Largest number of faces that the service accepts."""
SMALLEST_M, LARGEST_M = 0.01, 0.60
"""Largest extents of objects that an arm grasps, metres: outside of them the unit of the file is probably another."""
_UNITS = {0.001: "millimetres", 0.0254: "inches", 0.01: "centimetres", 1.0: "metres"}
_DIGITS = 7  # of coordinates in metres: 0.1 micrometres
_BALL = 0.97  # a polyhedron of some 300 faces, and a ball that is 1 % longer than wide
_FLAT = 1e-3  # of the largest extent: a thinner object is a sheet


@dataclass(frozen=True, eq=False)
class SetupMesh:
    """The mesh of an object, from which a scenario is made.

    Attributes:
        name: of the object: the file's name without its ending.
        mesh: metres, z up, the origin at the centre of mass, faces outwards where the mesh is closed.
        scale: metres per unit of the file.
        watertight: True if the faces enclose a volume without holes.
        notes: sentences for a person about what was changed or guessed.
    """

    name: str
    mesh: Mesh
    scale: float
    watertight: bool
    notes: tuple[str, ...]

    @property
    def object_(self) -> Object:
        """The mesh as the object of the mathematics."""
        return Object.from_arrays(self.mesh.vertices, self.mesh.faces)

    @property
    def is_ball(self) -> bool:
        """True if the convex hull fills at least 97 % of the ball around the origin."""
        radius = float(np.linalg.norm(self.mesh.vertices, axis=1).max())
        return bool(ConvexHull(self.mesh.vertices).volume > _BALL * 4.0 / 3.0 * np.pi * radius**3)

    @property
    def extents(self) -> Floats:
        """Size of the bounding box along x, y and z, (3,) metres."""
        size: Floats = np.ptp(self.mesh.vertices, axis=0)
        return size


def read_mesh(file: Path, *, scale: float | None = None, up: UpAxis | None = None) -> SetupMesh:
    """Read a mesh file, and move its origin to the centre of mass.

    The centre of mass is that of a body of uniform density; where the mesh is open, that of its convex hull.

    Args:
        file: STL, OBJ, PLY, GLB or OFF.
        scale: metres per unit of the file; None: 1, and an unlikely size is refused.
        up: axis of the file that points up; None: +Y for GLB, as its standard says, else +Z.

    Raises:
        UnlikelySize: no scale is stated, and the largest extent in metres is not between 1 and 60 cm.
        UnusableMesh: the file cannot be read, has too many faces, or its mesh is flat.
    """
    vertices, faces = read_triangles(file, up)
    extent = float(np.ptp(vertices[np.unique(faces)], axis=0).max())
    if scale is None and not SMALLEST_M <= extent <= LARGEST_M:
        raise _unlikely_size(file, extent)
    metres = 1.0 if scale is None else scale
    try:
        object_ = Object.from_arrays(np.round(vertices * metres, _DIGITS), faces)
    except InvalidInput as error:
        raise UnusableMesh(f"{file}: {error}") from error
    centre, notes = _centre_of_mass(file, object_)
    object_ = Object.from_arrays(np.round(object_.vertices - centre, _DIGITS), object_.faces)
    outward = outward_faces(object_)
    mesh = Mesh(object_.vertices, object_.faces if outward is None else outward)
    bodies = 1 if outward is None else _bodies(mesh)
    if bodies > 1:
        notes.append(
            f"The mesh consists of {bodies} separate bodies, which are taken for one rigid object: leave out of the "
            "file what is no part of the object, such as a base plate or a second copy."
        )
    return SetupMesh(file.stem, mesh, metres, outward is not None, tuple(notes))


def write_mesh(mesh: Mesh, file: Path) -> None:
    """Write a mesh as an OBJ file, coordinates in metres with seven digits."""
    lines = ["# metres, z up, origin at the centre of mass"]
    lines += [f"v {x:.{_DIGITS}f} {y:.{_DIGITS}f} {z:.{_DIGITS}f}" for x, y, z in (mesh.vertices + 0.0).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (mesh.faces + 1).tolist()]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_triangles(file: Path, up: UpAxis | None = None) -> tuple[Floats, np.ndarray]:
    """Read the triangles of a mesh file.

    Args:
        file: STL, OBJ, PLY, GLB or OFF.
        up: axis of the file that points up; None: +Y for GLB, as its standard says, else +Z.

    Returns:
        Vertices (v, 3) in the unit of the file, z up, and faces (f, 3).

    Raises:
        UnusableMesh: the file cannot be read, has no faces or too many, or a coordinate is not finite.
    """
    import trimesh  # noqa: PLC0415 - slow to import

    kind = file.suffix.lower().lstrip(".")
    if kind not in ENDINGS:
        raise UnusableMesh(f"{file}: expected a mesh file that ends with {', '.join(ENDINGS)}, got {file.suffix!r}")
    if not file.is_file():
        raise UnusableMesh(f"{file}: there is no such file")
    try:
        scene = trimesh.load_scene(file, process=False, skip_materials=True)
        whole = scene.to_mesh()
        vertices, faces = np.asarray(whole.vertices, dtype=np.float64), np.asarray(whole.faces, dtype=np.int64)
    except Exception as error:  # trimesh raises errors of any class on a broken file
        raise UnusableMesh(f"{file} cannot be read as a mesh: {str(error) or type(error).__name__}") from error
    if not len(faces):
        raise UnusableMesh(f"{file} holds no triangles")
    if len(faces) > MOST_FACES:
        raise UnusableMesh(
            f"{file} has {len(faces)} triangles, and the service accepts {MOST_FACES}: simplify it to some 20000, "
            "for example by MeshLab's quadric edge collapse"
        )
    if not np.isfinite(vertices).all():
        raise UnusableMesh(f"{file} has coordinates that are not finite numbers: export it again")
    if up == "+Y" or (up is None and kind == "glb"):
        vertices = vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    return vertices, faces


def likely_scales(extent: float) -> list[float]:
    """Return the metres per millimetre, inch or centimetre under which an arm could grasp an object of that extent."""
    return [scale for scale in _UNITS if scale != 1.0 and SMALLEST_M <= extent * scale <= LARGEST_M]


def _unlikely_size(file: Path, extent: float) -> UnlikelySize:
    """Make the error for a mesh of that largest extent, with the scales that would make it an object for an arm."""
    scales = likely_scales(extent)
    sizes = [f"--scale {scale:g} if it is in {_UNITS[scale]} ({100 * extent * scale:.3g} cm)" for scale in scales]
    advice = f"state {' or '.join(sizes)}" if sizes else "state --scale, the metres per unit of the file"
    return UnlikelySize(
        f"{file}: in metres the object would measure {extent:.4g} m, and objects for an arm measure 1 to 60 cm: "
        f"{advice}, or --scale 1 if it is in metres all the same",
        extent,
        scales,
    )


def _centre_of_mass(file: Path, object_: Object) -> tuple[Floats, list[str]]:
    """Centre of mass (3,) of a body of uniform density, and notes about it; raises UnusableMesh for a flat mesh."""
    origin = object_.vertices.mean(axis=0)
    points = object_.vertices - origin
    thinnest = _thinnest(points)
    if thinnest < _FLAT * float(np.ptp(points, axis=0).max()):
        raise UnusableMesh(
            f"{file} is flat (at most {1e3 * thinnest:.2g} mm thick): it has no volume to rest on the table or to be "
            "grasped, and a lidar looks over it; give it its thickness in the CAD program"
        )
    faces = outward_faces(object_)
    if faces is not None:
        corners = points[faces]
        return origin + _centroid(corners), []
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    inwards = (
        np.einsum(
            "fi,fi->f", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), hull.equations[:, :3]
        )
        < 0.0
    )
    corners[inwards] = corners[inwards][:, ::-1]
    note = (
        f"The mesh is not closed ({_open_edges(object_)} of its edges do not join exactly two faces): the centre of "
        "mass, and so the rests, are those of its convex hull; close it in the CAD program for better ones."
    )
    return origin + _centroid(corners), [note]


def _thinnest(points: Floats) -> float:
    """Thickness of points (v, 3) along the direction in which they vary least, metres."""
    try:
        ConvexHull(points)
    except (QhullError, ValueError):
        return 0.0
    direction = np.linalg.eigh(points.T @ points)[1][:, 0]
    return float(np.ptp(points @ direction))


def _centroid(corners: Floats) -> Floats:
    """Centroid (3,) of the solid that closed triangles (f, 3, 3) enclose."""
    volumes = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    centroid: Floats = volumes @ corners.sum(axis=1) / (4.0 * volumes.sum())
    return centroid


def _bodies(mesh: Mesh) -> int:
    """Number of closed bodies of which no face shares an edge with another; cavities do not count."""
    count = len(mesh.vertices)
    sides = mesh.faces[:, [0, 1, 1, 2]].reshape(-1, 2).T
    _, body_of = connected_components(coo_array((np.ones(sides.shape[1]), tuple(sides)), shape=(count, count)), False)
    corners = mesh.vertices[mesh.faces]
    volumes = np.bincount(
        body_of[mesh.faces[:, 0]],
        weights=np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])),
    )
    return int((volumes > 0.0).sum())


def _open_edges(object_: Object) -> int:
    """Number of edges that do not belong to exactly two faces."""
    ends, of_face = object_.edges
    return int((np.bincount(of_face.reshape(-1), minlength=len(ends)) != 2).sum())
