import math

import numpy as np
import pytest
import trimesh

from tests.support.shapes import box, mug
from voa_fleet.world.gripper import PALM_M
from voa_fleet.world.kinematics import APPROACH_M
from voa_fleet.world.meshes import Mesh
from voa_fleet.world.objects import GripperSetting
from voa_msgs.grasp_geometry import GraspGeometry
from voa_setup.grasps.closing import Closed, close_hands
from voa_setup.grasps.hands import Hands, hands_of, heights, palm_half_m
from voa_setup.grasps.surface import sample_surface

GRIPPER = GripperSetting(opening_m=0.085, force_n=40.0)
NARROW = GripperSetting(opening_m=0.018, force_n=40.0)


def cuboids(sizes_and_centres: list[list[float]]) -> Mesh:
    """A mesh of cuboids along the axes: size and centre of each."""
    parts = []
    for numbers in sizes_and_centres:
        part = trimesh.creation.box(extents=numbers[:3])
        part.apply_translation(numbers[3:])
        parts.append(np.asarray(part.triangles).reshape(-1, 3))
    corners = np.concatenate(parts)
    return Mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))


def hand(*tip: float, turn_deg: float = 0.0, approach: tuple[float, float, float] = (0.0, 0.0, -1.0)) -> Hands:
    turn = math.radians(turn_deg)
    closing = (math.cos(turn), math.sin(turn), 0.0)
    return hands_of([GraspGeometry(tool_centre_point=tip, approach=approach, closing=closing)])


def closed(mesh: Mesh, hands: Hands, gripper: GripperSetting = GRIPPER, clearance_m: float = 0.0) -> Closed:
    return close_hands(sample_surface(mesh, 0), hands, gripper, 0.5, clearance_m)


def test_parallel_faces_are_held_and_measured() -> None:
    result = closed(box(), hand(0.0, 0.005, 0.02, turn_deg=90.0))
    assert result.holds.tolist() == [True]
    assert result.widths_m[0] == pytest.approx(0.070, abs=1e-4)
    assert result.middles_m[0] == pytest.approx(-0.005, abs=1e-4)


def test_a_hand_does_not_hold_a_body_that_is_wider_than_its_opening() -> None:
    result = closed(box(), hand(0.0, 0.0, 0.02))
    assert result.free.tolist() == [False]
    assert result.holds.tolist() == [False]


def test_clearance_makes_the_fingers_closer() -> None:
    assert closed(box(), hand(0.0, 0.0, 0.02, turn_deg=90.0), clearance_m=0.007).holds[0]
    assert not closed(box(), hand(0.0, 0.0, 0.02, turn_deg=90.0), clearance_m=0.008).free[0]


def test_nothing_between_the_fingers_is_free_and_not_held() -> None:
    result = closed(box(), hand(0.0, 0.0, 0.06, turn_deg=90.0))
    assert (result.free[0], result.holds[0], result.widths_m[0]) == (True, False, 0.0)


def test_the_palm_does_not_reach_into_the_object() -> None:
    mesh = cuboids([[0.04, 0.04, 0.2, 0.0, 0.0, 0.0]])
    assert closed(mesh, hand(0.0, 0.0, 0.047)).holds[0]
    assert not closed(mesh, hand(0.0, 0.0, 0.03)).free[0]


def test_the_way_in_must_be_free_too() -> None:
    mesh = cuboids([[0.04, 0.04, 0.04, 0.0, 0.0, 0.0], [0.3, 0.3, 0.002, 0.0, 0.0, 0.12]])
    assert not closed(mesh, hand(0.0, 0.0, 0.0)).free[0]
    assert closed(mesh, hand(0.0, 0.0, 0.0, approach=(0.0, 1.0, 0.0))).holds[0]


@pytest.mark.parametrize(("turn_deg", "holds"), [(0.0, True), (8.0, True), (45.0, False)])
def test_edges_between_the_fingers_are_not_held(turn_deg: float, holds: bool) -> None:
    mesh = cuboids([[0.04, 0.04, 0.04, 0.0, 0.0, 0.0]])
    assert closed(mesh, hand(0.0, 0.0, 0.0, turn_deg=turn_deg)).holds[0] == holds


def test_contacts_that_do_not_face_each_other_are_not_held() -> None:
    mesh = cuboids([[0.01, 0.03, 0.004, 0.015, 0.0, -0.045], [0.01, 0.03, 0.004, -0.015, 0.0, -0.003]])
    result = closed(mesh, hand(0.0, 0.0, 0.0, approach=(0.0, 0.0, 1.0)))
    assert (result.free[0], result.holds[0]) == (True, False)


def test_a_thin_wall_and_a_rod_are_held() -> None:
    rim = closed(mug(), hand(-0.038, 0.0, 0.07), NARROW)
    rod = closed(mug(), hand(0.05, 0.0, 0.0475, turn_deg=90.0, approach=(-1.0, 0.0, 0.0)), NARROW)
    assert rim.holds[0]
    assert 0.004 < rim.widths_m[0] < 0.007
    assert rod.holds[0]
    assert rod.widths_m[0] == pytest.approx(0.009, abs=5e-4)


def test_results_do_not_depend_on_the_mesh_s_winding() -> None:
    mesh = mug()
    turned = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    hands = hand(-0.038, 0.0, 0.07)
    assert closed(turned, hands, NARROW).holds[0]


def test_no_hands_close_on_nothing() -> None:
    none = Hands(np.zeros((0, 3, 3)), np.zeros((0, 3)))
    assert closed(box(), none).holds.shape == (0,)


@pytest.mark.parametrize(
    ("approach", "closing", "expected"),
    [
        ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.1),
        ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0), 0.1 - 0.014),
        ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 0.1 - 0.0425 - 0.008 - 0.004),
    ],
)
def test_the_lowest_corner_is_that_of_the_fingers_or_the_palm(
    approach: tuple[float, float, float], closing: tuple[float, float, float], expected: float
) -> None:
    hands = hands_of([GraspGeometry(tool_centre_point=(0.0, 0.0, 0.1), approach=approach, closing=closing)])
    assert heights(hands, GRIPPER)[0] == pytest.approx(expected)


def test_hands_are_free_where_no_point_lies_in_fingers_or_palm_on_the_way() -> None:
    surface = sample_surface(mug(), 0)
    rng = np.random.default_rng(1)
    tips = rng.uniform([-0.06, -0.06, 0.0], [0.08, 0.06, 0.12], (200, 3))
    hands = hands_of(
        [
            GraspGeometry(
                tool_centre_point=tuple(tip), approach=(0.0, 0.0, -1.0), closing=(math.cos(turn), math.sin(turn), 0.0)
            )
            for tip, turn in zip(tips.tolist(), rng.uniform(0.0, np.pi, 200).tolist(), strict=True)
        ]
    )
    result = close_hands(surface, hands, NARROW, 0.5)
    reach, length = NARROW.opening_m / 2.0, NARROW.finger_length_m
    free = []
    for rotation, tip in zip(hands.rotations, hands.tips, strict=True):
        x, y, depth = ((surface.points - tip) @ rotation).T
        x, y = np.abs(x), np.abs(y)
        finger = (y <= NARROW.finger_width_m / 2.0) & (x >= reach) & (x <= reach + NARROW.finger_thickness_m)
        palm = (y <= NARROW.palm_width_m / 2.0) & (x <= palm_half_m(NARROW)) & (depth <= -length)
        on_the_way = (depth <= 0.0) & (depth >= -length - PALM_M - APPROACH_M)
        free.append(not (on_the_way & (finger | palm)).any())
    assert result.free.tolist() == free
    assert 20 < sum(free) < 180
