from typing import Any

import numpy as np
import pytest

from tests.voa_core.worlds import BOX_FACES, box
from voa_core.errors import InvalidInput
from voa_core.objects import Object

TRIANGLE = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (TRIANGLE, [], "faces: expected at least one triangle, shape nx3, got shape"),
        (TRIANGLE, np.zeros((0, 3), dtype=int), "at least one triangle"),
        (TRIANGLE, [[0, 1, 2, 0]], r"got shape \(1, 4\)"),
        (TRIANGLE, [[0.0, 1.0, 2.0]], "faces: expected integers, got float64"),
        (TRIANGLE, [[0, 1, 3]], "faces: expected indices from 0 to 2, got 0 to 3"),
        (TRIANGLE, [[-1, 1, 2]], "faces: expected indices from 0 to 2, got -1 to 2"),
        ([[0.0, 0.0]], [[0, 0, 0]], "vertices: expected shape nx3, got shape 1x2"),
        ([*TRIANGLE, [0.0, np.nan, 0.0]], [[0, 1, 3]], r"vertices: expected finite numbers, got nan at \[3, 1\]"),
        (TRIANGLE, [[0, 1, 1]], "faces: expected at least one triangle with three corners, got corners that coincide"),
    ],
)
def test_a_mesh_that_is_none_is_refused(vertices: Any, faces: Any, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        Object.from_arrays(vertices, faces)


@pytest.mark.parametrize(
    ("scale", "message"),
    [
        (float("nan"), "scale: expected a number above 0.0, got nan"),
        (0.0, "scale: expected a number above 0.0, got 0.0"),
        (-1.0, "scale: expected a number above 0.0, got -1.0"),
    ],
)
def test_a_scale_that_is_none_is_refused(scale: float, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        Object.from_arrays(TRIANGLE, [[0, 1, 2]], scale=scale)


def test_a_scale_that_leaves_no_finite_size_is_refused() -> None:
    with np.errstate(over="ignore"), pytest.raises(InvalidInput, match="scale: expected finite numbers"):
        Object.from_arrays(10.0 * np.array(TRIANGLE), [[0, 1, 2]], scale=1e308)


def test_equal_corners_are_one_vertex_and_the_scale_gives_metres() -> None:
    soup = np.array([box(1.0, 2.0, 3.0).vertices[face] for face in BOX_FACES]).reshape(-1, 3)
    merged = Object.from_arrays(soup, np.arange(36).reshape(-1, 3), scale=0.001)
    assert len(merged.vertices) == 8
    assert merged.watertight
    np.testing.assert_allclose(merged.extents, [0.001, 0.002, 0.003])


def test_a_vertex_at_minus_zero_is_the_one_at_zero() -> None:
    sheet = Object.from_arrays(np.array([*TRIANGLE, [-0.0, 0.0, -0.0]]), [[0, 1, 2], [3, 2, 1]])
    assert len(sheet.vertices) == 3


def test_the_digest_names_the_content() -> None:
    assert box(1.0, 2.0, 3.0).digest == box(1.0, 2.0, 3.0).digest
    assert box(1.0, 2.0, 3.0).digest != box(1.0, 2.0, 3.1).digest
    turned_over = Object.from_arrays(box(1.0, 2.0, 3.0).vertices, np.array(BOX_FACES)[:, ::-1])
    assert turned_over.digest != box(1.0, 2.0, 3.0).digest


@pytest.mark.parametrize("stray", [[9.0, 9.0, 9.0], [np.nan, np.inf, 0.0]])
def test_vertices_that_no_face_uses_are_dropped(stray: list[float]) -> None:
    flat = Object.from_arrays(np.array([stray, *TRIANGLE, stray]), [[1, 2, 3]])
    assert flat.digest == Object.from_arrays(TRIANGLE, [[0, 1, 2]]).digest


def test_faces_of_which_two_corners_coincide_are_dropped_and_what_only_they_use() -> None:
    points, faces = box(1.0, 2.0, 3.0).vertices, np.array(BOX_FACES)
    slivers = [[0, 1, 1], [8, 0, 0], [9, 0, 2]]  # vertex 9 is vertex 0 once more
    mended = Object.from_arrays([*points, [9.0, 9.0, 9.0], points[0]], [*faces, *slivers])
    assert mended.watertight
    assert mended.digest == box(1.0, 2.0, 3.0).digest


def test_the_sign_of_zero_does_not_change_the_digest() -> None:
    points = box(1.0, 2.0, 3.0).vertices
    assert Object.from_arrays(np.where(points == 0.0, -0.0, points), BOX_FACES).digest == box(1.0, 2.0, 3.0).digest


def test_a_box_is_watertight_and_one_without_a_face_is_not() -> None:
    assert box(1.0, 1.0, 1.0).watertight
    assert not Object.from_arrays(box(1.0, 1.0, 1.0).vertices, BOX_FACES[1:]).watertight


def test_a_box_has_18_edges_and_every_face_knows_its_three() -> None:
    cube = box(1.0, 1.0, 1.0)
    ends, sides = cube.edges
    assert ends.shape == (18, 2)
    assert (ends[:, 0] < ends[:, 1]).all()
    for face, three in zip(cube.faces, sides, strict=True):
        assert {frozenset(ends[e].tolist()) for e in three} == {
            frozenset((int(face[k]), int(face[(k + 1) % 3]))) for k in range(3)
        }


def test_faces_are_kept_box_by_box_with_their_corners_and_edges() -> None:
    count = 12  # a pyramid: 24 faces in two boxes, the second of them half empty
    ring = [[np.cos(a), np.sin(a), 0.0] for a in 2.0 * np.pi * np.arange(count) / count]
    sides = [[i, (i + 1) % count, count + top] for top in (0, 1) for i in range(count)]
    pyramid = Object.from_arrays([*ring, [0, 0, 1], [0, 0, -1]], sides)
    boxed = pyramid.boxes[0]
    corners, edges = pyramid.boxed_faces
    assert corners.shape == (2, 3, 3, 16)
    assert sorted(np.unique(edges)) == list(range(len(pyramid.edges[0])))
    number: dict[int, int] = {}
    for group, lane in np.ndindex(2, 16):
        face = boxed[group, lane] if boxed[group, lane] >= 0 else boxed[group].max()
        np.testing.assert_array_equal(corners[group, :, :, lane], pyramid.vertices[pyramid.faces[face]])
        for edge, known in zip(pyramid.edges[1][face], edges[group, :, lane], strict=True):
            assert number.setdefault(int(edge), int(known)) == known
    assert edges[0].max() <= 3 * 16 - 1, "the edges of the first box have the first numbers"
