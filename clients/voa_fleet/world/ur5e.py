"""An arm with the kinematics of a UR5e, from its public Denavit-Hartenberg parameters.

Links are capsules that the lidar sees and that touch nothing: collisions of the arm with the table or itself are not
modelled. Masses are those of the data sheet; gravity is compensated, as by the real controller.
"""

import math
from dataclasses import dataclass
from typing import Any

import mujoco

from voa_fleet.world.groups import ARM_SEEN

BASE = (-0.55, 0.0, 0.0)
"""Position of the arm's base, metres; the object is near the world's origin."""
HOME = (math.pi, -2.0, 1.9, -1.47, -math.pi / 2.0, 0.0)
"""Joint angles at rest, radians: the hand is high over the table, out of the lidar's plane."""
DAMPING = 2.0
"""Damping of every joint, N m s."""


@dataclass(frozen=True)
class Link:
    """A row of the Denavit-Hartenberg table, and the limits of its joint.

    Attributes:
        a, d: metres.
        alpha: radians.
        mass: kg.
        radius: of the link's capsule, metres.
        kp, kv: gains of its position servo, N m and N m s per radian.
        torque: limit of its motor, N m.
    """

    a: float
    d: float
    alpha: float
    mass: float
    radius: float
    kp: float
    kv: float
    torque: float


LINKS = (
    Link(0.0, 0.1625, math.pi / 2.0, 3.761, 0.060, 4000.0, 400.0, 150.0),
    Link(-0.425, 0.0, 0.0, 8.058, 0.055, 4000.0, 400.0, 150.0),
    Link(-0.3922, 0.0, 0.0, 2.846, 0.045, 4000.0, 400.0, 150.0),
    Link(0.0, 0.1333, math.pi / 2.0, 1.37, 0.040, 1000.0, 100.0, 28.0),
    Link(0.0, 0.0997, -math.pi / 2.0, 1.3, 0.040, 1000.0, 100.0, 28.0),
    Link(0.0, 0.0996, 0.0, 0.365, 0.035, 1000.0, 100.0, 28.0),
)


def joint_names() -> list[str]:
    """Return the names of the six joints, from the base."""
    return [f"arm{index + 1}" for index in range(len(LINKS))]


def add_arm(spec: mujoco.MjSpec) -> Any:
    """Add the arm and its servos; returns the flange, a body whose z axis points out of the mounting face."""
    body = spec.worldbody.add_body(name="arm_base", pos=list(BASE))
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[0.0, 0.0, -0.25],
        size=[0.085, 0.25, 0.0],
        contype=0,
        conaffinity=0,
        group=ARM_SEEN,
        rgba=[0.35, 0.37, 0.40, 1.0],
    )
    position, alpha = (0.0, 0.0, 0.0), 0.0
    for link, name in zip(LINKS, joint_names(), strict=True):
        body = body.add_body(
            name=f"{name}_link",
            pos=list(position),
            quat=[math.cos(alpha / 2.0), math.sin(alpha / 2.0), 0.0, 0.0],
            gravcomp=1.0,
        )
        body.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=[0.0, 0.0, 1.0],
            range=[-2.0 * math.pi, 2.0 * math.pi],
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
            damping=[DAMPING, 0.0, 0.0],
            armature=0.1,
        )
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0.0, 0.0, 0.0, link.a, 0.0, link.d],
            size=[link.radius, 0.0, 0.0],
            mass=link.mass,
            contype=0,
            conaffinity=0,
            group=ARM_SEEN,
            rgba=[0.72, 0.75, 0.79, 1.0],
        )
        servo = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=link.kp, kv=link.kv)
        servo.forcerange = [-link.torque, link.torque]
        servo.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        position, alpha = (link.a, 0.0, link.d), link.alpha
    return body.add_body(name="flange", pos=list(position), gravcomp=1.0)
