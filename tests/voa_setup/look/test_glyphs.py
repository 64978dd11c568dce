"""Glyphs of grippers: fingers as far apart as the object is wide, behind the tool centre point."""

import numpy as np
import pytest

from voa_fleet.world.objects import GripperSetting
from voa_msgs.grasp_geometry import GraspGeometry
from voa_setup.look.glyphs import gripper_glyph

GRIPPER = GripperSetting(opening_m=0.08, force_n=40.0, finger_length_m=0.05, finger_thickness_m=0.01)


@pytest.mark.parametrize(("width", "gap"), [(0.03, 0.03), (None, 0.08)])
def test_fingers_leave_the_width_of_the_object_between_them(width: float | None, gap: float) -> None:
    geometry = GraspGeometry(tool_centre_point=(0.1, 0.0, 0.2), approach=(0, 0, -1), closing=(0, 1, 0), width_m=width)
    glyph = gripper_glyph(geometry, GRIPPER)
    y = np.abs(glyph.fingers.reshape(-1, 3)[:, 1])
    assert (y.min(), y.max()) == (pytest.approx(gap / 2.0), pytest.approx(gap / 2.0 + 0.01))
    z = glyph.fingers[..., 2]
    assert (z.min(), z.max()) == (pytest.approx(0.2), pytest.approx(0.25))
    assert glyph.bar[..., 2].min() == pytest.approx(0.25)
    assert glyph.tip.tolist() == [0.1, 0.0, 0.2]
    assert glyph.tail == pytest.approx([0.1, 0.0, 0.23])
