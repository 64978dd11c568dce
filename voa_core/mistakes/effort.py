"""Limits of the work that a search for mistakes may take, in steps that do not depend on the machine."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """Upper limits of a search; beyond one of them only an even selection of poses and places is searched.

    Attributes:
        pairs: pairs of pose and place.
        corners: heights of corners of the mesh over the table.
        cut_faces: faces of the mesh, over all cuts of it.
        contour_points: points of cuts, over all pairs of pose and place.
        boxes: bounding boxes of faces that are tested while placed meshes are compared.
    """

    pairs: int
    corners: int
    cut_faces: int
    contour_points: int
    boxes: int


QUICK = Effort(pairs=2_000, corners=20_000_000, cut_faces=10_000_000, contour_points=5_000_000, boxes=5_000_000)
"""Limits for the search that every response about a scenario includes: about 50 ms."""
THOROUGH = Effort(pairs=100_000_000, corners=10**10, cut_faces=10**10, contour_points=5 * 10**9, boxes=3 * 10**9)
"""Limits for a complete search: every pair of a usual scenario, and a few minutes for the largest."""
