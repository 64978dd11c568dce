"""Inverse kinematics of the arm by damped least squares, along straight lines of the tool."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from voa_fleet.world.frames import Floats, tool_rotation
from voa_fleet.world.scene import STEP_S, World
from voa_fleet.world.ur5e import DAMPING, LINKS
from voa_msgs.grasp_geometry import GraspGeometry

CONTROL_STEPS = 5
"""Physics steps between two commands: 10 ms."""
CONTROL_S = CONTROL_STEPS * STEP_S
APPROACH_M, APPROACH_S = 0.10, 0.45
LIFT_M, LIFT_S = 0.15, 0.70
CLEAR_M, DESCENT_M_S = 0.40, 0.30
"""Height of the tool over the table at which the arm moves from grasp to grasp, and its mean speed on the way down."""
STOP_M = 0.004
"""Position error of the tool at which the controller stops, as a UR's does when the arm meets resistance.

In free motion the error is below 2 mm; at the servos' stiffness 4 mm mean some 50 N."""

_DAMPING = 0.02
_LONGEST_STEP_RAD = 0.3
_EXACT_M, _EXACT_RAD = 1e-4, 1e-3
_ITERATIONS = 60
_ITERATIONS_NEARBY = 8
_JUMP_RAD = 0.3
"""Largest change of a joint between two commands; a larger one would mean that the arm turns over on the way."""
_RISE_M = 0.01
"""Step in which the height over the approach is searched that the arm can reach."""
_ELBOW = "arm3_link"
_LAG_S = np.array([(link.kv + DAMPING) / link.kp for link in LINKS])


@dataclass(frozen=True, eq=False)
class GraspPlan:
    """Joint angles of a grasp, one row per command.

    Attributes:
        descent: (j, 6), from high over the table straight down to 10 cm before the grasp, the hand turned as for it.
        approach: (k, 6), from 10 cm before the grasp to the grasp.
        lift: (l, 6), from the grasp to 15 cm above it.
    """

    descent: Floats
    approach: Floats
    lift: Floats


def plan_grasp(world: World, grasp: GraspGeometry) -> GraspPlan | None:
    """Plan the arm's motion to a grasp and up from it; None where the arm cannot reach it.

    Solutions are searched from a fixed list of start configurations, with the gripper either way round; the one with
    the highest elbow is returned. Equal worlds and grasps give equal plans.
    """
    data = mujoco.MjData(world.model)
    best = None
    for way in _ways(world, data, grasp):
        best = way
    if best is None:
        return None
    count = len(_smooth(APPROACH_S))
    descent = _descent(world, data, best.begin, best.rotation, best.joints[0])
    return GraspPlan(descent, best.joints[:count], best.joints[count:])


def is_reachable(world: World, grasp: GraspGeometry) -> bool:
    """True if the arm can move to a grasp and up from it; sooner known than its best plan."""
    return next(_ways(world, mujoco.MjData(world.model), grasp), None) is not None


@dataclass(frozen=True, eq=False)
class _Way:
    """Way to a grasp and up from it: joint angles (k, 6), the tool's first place (3,), and its rotation (3, 3)."""

    joints: Floats
    begin: Floats
    rotation: Floats


def _ways(world: World, data: mujoco.MjData, grasp: GraspGeometry) -> Iterator[_Way]:
    """Yield ways to a grasp and up from it, each with a higher elbow than the one before."""
    tip, approach = np.array(grasp.tool_centre_point), np.array(grasp.approach)
    forward = approach / np.linalg.norm(approach)
    up = np.array([0.0, 0.0, 1.0])
    highest = -math.inf
    for side in (1.0, -1.0):
        rotation = tool_rotation(approach, side * np.array(grasp.closing))
        for start in _starts(world, tip):
            before = _solve(world, data, tip - APPROACH_M * forward, rotation, start, _ITERATIONS)
            if before is None:
                continue
            height = float(data.body(_ELBOW).xpos[2])
            if height <= highest + 1e-3:
                continue
            way_in = [tip - APPROACH_M * (1.0 - share) * forward for share in _smooth(APPROACH_S)]
            way_up = [tip + LIFT_M * share * up for share in _smooth(LIFT_S)]
            joints = _follow(world, data, [*way_in, *way_up], rotation, before)
            if joints is not None:
                highest = height
                yield _Way(joints, tip - APPROACH_M * forward, rotation)


