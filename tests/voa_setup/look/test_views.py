"""Views: axes, projections, and the side from which both fingers are seen."""

import numpy as np
import pytest

from voa_msgs.grasp_geometry import GraspGeometry
from voa_setup.look.views import front_view, top_view, view_across_fingers


def grasp(approach: tuple[float, float, float], closing: tuple[float, float, float]) -> GraspGeometry:
    return GraspGeometry(tool_centre_point=(0.0, 0.0, 0.1), approach=approach, closing=closing)


def test_the_front_shows_x_and_z_and_the_top_x_and_y() -> None:
    point = np.array([[1.0, 2.0, 3.0]])
    assert front_view().project(point).tolist() == [[1.0, 3.0]]
    assert top_view().project(point).tolist() == [[1.0, 2.0]]
    assert front_view().toward.tolist() == [0.0, -1.0, 0.0]
    assert top_view().toward.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("approach", "closing", "right", "label"),
    [
        ((0, 0, -1), (1, 0, 0), [1, 0, 0], "x"),
        ((0, 0, -2), (0, -3, 0), [0, 1, 0], "y"),
        ((0, 0, -1), (-1, -1, 0), [0.5**0.5, 0.5**0.5, 0], "45° from x"),
        ((0, 1, 0), (0, 0, 1), [0, 1, 0], "y"),
    ],
)
def test_fingers_are_seen_apart(
    approach: tuple[float, float, float], closing: tuple[float, float, float], right: list[float], label: str
) -> None:
    view = view_across_fingers(grasp(approach, closing))
    assert view.right == pytest.approx(np.array(right, dtype=float))
    assert (view.right_label, view.up_label) == (label, "z")
