"""A parallel gripper: two coupled fingers on slides, closed by one servo of limited force."""

from typing import Any

import mujoco

from voa_fleet.world.groups import ARM_SEEN, HAND_OBJECT, HAND_TABLE, HARD, STIFF
from voa_fleet.world.objects import GripperSetting

PALM_M = 0.090
"""Distance from the flange to the fingers' roots."""
TOOL = "tool"
"""The site in the middle between the fingertips; its z points out of the hand, its x along the closing direction."""
FINGERS = ("finger_right", "finger_left")
SERVO = "grip"

_KP, _KV = 4000.0, 100.0
_TOUCH = HAND_TABLE | HAND_OBJECT


def add_gripper(spec: mujoco.MjSpec, flange: Any, setting: GripperSetting) -> None:
    """Mount a gripper, opened and limited in force as `setting` says, on the arm's flange."""
    reach = setting.opening_m / 2.0
    palm = [reach + setting.finger_thickness_m + 0.004, setting.palm_width_m / 2.0, PALM_M / 2.0]
    flange.add_geom(
        name="palm",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[0.0, 0.0, PALM_M / 2.0],
        size=palm,
        mass=0.8,
        contype=_TOUCH,
        conaffinity=_TOUCH,
        solref=list(STIFF),
        solimp=list(HARD),
        group=ARM_SEEN,
        rgba=[0.25, 0.27, 0.30, 1.0],
    )
    flange.add_site(name=TOOL, pos=[0.0, 0.0, PALM_M + setting.finger_length_m], size=[0.002, 0.0, 0.0], group=5)
    for name, side in zip(FINGERS, (1.0, -1.0), strict=True):
        _add_finger(flange, name, side, setting)
    spec.add_exclude(bodyname1=FINGERS[0], bodyname2=FINGERS[1])
    coupling = spec.add_equality(
        name="coupling",
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1=FINGERS[0],
        name2=FINGERS[1],
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
    )
    coupling.data[:5] = [0.0, 1.0, 0.0, 0.0, 0.0]
    closing = spec.add_tendon(name=SERVO)
    for name in FINGERS:
        closing.wrap_joint(name, 0.5)
    servo = spec.add_actuator(name=SERVO, target=SERVO, trntype=mujoco.mjtTrn.mjTRN_TENDON)
    servo.set_to_position(kp=_KP, kv=_KV)
    # Half of the tendon's force goes to each finger.
    servo.forcerange = [-2.0 * setting.force_n, 2.0 * setting.force_n]
    servo.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE


def _add_finger(flange: Any, name: str, side: float, setting: GripperSetting) -> None:
    """A finger whose slide counts metres from the middle: half of the opening when open, 0 when closed."""
    reach = setting.opening_m / 2.0
    thickness, width, length = setting.finger_thickness_m, setting.finger_width_m, setting.finger_length_m
    finger = flange.add_body(name=name, pos=[side * thickness / 2.0, 0.0, PALM_M + length / 2.0], gravcomp=1.0)
    finger.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[side, 0.0, 0.0],
        range=[-0.001, reach + 0.001],
        limited=mujoco.mjtLimited.mjLIMITED_TRUE,
        damping=[10.0, 0.0, 0.0],
        armature=0.5,
        solref_limit=list(STIFF),
        solimp_limit=list(HARD),
    )
    finger.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[thickness / 2.0, width / 2.0, length / 2.0],
        mass=0.05,
        contype=_TOUCH,
        conaffinity=_TOUCH,
        condim=4,
        friction=[1.0, 0.005, 0.0001],
        solref=list(STIFF),
        solimp=list(HARD),
        group=ARM_SEEN,
        rgba=[0.15, 0.16, 0.18, 1.0],
    )
