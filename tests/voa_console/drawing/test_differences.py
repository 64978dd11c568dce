"""Differences of scenes: what is drawn again, and what only changes its place or colour."""

from dataclasses import replace

from voa_console.drawing.differences import differences
from voa_scene.colours import BLUE, GREY
from voa_scene.shapes import Ball, Box, MeshShape, Scene

GHOST = MeshShape(group="belief", name="P1", label="P1: 50 %", colour=GREY, object="mug")
BOX = Box(group="table", name="table", size=(1.0, 1.0, 0.1), colour=GREY)


def test_equal_scenes_differ_in_nothing() -> None:
    same = differences(Scene((GHOST, BOX)), Scene((GHOST, BOX)))
    assert (same.removed, same.added, same.changed) == ((), (), ())


def test_a_new_colour_place_or_label_changes_a_shape_and_leaves_its_geometry() -> None:
    moved = replace(GHOST, colour=BLUE, position=(1.0, 0.0, 0.0), label="P1: 90 %")
    result = differences(Scene((GHOST, BOX)), Scene((moved, BOX)))
    assert (result.removed, result.added, result.changed) == ((), (), (moved,))


def test_another_size_or_class_is_drawn_again() -> None:
    larger = replace(BOX, size=(2.0, 1.0, 0.1))
    ball = Ball(group="belief", name="P1", radius=0.1, colour=GREY)
    result = differences(Scene((GHOST, BOX)), Scene((ball, larger)))
    assert set(result.removed) == {("belief", "P1"), ("table", "table")}
    assert set(result.added) == {ball, larger}
    assert result.changed == ()


def test_shapes_come_and_go_by_group_and_name() -> None:
    other = replace(GHOST, group="grasp")
    result = differences(Scene((GHOST,)), Scene((other,)))
    assert (result.removed, result.added) == ((("belief", "P1"),), (other,))
