"""Flipped faces are turned, cavities stay cavities, and what has no inside is left alone."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.voa_core.worlds import BOX_FACES, box
from voa_core.objects import Object
from voa_core.winding import outward_faces


def volume_of(object_: Object, faces: NDArray[np.int32] | None) -> float:
    assert faces is not None
    mesh = trimesh.Trimesh(object_.vertices, faces, process=False)
    assert mesh.is_winding_consistent
    return float(mesh.volume)


def scene(*solids: trimesh.Trimesh) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    starts = np.cumsum([0, *(len(solid.vertices) for solid in solids)])
    faces = [solid.faces + start for solid, start in zip(solids, starts[:-1], strict=True)]
    return np.concatenate([solid.vertices for solid in solids]), np.concatenate(faces)


def cube(side: float, *, at: float = 0.0, cavity: bool = False) -> trimesh.Trimesh:
    solid: trimesh.Trimesh = trimesh.creation.box([side] * 3)
    solid.apply_translation([at, 0.0, 0.0])
    if cavity:
        solid.invert()
    return solid


def test_faces_that_all_point_outwards_stay_as_they_are() -> None:
    object_ = Object.from_arrays(*scene(cube(3.0), cube(1.0, cavity=True), cube(1.0, at=9.0)))
    np.testing.assert_array_equal(outward_faces(object_), object_.faces)


@given(st.lists(st.booleans(), min_size=12, max_size=12))
def test_any_faces_of_a_box_may_be_flipped(flipped: list[bool]) -> None:
    faces = np.array([face[::-1] if flip else face for face, flip in zip(BOX_FACES, flipped, strict=True)])
    object_ = Object.from_arrays(box(0.1, 0.2, 0.3).vertices + 3.0, faces)
    assert volume_of(object_, outward_faces(object_)) == pytest.approx(0.006)


@pytest.mark.parametrize("inside_out", [(), (0,), (1,), (0, 1)])
def test_of_two_bodies_side_by_side_each_is_turned_outwards(inside_out: tuple[int, ...]) -> None:
    solids = [cube(1.0, at=2.0 * k, cavity=k in inside_out) for k in range(2)]
    object_ = Object.from_arrays(*scene(*solids))
    assert volume_of(object_, outward_faces(object_)) == pytest.approx(2.0)


@pytest.mark.parametrize("whole_inside_out", [False, True])
@given(seed=st.integers(0, 2**32 - 1))
def test_a_cavity_stays_one_whatever_faces_are_flipped(whole_inside_out: bool, seed: int) -> None:
    vertices, faces = scene(cube(3.0), cube(1.0, cavity=True), cube(2.0, at=9.0))
    flipped = np.random.default_rng(seed).uniform(size=len(faces)) < 0.2
    flipped[12 * np.arange(3)[:, None] + np.arange(9)] = False  # most of each body's area tells what is meant
    faces[flipped ^ whole_inside_out] = faces[flipped ^ whole_inside_out, ::-1]
    object_ = Object.from_arrays(vertices, faces)
    assert volume_of(object_, outward_faces(object_)) == pytest.approx(27.0 - 1.0 + 8.0)


def test_a_body_within_a_cavity_is_a_body() -> None:
    object_ = Object.from_arrays(*scene(cube(3.0), cube(2.0, cavity=True), cube(1.0)))
    assert volume_of(object_, outward_faces(object_)) == pytest.approx(27.0 - 8.0 + 1.0)


def test_a_body_in_the_box_around_another_but_not_in_it_is_turned_outwards() -> None:
    ring = trimesh.creation.torus(1.0, 0.2)
    ball = trimesh.creation.icosphere(radius=0.1)
    expected = float(ring.volume + ball.volume)
    ball.invert()
    object_ = Object.from_arrays(*scene(ring, ball))
    assert volume_of(object_, outward_faces(object_)) == pytest.approx(expected)


def test_what_has_a_hole_or_one_side_or_countless_bodies_cannot_be_turned() -> None:
    assert outward_faces(Object.from_arrays(box(1, 1, 1).vertices, BOX_FACES[1:])) is None
    # The projective plane of six points: every edge belongs to two faces, and there is no inside.
    one_sided = ["012", "023", "034", "045", "051", "124", "235", "341", "452", "513"]
    faces = [[int(corner) for corner in face] for face in one_sided]
    twisted = Object.from_arrays(np.random.default_rng(0).normal(size=(6, 3)), faces)
    assert twisted.watertight
    assert outward_faces(twisted) is None
    foam = Object.from_arrays(*scene(*(cube(0.5, at=float(k), cavity=k % 2 == 1) for k in range(300))))
    assert outward_faces(foam) is None
