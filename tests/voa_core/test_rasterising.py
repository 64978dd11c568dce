import math

import numpy as np
import pytest

from tests.fuzz import beams
from tests.support import twin
from tests.voa_core.worlds import BOX_FACES, UPRIGHT, box, lidar_of, scanned, standing
from voa_core.checks import Floats
from voa_core.cutting import Contours
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.poses import PoseSet
from voa_core.rasterising import ATAN, angle, rasterise

INF = math.inf
CUBE = box(0.2, 0.2, 0.2)
AT = SensorConfiguration("a", -0.3, 0.1, 0.0)
"""0.3 m in front of the middle of the cube's face, looking at it."""


def one_segment(near: tuple[float, float], far: tuple[float, float]) -> Contours:
    return Contours(
        np.array([near, far]),
        np.array([[0, 1]], dtype=np.int32),
        np.array([0, 2]),
        np.array([0, 1]),
        np.array([0]),
        np.array([[1.0, 0.0, 0.0, 0.0]]),
    )


def test_the_arc_tangent_is_the_chebyshev_interpolant_that_it_says() -> None:
    def ratio(u: Floats) -> Floats:
        root = np.sqrt(u)
        values: Floats = np.arctan(root) / root
        return values

    wide = math.tan(math.pi / 8.0) ** 2
    derived = np.polynomial.Chebyshev.interpolate(ratio, 8, domain=[0.0, wide])
    u = np.linspace(1e-12, wide, 1001)
    np.testing.assert_allclose(np.polynomial.Polynomial(ATAN)(u), derived(u), rtol=0, atol=2e-14)
    assert list(derived.convert(kind=np.polynomial.Polynomial).coef) == pytest.approx(list(ATAN), rel=1e-6)


def test_angles_are_within_1e_14_of_atan2_all_around() -> None:
    for bearing in np.linspace(-math.pi, math.pi, 401):
        for radius in (1e-6, 1.0, 50.0):
            x, y = radius * math.cos(bearing), radius * math.sin(bearing)
            assert angle(y, x) == pytest.approx(math.atan2(y, x), abs=1.1e-14)
    assert angle(0.0, 0.0) == 0.0
    assert angle(0.0, -1.0) == pytest.approx(math.pi)


def test_a_cube_straight_ahead_by_hand() -> None:
    lidar = lidar_of(5, increment=math.radians(10.0), start=math.radians(-20.0))
    ranges = scanned(CUBE, AT, lidar)[0]
    slanted = 0.3 / math.cos(math.radians(10.0))
    np.testing.assert_allclose(ranges, [INF, slanted, 0.3, slanted, INF])


@pytest.mark.parametrize("seed", range(4))
def test_a_corner_exactly_on_a_beam_is_seen_whatever_the_yaw_and_the_grid(seed: int) -> None:
    count = beams.compare(20_000, seed)
    assert count.different == 0, count.first_difference
    assert count.hits > count.beams / 10
    assert count.brink < count.beams / 1000


@pytest.mark.parametrize("bearing", [-1e-17, -1e-16, 0.0, 1e-17])
@pytest.mark.parametrize("start", [0.0, -math.pi, 2.0 * math.pi])
def test_a_bearing_that_rounds_to_a_whole_turn_is_that_of_beam_0(bearing: float, start: float) -> None:
    corner = (math.cos(bearing), math.sin(bearing))
    roof = Contours(
        np.array([(1.5, -0.5), corner, (1.5, 0.5)]),
        np.array([[0, 1], [1, 2]], dtype=np.int32),
        np.array([0, 3]),
        np.array([0, 2]),
        np.array([0]),
        np.array([[1.0, 0.0, 0.0, 0.0]]),
    )
    grid = BeamGrid(360, start, math.radians(1.0))
    ranges = rasterise(roof, SensorConfiguration("a", 0.0, 0.0, -start), grid, 5.0)[0]
    assert ranges[0] == pytest.approx(1.0, abs=1e-12)
    assert np.isfinite(ranges).sum() == 37


