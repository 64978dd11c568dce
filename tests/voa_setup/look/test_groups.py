"""Ways to rest: poses that differ by a turn and a shift on the table are one."""

import math

from tests.voa_setup.look.scenes import ON_ITS_SIDE, UPRIGHT, mug
from voa_msgs.scenarios import Pose
from voa_setup.look.groups import group_poses


def pose(name: str, quaternion: list[float], x: float = 0.0, z: float = 0.0, turn: float = 0.0) -> Pose:
    c, s = math.cos(turn / 2.0), math.sin(turn / 2.0)
    w, i, j, k = quaternion
    turned = [c * w - s * k, c * i - s * j, c * j + s * i, c * k + s * w]
    return Pose.model_validate({"name": name, "position": [x, 0.0, z], "quaternion_wxyz": turned})


def test_a_turn_and_a_shift_on_the_table_are_no_other_rest() -> None:
    groups = group_poses(
        [
            pose("upright 0", UPRIGHT),
            pose("on side A 0", ON_ITS_SIDE, z=0.03),
            pose("upright 45", UPRIGHT, x=0.1, turn=0.7854),
            pose("on side A 90", ON_ITS_SIDE, z=0.03, turn=1.5708),
            pose("on a box 0", UPRIGHT, z=0.2),
        ]
    )
    assert [(group.name, group.poses) for group in groups] == [
        ("upright", (0, 2)),
        ("on side A", (1, 3)),
        ("on a box 0", (4,)),
    ]


def test_the_mug_rests_in_two_ways() -> None:
    scenario, _ = mug()
    assert [(group.name, group.poses) for group in group_poses(scenario.poses)] == [
        ("U", (0, 1, 3, 4, 5)),
        ("D_90", (2,)),
    ]


def test_poses_without_a_common_name_are_named_after_the_first() -> None:
    (group,) = group_poses([pose("12", UPRIGHT), pose("7", UPRIGHT, turn=1.0)])
    assert group.name == "12"
