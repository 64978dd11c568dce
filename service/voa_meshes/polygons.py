"""Triangles from polygons: convex, concave, not quite planar, with corners on a straight side.

A polygon is projected onto the plane across its Newell normal. If all triangles of the fan from its first corner turn
the same way there, the fan is the result; any other polygon is cut by ear clipping (mapbox-earcut).
"""

from collections.abc import Callable, Iterator
from typing import cast

import numpy as np

from voa_meshes.triangles import Floats, Indices, UnreadableMesh

_STRAIGHT = 1e-10  # of the polygon's size, squared: smaller areas count as 0
_SAME_AREA = 1e-6

Triangle = tuple[int, int, int]


def triangulated(vertices: Floats, corners: Indices, sizes: Indices, name: Callable[[int], str]) -> Indices:
    """Cut polygons into triangles that keep every corner and the polygons' order.

    Args:
        vertices: (v, 3).
        corners: the polygons' vertices one after the other, (sum of sizes,).
        sizes: how many corners each polygon has, at least 3, (p,).
        name: names the polygon of an index in messages.

    Returns:
        Triangles (f, 3) that turn the way their polygon does; a polygon of n corners gives n - 2 where they all differ.

    Raises:
        UnreadableMesh: the sides of a polygon cross one another.
    """
    if (sizes == 3).all():
        return corners.reshape(-1, 3)
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    pieces, owners = [], []
    for size in np.unique(sizes):
        of_size = np.flatnonzero(sizes == size)
        rows = corners[starts[of_size][:, None] + np.arange(size)]
        fans = _is_fan(vertices[rows]) if size > 3 else np.full(len(rows), fill_value=True)
        first = np.broadcast_to(rows[fans][:, :1], (int(fans.sum()), size - 2))
        pieces.append(np.stack([first, rows[fans][:, 1:-1], rows[fans][:, 2:]], axis=2).reshape(-1, 3))
        owners.append(np.repeat(of_size[fans], size - 2))
        for polygon, row in zip(of_size[~fans], rows[~fans], strict=True):
            cut = _clipped(vertices[row], name(int(polygon)))
            pieces.append(row[cut])
            owners.append(np.full(len(cut), polygon))
    order = np.argsort(np.concatenate(owners), kind="stable")
    return cast(Indices, np.concatenate(pieces)[order])


def _is_fan(points: Floats) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return (p,) True where the fan from a polygon's first corner has no triangles that overlap; (p, n, 3) given."""
    arms = _flat(points)
    arms = arms[:, 1:] - arms[:, :1]
    turns = _cross(arms[:, :-1], arms[:, 1:])
    angles = np.arctan2(turns, (arms[:, :-1] * arms[:, 1:]).sum(axis=2))
    sizes = (arms**2).sum(axis=2).max(axis=1)
    return cast(
        "np.ndarray[tuple[int], np.dtype[np.bool_]]",
        (turns > _STRAIGHT * sizes[:, None]).all(axis=1) & (angles.sum(axis=1) < 2.0 * np.pi - 1e-6),
    )


def _flat(points: Floats) -> Floats:
    """Project polygons (p, n, 3) along their Newell normals to (p, n, 2), where they turn counter-clockwise."""
    arms = points - points[:, :1]
    normals = np.cross(arms[:, 1:-1], arms[:, 2:]).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):  # a polygon without an area becomes not a number
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    across = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    across -= (across * normals).sum(axis=1, keepdims=True) * normals
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    axes = np.stack([across, np.cross(normals, across)], axis=2)
    return cast(Floats, np.einsum("pnk,pkd->pnd", arms, axes))


def _cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _areas(triangles: Floats) -> Floats:
    """Return twice the area of triangles (f, 3, 2); negative where they turn clockwise."""
    return _cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])


def _clipped(points: Floats, name: str) -> Indices:
    """Cut one polygon (n, 3) by ear clipping; returns triangles (f, 3) of its corners."""
    kept = np.flatnonzero((points != np.roll(points, 1, axis=0)).any(axis=1))  # a corner listed twice counts once
    corners = points[kept]
    if len(kept) <= 3 or not np.isfinite(corners).all():  # the reader's caller refuses these
        return kept[np.array(_fan(len(kept)), dtype=np.int64).reshape(-1, 3)]
    corners = corners / np.abs(corners).max()
    spread = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    if spread[1] <= 1e-9 * spread[0]:  # all on a line: triangles without an area
        return kept[_fan(len(kept))]
    flat = _flat(corners[None])[0]
    flat /= np.abs(flat).max()
    cut = _ears(flat) if np.isfinite(flat).all() else []
    if not _is_cut(flat, cut):
        raise UnreadableMesh(f"{name}: the sides of its polygon cross one another; cut it into triangles")
    return kept[cut]


def _fan(corners: int) -> list[Triangle]:
    return [(0, k, k + 1) for k in range(1, corners - 1)]


def _ears(flat: Floats) -> list[Triangle]:
    """Clip the ears of a polygon (n, 2), and put back corners on straight sides, which earcut drops."""
    import mapbox_earcut  # noqa: PLC0415 - few files need it

    ends = np.array([len(flat)], dtype=np.uint32)
    ears = mapbox_earcut.triangulate_float64(flat, ends).reshape(-1, 3).astype(np.int64)
    if _areas(flat[ears]).sum() < 0.0:
        ears = ears[:, ::-1]
    triangles = [(int(a), int(b), int(c)) for a, b, c in ears]
    return _with_corners_on_sides(triangles, len(flat))


def _with_corners_on_sides(triangles: list[Triangle], corners: int) -> list[Triangle]:
    """Split triangles at the polygon's corners that lie on their sides.

    A side of only one triangle is a side of the polygon, and the corners between its ends lie on it. For a polygon
    whose sides cross, the number of triangles is wrong, which `_is_cut` notices.
    """
    shared = {side for triangle in triangles for side in _sides(triangle)}
    whole: list[Triangle] = []
    while triangles and len(whole) < corners:
        triangle = triangles.pop()
        for start, end, apex in _turned(triangle):
            if (end - start) % corners > 1 and (end, start) not in shared:
                between = (start + 1) % corners
                shared |= {(apex, between), (between, apex)}
                triangles += [(apex, start, between), (apex, between, end)]
                break
        else:
            whole.append(triangle)
    return whole


def _turned(triangle: Triangle) -> Iterator[Triangle]:
    a, b, c = triangle
    yield from ((a, b, c), (b, c, a), (c, a, b))


def _sides(triangle: Triangle) -> Iterator[tuple[int, int]]:
    yield from ((start, end) for start, end, _ in _turned(triangle))


def _is_cut(flat: Floats, cut: list[Triangle]) -> bool:
    """Return True if triangles make up a polygon (n, 2): its sides once, other sides twice, and its area."""
    if len(cut) != len(flat) - 2:
        return False
    sides = {side for triangle in cut for side in _sides(triangle)}
    around = {(k, (k + 1) % len(flat)) for k in range(len(flat))}
    paired = all((b, a) in sides for a, b in sides - around)
    if len(sides) != 3 * len(cut) or not around <= sides or not paired:
        return False
    areas = _areas(flat[np.array(cut)])
    whole = float(_cross(flat, np.roll(flat, -1, axis=0)).sum())
    return bool((areas >= -_STRAIGHT).all()) and abs(float(areas.sum()) - whole) <= _SAME_AREA * whole
