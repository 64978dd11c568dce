"""Objects that NiceGUI's scene does not have: copies of a mesh that share its triangles, long lines, points on top."""

from collections.abc import Sequence

from nicegui.elements.scene.scene_object3d import Object3D


class MeshCopy(Object3D, component="mesh_copy.js"):
    """Copy of a mesh; the browser loads and stores the triangles of an address once, however many copies there are.

    Args:
        url: of a binary STL file.
    """

    def __init__(self, url: str) -> None:
        super().__init__(url)


class PolylineObject(Object3D, component="polyline.js"):
    """Line through points.

    Args:
        points: at least two, each x, y, z, metres.
        closed: the last point is joined to the first.
        on_top: no shape in front hides the line.
    """

    def __init__(self, points: Sequence[Sequence[float]], closed: bool, on_top: bool) -> None:
        super().__init__([list(point) for point in points], closed, on_top)


class PointsObject(Object3D, component="points.js"):
    """Points.

    Args:
        points: each x, y, z, metres.
        size: of each point, metres.
        on_top: no shape in front hides the points.
    """

    def __init__(self, points: Sequence[Sequence[float]], size: float, on_top: bool) -> None:
        super().__init__([list(point) for point in points], size, on_top)
