"""Pictures: positions on the map, and text in them that a mesh file could choose."""

import pytest

from voa_console.new_object.pictures import (
    FRAMES,
    MAP,
    PICTURE,
    bearing_at,
    map_of_places,
    outline_picture,
    place_at,
    reach_of,
    to_map,
)
from voa_setup.previews import turntable
from voa_setup.previews.messages import PlannedPlace, RestOutline

OUTLINE = RestOutline(rest="on <side>", path="M0 0L10 0", shadow="M30.0 40.0L-5.0 0.0Z")


def test_the_pictures_of_a_turn_are_those_that_are_drawn() -> None:
    assert (FRAMES, PICTURE) == (turntable.FRAMES, turntable.PIXELS)


@pytest.mark.parametrize(("x", "y", "bearing"), [(0.45, 0.0, 0.0), (0.0, 0.45, 90.0), (-0.3, -0.3, 225.0)])
def test_a_point_of_the_map_has_the_bearing_of_its_position(x: float, y: float, bearing: float) -> None:
    assert bearing_at(*to_map(x, y, 0.45)) == pytest.approx(bearing)


def test_the_nearest_place_is_picked_within_the_width_of_a_finger() -> None:
    x, y = to_map(0.0, 0.45, 0.45)
    assert place_at(x + 3.0, y + 5.0, (0.0, 90.0, 180.0)) == 1
    assert place_at(MAP / 2.0, MAP / 2.0, (0.0, 90.0, 180.0)) is None
    assert place_at(x, y, ()) is None


def test_names_are_text_and_no_markup() -> None:
    place = PlannedPlace(name="<b>E", x=0.45, y=0.0, yaw_rad=3.14)
    drawn = map_of_places([place], [OUTLINE], 0.45, moved=0)
    assert "&lt;b&gt;E" in drawn
    assert "<b>" not in drawn
    assert "on &lt;side&gt;" in outline_picture(OUTLINE, "#000", 50.0)


def test_the_outlines_fill_their_picture() -> None:
    assert reach_of([OUTLINE]) == pytest.approx(54.0)
    assert reach_of([]) > 0.0
