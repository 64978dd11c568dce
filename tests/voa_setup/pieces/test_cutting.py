"""Cuts keep all of a solid's volume, and end where the pieces are convex enough or many enough."""

import pytest

from tests.support.mesh_shapes import angle, bowl
from voa_setup.pieces.cutting import cut
from voa_setup.pieces.joining import join
from voa_setup.pieces.solids import solid_of


def test_cuts_lose_nothing() -> None:
    solid = solid_of(bowl())
    assert solid is not None
    pieces = cut(solid, 0.0003, 300)
    assert sum(piece.volume_m3 for piece in pieces) == pytest.approx(solid.volume(), rel=1e-6)


def test_a_coarser_bound_gives_fewer_pieces() -> None:
    solid = solid_of(bowl())
    assert len(cut(solid, 0.003, 300)) < len(cut(solid, 0.0003, 300))


def test_joining_undoes_cuts_that_were_not_needed() -> None:
    solid = solid_of(angle())
    assert solid is not None
    halves = [part for side in solid.split_by_plane((0.0, 1.0, 0.0), 0.001) for part in cut(side, 0.0003, 300)]
    assert len(halves) == 4
    joined = join(halves, 0.00005)
    assert len(joined) == 2
    assert sum(piece.hull.volume() for piece in joined) == pytest.approx(solid.volume(), rel=1e-6)


def test_nothing_is_joined_over_a_hollow() -> None:
    pieces = cut(solid_of(angle()), 0.0003, 300)
    assert join(pieces, 0.00005) == pieces
