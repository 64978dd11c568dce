"""Rotations of drawn shapes."""

import math

import pytest

from voa_console.drawing.drawn_shapes import rotation_matrix, rotation_of
from voa_scene.colours import GREY
from voa_scene.rotations import about_z
from voa_scene.shapes import Box, Cylinder


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    matrix = rotation_matrix(about_z(math.pi / 2.0))
    assert [row[0] for row in matrix] == pytest.approx([0.0, 1.0, 0.0])
    assert [row[1] for row in matrix] == pytest.approx([-1.0, 0.0, 0.0])


def test_the_browser_draws_cylinders_along_y_and_scenes_have_them_along_z() -> None:
    cylinder = Cylinder(group="looks", name="ENE", radius=1.0, height=2.0, colour=GREY)
    matrix = rotation_of(cylinder)
    assert [row[1] for row in matrix] == pytest.approx([0.0, 0.0, 1.0])
    box = Box(group="table", name="table", size=(1.0, 1.0, 1.0), colour=GREY)
    assert rotation_of(box) == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
