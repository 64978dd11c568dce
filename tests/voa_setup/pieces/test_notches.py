"""Notches: where a solid's surface turns inwards, and how deep."""

import pytest

from tests.support.mesh_shapes import angle, box
from voa_setup.pieces.notches import notches_of
from voa_setup.pieces.solids import solid_of


def test_a_convex_solid_has_none() -> None:
    solid = solid_of(box(0.05, 0.03, 0.02))
    assert solid is not None
    assert notches_of(solid, solid.hull()).deepest_m == 0.0


def test_the_inner_edge_of_an_angle_is_one_however_open_its_ends_are() -> None:
    solid = solid_of(angle(length=0.10, thickness=0.01))
    assert solid is not None
    notches = notches_of(solid, solid.hull())
    # The edge is 40 mm long; its middle is one thickness away from both plates' outsides.
    assert notches.deepest_m == pytest.approx(0.01, abs=1e-6)