def test_yaw_turns_the_beams() -> None:
    turned = SensorConfiguration("a", -0.3, 0.1, math.pi / 2)
    np.testing.assert_allclose(scanned(CUBE, turned, lidar_of(4))[0], [INF, INF, INF, 0.3])


def test_a_sensor_inside_sees_the_walls_around_it() -> None:
    inside = SensorConfiguration("a", 0.05, 0.12, 0.0)
    np.testing.assert_allclose(scanned(CUBE, inside, lidar_of(4))[0], [0.15, 0.08, 0.05, 0.12])


def test_the_nearest_of_several_faces_is_seen() -> None:
    poses = standing((0.0, 0.0, 0.0), (0.5, 0.0, 0.0))
    assert scanned(CUBE, AT, lidar_of(4), poses)[:, 0].tolist() == pytest.approx([0.3, 0.8])


def test_nothing_is_seen_beyond_range_max_and_a_hit_at_it_is_seen() -> None:
    assert scanned(CUBE, AT, lidar_of(4, range_max=0.29))[0].tolist() == [INF] * 4
    assert scanned(CUBE, AT, lidar_of(4, range_max=0.31))[0, 0] == pytest.approx(0.3)


def test_a_hit_below_range_min_stays_a_hit() -> None:
    near = SensorConfiguration("a", -0.05, 0.1, 0.0)
    assert scanned(CUBE, near, lidar_of(4))[0, 0] == pytest.approx(0.05)


def test_an_object_across_the_seam_is_seen_on_both_sides_of_it() -> None:
    ranges = scanned(CUBE, AT, lidar_of(360))[0]
    seen = np.flatnonzero(np.isfinite(ranges))
    assert seen.tolist() == [*range(19), *range(342, 360)]
    np.testing.assert_allclose(ranges[1:19], ranges[:341:-1])


@pytest.mark.parametrize("start", [0.0, -math.pi, math.pi, 2.5, -7.0, 100.0])
def test_the_seam_may_lie_anywhere(start: float) -> None:
    steps = math.ceil(start)
    lidar = lidar_of(360, start=math.radians(steps))
    ranges = scanned(CUBE, AT, lidar)[0]
    np.testing.assert_allclose(np.roll(ranges, steps), scanned(CUBE, AT, lidar_of(360))[0], atol=1e-12)


def test_a_lidar_that_turns_clockwise_sees_the_same_the_other_way_round() -> None:
    at = SensorConfiguration("a", -0.3, 0.07, 0.1)
    spacing = math.radians(2.0)
    forth = scanned(CUBE, at, lidar_of(180, increment=spacing))[0]
    back = scanned(CUBE, at, lidar_of(180, increment=-spacing))[0]
    np.testing.assert_allclose(back, np.roll(forth[::-1], 1), atol=1e-12)
    assert np.isfinite(back).sum() > 10


def test_a_partial_field_of_view_is_a_part_of_the_whole() -> None:
    whole = scanned(CUBE, AT, lidar_of(360))[0]
    part = scanned(CUBE, AT, lidar_of(41, increment=math.radians(1.0), start=math.radians(-10.0)))[0]
    np.testing.assert_allclose(part, [*whole[350:], *whole[:31]], atol=1e-12)


def test_more_beams_than_one_turn_see_everything_again() -> None:
    once = scanned(CUBE, AT, lidar_of(36))[0]
    np.testing.assert_allclose(
        scanned(CUBE, AT, lidar_of(90, increment=math.radians(10.0)))[0], [*once, *once, *once[:18]], atol=1e-12
    )


def test_beams_of_a_second_turn_between_those_of_the_first_see_what_lies_there() -> None:
    # 17 beams of 0.37 rad make a little more than a turn: the 18th points 0.0068 rad beside the first.
    post = box(0.002, 0.002, 0.2)
    angle = 17 * 0.37 - 2 * math.pi
    there = standing((0.5 * math.cos(angle), 0.5 * math.sin(angle) - 0.001, 0.0))
    ranges = scanned(post, SensorConfiguration("a", 0.0, 0.0, 0.0), lidar_of(24, increment=0.37), there)[0]
    assert np.flatnonzero(np.isfinite(ranges)).tolist() == [17]