def _descent(world: World, data: mujoco.MjData, place: Floats, rotation: Floats, below: Floats) -> Floats:
    """Joint angles (j, 6) straight down to `below` (6,), at `place` (3,), from as high as the arm reaches there."""
    up = np.array([0.0, 0.0, 1.0])
    heights = np.arange(_RISE_M, CLEAR_M - float(place[2]), _RISE_M)
    height, joints = 0.0, below
    for candidate in heights:
        solution = _solve(world, data, place + candidate * up, rotation, joints, _ITERATIONS_NEARBY)
        if solution is None or np.abs(solution - joints).max() > _JUMP_RAD:
            break
        height, joints = float(candidate), solution
    way = [place + height * share * up for share in _smooth(height / DESCENT_M_S)]
    rows = _follow(world, data, way, rotation, below)
    return below[None] if rows is None else np.concatenate([below[None], rows])[::-1]


def commands(joints: Floats) -> Iterator[Floats]:
    """Yield a servo command (6,) for each row of joint angles (k, 6), with the speed fed forward against the lag."""
    speeds = np.gradient(joints, CONTROL_S, axis=0) if len(joints) > 1 else np.zeros_like(joints)
    yield from joints + speeds * _LAG_S


def joint_move(start: Floats, end: Floats, speed_rad_s: float) -> Floats:
    """Interpolate joint angles (k, 6) from `start` (6,) to `end` (6,), the widest joint at `speed_rad_s` on average."""
    seconds = max(float(np.abs(end - start).max()) / speed_rad_s, 2.0 * CONTROL_S)
    shares = np.array(_smooth(seconds))
    return start + shares[:, None] * (end - start)


def _smooth(seconds: float) -> list[float]:
    """Return shares of a path, one per command, that start and end at rest (minimum jerk); the last is 1."""
    count = max(1, round(seconds / CONTROL_S))
    return [s**3 * (10.0 - 15.0 * s + 6.0 * s**2) for s in ((k + 1) / count for k in range(count))]


def _starts(world: World, tip: Floats) -> list[Floats]:
    """Joint angles from which a solution is searched: shoulder towards the tip, elbow and wrist both ways."""
    base = world.model.body("arm_base").pos
    toward = math.atan2(float(tip[1] - base[1]), float(tip[0] - base[0])) + math.pi
    return [
        np.array([toward + turn, shoulder, elbow, wrist, roll, 0.0])
        for turn in (0.0, -0.4, 0.4)
        for shoulder, elbow, wrist in ((-2.0, 1.9, -1.5), (-1.2, -1.9, -1.5), (-2.2, 1.5, 0.7))
        for roll in (-math.pi / 2.0, math.pi / 2.0)
    ]


def _follow(world: World, data: mujoco.MjData, places: list[Floats], rotation: Floats, start: Floats) -> Floats | None:
    rows = []
    joints = start
    for place in places:
        solution = _solve(world, data, place, rotation, joints, _ITERATIONS_NEARBY)
        if solution is None or np.abs(solution - joints).max() > _JUMP_RAD:
            return None
        rows.append(solution)
        joints = solution
    return np.array(rows)


def _solve(
    world: World, data: mujoco.MjData, place: Floats, rotation: Floats, start: Floats, iterations: int
) -> Floats | None:
    """Joint angles (6,) with the tool at `place` (3,), turned by `rotation` (3, 3); None if there is no solution."""
    model = world.model
    joints = start.copy()
    jacobian = np.zeros((6, model.nv))
    damping = _DAMPING**2 * np.eye(6)
    for _ in range(iterations + 1):
        data.qpos[world.joints] = joints
        mujoco.mj_kinematics(model, data)
        error = _error(world, data, place, rotation)
        if _length(error[:3]) < _EXACT_M and _length(error[3:]) < _EXACT_RAD:
            return joints if np.abs(joints).max() < 2.0 * math.pi else None
        mujoco.mj_comPos(model, data)
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], world.tool)
        j = jacobian[:, world.speeds]
        step = j.T @ np.linalg.solve(j @ j.T + damping, error)
        joints = joints + np.clip(step, -_LONGEST_STEP_RAD, _LONGEST_STEP_RAD)
    return None


def _error(world: World, data: mujoco.MjData, place: Floats, rotation: Floats) -> Floats:
    """Remaining error of the tool's pose, (6,): metres, then a rotation vector in radians."""
    apart = rotation @ data.site_xmat[world.tool].reshape(3, 3).T
    axis = np.array([apart[2, 1] - apart[1, 2], apart[0, 2] - apart[2, 0], apart[1, 0] - apart[0, 1]])
    sine = _length(axis) / 2.0
    angle = math.atan2(sine, (float(apart[0, 0] + apart[1, 1] + apart[2, 2]) - 1.0) / 2.0)
    # At half a turn the axis is undefined; any axis leads away from there.
    turn = axis * (angle / (2.0 * sine)) if sine > 1e-9 else np.array([angle, 0.0, 0.0])
    return np.concatenate([place - data.site_xpos[world.tool], turn])


def _length(vector: Floats) -> float:
    """Length of a short vector; numpy's norm takes several times as long."""
    return math.sqrt(float(vector @ vector))