@pytest.mark.parametrize(("start", "expected"), [(0.0, 0.3), (math.pi / 2, INF), (math.pi, INF)])
def test_one_beam_is_a_scan(start: float, expected: float) -> None:
    assert scanned(CUBE, AT, lidar_of(1, start=start))[0].tolist() == pytest.approx([expected])


def test_every_beam_of_a_coarse_lidar_may_meet_the_wall_around_it() -> None:
    around = SensorConfiguration("a", 0.1, 0.1, math.pi / 4)
    np.testing.assert_allclose(scanned(CUBE, around, lidar_of(4))[0], [math.hypot(0.1, 0.1)] * 4)
    np.testing.assert_allclose(scanned(CUBE, around, lidar_of(1))[0], [math.hypot(0.1, 0.1)])


@pytest.mark.parametrize("height", [0.0, 0.2])
def test_a_plane_in_a_face_sees_the_rim(height: float) -> None:
    assert scanned(CUBE, AT, lidar_of(4, height=height))[0, 0] == pytest.approx(0.3)


def test_a_beam_along_a_face_sees_its_near_end() -> None:
    beside = SensorConfiguration("a", -0.3, 0.2, 0.0)
    ranges = scanned(CUBE, beside, lidar_of(360))[0]
    assert np.isfinite(ranges[1:300]).sum() == 0
    assert ranges[0] == pytest.approx(0.3)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("low", "high"), [(0.233, 0.433), (0.3, 0.7), (0.4, 1.3), (0.55, 0.75)])
@pytest.mark.parametrize(
    ("degrees", "spacing"), [(30.0, 0.5), (92.0, 1.0), (182.0, 1.0), (219.0, 1.0), (22.5, 0.5), (112.5, 0.5)]
)
def test_a_face_seen_edge_on_at_any_angle_shows_its_near_end_or_nothing(
    degrees: float, spacing: float, low: float, high: float, sign: int
) -> None:
    direction = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    ends = [(low * direction[0], low * direction[1]), (high * direction[0], high * direction[1])]
    contours = one_segment(*ends[::sign])
    ranges = rasterise(
        contours, SensorConfiguration("a", 0, 0, 0), BeamGrid(round(360 / spacing), 0.0, math.radians(spacing)), 3.0
    )[0]
    seen = np.flatnonzero(np.isfinite(ranges))
    assert set(seen.tolist()) <= {round(degrees / spacing)}
    assert ranges[seen].tolist() == pytest.approx([low] * len(seen))


def test_an_end_of_a_face_at_the_sensor_itself_is_no_trouble() -> None:
    ranges = rasterise(
        one_segment((0.0, 0.0), (0.5, 0.5)), SensorConfiguration("a", 0, 0, 0), BeamGrid(8, 0.0, 0.5), 3.0
    )
    assert ranges.tolist() == [[INF] * 8]


def test_a_silhouette_point_on_a_beam_is_seen_from_at_least_one_side() -> None:
    # A corner that points at the sensor lies on beam 0: the beam must not slip between the two faces.
    half = math.pi / 8
    poses = PoseSet.from_arrays(["A"], [[0.5, 0.0, 0.0]], [[math.cos(-half), 0.0, 0.0, math.sin(-half)]])
    ranges = scanned(CUBE, SensorConfiguration("a", 0, 0, 0), lidar_of(360), poses)[0]
    assert ranges[0] == pytest.approx(0.5)


@pytest.mark.parametrize("height", [0.0, 0.1, 0.2])
@pytest.mark.parametrize("seed", range(4))
def test_cubes_agree_with_the_twin_in_whatever_plane(height: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    position = [*rng.uniform(-0.3, 0.3, 2), 0.0]
    x, y, yaw = (float(value) for value in rng.uniform(-0.6, 0.6, 3))
    lidar = lidar_of(40, height=height)
    ours = scanned(CUBE, SensorConfiguration("a", x, y, yaw), lidar, standing(position))[0]
    theirs = twin.cast(CUBE.vertices, BOX_FACES, position, UPRIGHT, (x, y, yaw), height, lidar.grid.angles, 2.0)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)
