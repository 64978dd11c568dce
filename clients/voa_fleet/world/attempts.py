"""Attempts of a grasp: settle, approach, close, lift, hold; an attempt succeeds if the object rises with the hand.

An attempt depends on its arguments alone, and its noise on (seed, pose, grasp, attempt) alone. So the results do not
depend on the order of attempts nor on the number of processes.
"""

import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from voa_fleet.world.frames import Floats
from voa_fleet.world.gripper import FINGERS
from voa_fleet.world.kinematics import CONTROL_S, CONTROL_STEPS, STOP_M, GraspPlan, commands
from voa_fleet.world.object_poses import ObjectPose
from voa_fleet.world.scene import OBJECT, World

Result = Literal[
    "lifted",
    "out of reach",
    "in the way",
    "stopped on approach",
    "nothing between the fingers",
    "not held",
    "slipped",
]
"""Results of an attempt; only `lifted` is a success.

| result                      | what happened                                                                     |
|-----------------------------|-----------------------------------------------------------------------------------|
| lifted                      | the object rose by more than 10 cm and stayed up                                  |
| out of reach                | the arm has no joint angles for the approach or the lift                          |
| in the way                  | the object is where the hand would begin its approach                             |
| stopped on approach         | the hand met something: the tool is more than 4 mm from where it should be        |
| nothing between the fingers | the fingers closed and touch nothing                                              |
| not held                    | a finger touched the object, but the object never was between the two             |
| slipped                     | the object was between the fingers, but did not rise with them or fell            |
"""

SUCCESS_M = 0.10
"""Rise of the object from which an attempt is a success."""
SETTLE_S, CLOSE_S, HOLD_S = 0.10, 0.30, 0.20
_SHUT_M = 0.0015
"""Gap between the fingers below which they hold nothing."""
_LEFT_BEHIND_M = 0.05
"""Distance between hand and object at which a lift is given up: the object no longer follows."""
_RAMP_S = 0.25
_SQUEEZE_M = 0.03
"""Distance past the middle to which closed fingers are commanded, so that the servo reaches its force."""

Watch = Callable[[mujoco.MjData], None]
"""Function that is called with the state whenever the scene has moved: to draw it, or to keep pace with a clock."""


@dataclass(frozen=True)
class Attempt:
    """An attempt of a grasp and its measurements.

    Attributes:
        result: end of the attempt.
        rise_m: by how much the object rose.
        tool_error_m: distance of the tool from the grasp at the end of the approach.
        gap_m: distance between the fingers after closing; the opening if they did not close.
    """

    result: Result
    rise_m: float = 0.0
    tool_error_m: float = 0.0
    gap_m: float = 0.0

    @property
    def success(self) -> bool:
        """True if the object was lifted."""
        return self.result == "lifted"


def attempt_rng(seed: int, pose: str, grasp: str, attempt: int) -> np.random.Generator:
    """Make the random generator of an attempt, which depends on names and numbers but not on their order."""
    return np.random.default_rng([seed, zlib.crc32(pose.encode()), zlib.crc32(grasp.encode()), attempt])


def attempt_grasp(world: World, plan: GraspPlan | None, pose: ObjectPose) -> Attempt:
    """Attempt a grasp in a new state of the world, with the object at `pose` and the arm where its approach begins.

    Args:
        world: with an arm.
        plan: of the arm's motion; None: the grasp is out of reach.
        pose: of the object.

    Raises:
        UnstableSimulation: the simulation became unstable.
    """
    if plan is None:
        return Attempt("out of reach")
    data = mujoco.MjData(world.model)
    world.put_object(data, pose)
    data.qpos[world.joints] = plan.approach[0]
    open_fingers(world, data)
    return perform(world, data, plan)


def open_fingers(world: World, data: mujoco.MjData) -> None:
    """Open the fingers as far as the object's gripper setting says, at once."""
    reach = world.object.physics.gripper.opening_m / 2.0
    data.qpos[world.fingers] = reach
    data.ctrl[world.grip] = reach


def perform(world: World, data: mujoco.MjData, plan: GraspPlan, watch: Watch | None = None) -> Attempt:
    """Attempt a grasp of the object where it lies, with the arm at the start of the approach.

    Object and arm stay where they are when the attempt ends.

    Raises:
        UnstableSimulation: the simulation became unstable.
    """
    opening = world.object.physics.gripper.opening_m
    mujoco.mj_forward(world.model, data)
    if touching(world, data):
        return Attempt("in the way", gap_m=opening)
    _hold(world, data, plan.approach[0], SETTLE_S, watch)
    if touching(world, data):
        return Attempt("in the way", gap_m=opening)
    resting = float(data.xpos[world.body][2])
    _move(world, data, plan.approach, watch)
    error = _tool_error(world, data, plan.approach[-1])
    if error > STOP_M:
        return Attempt("stopped on approach", tool_error_m=error, gap_m=opening)
    _close(world, data, plan.approach[-1], watch)
    gap, fingers = max(0.0, float(data.qpos[world.fingers].sum())), touching(world, data)
    if not fingers:
        return Attempt("nothing between the fingers", 0.0, error, gap)
    between = fingers >= set(FINGERS) and gap > _SHUT_M
    _lift(world, data, plan.lift, resting, watch)
    rise = float(data.xpos[world.body][2]) - resting
    if rise > SUCCESS_M:
        return Attempt("lifted", rise, error, gap)
    return Attempt("slipped" if between else "not held", rise, error, gap)


def touching(world: World, data: mujoco.MjData) -> set[str]:
    """Return the names of the hand's bodies that touch the object."""
    model = world.model
    bodies_in_contact = set()
    for pair in data.contact.geom:
        bodies = [model.body(int(model.geom_bodyid[geom])).name for geom in pair]
        if OBJECT in bodies:
            bodies_in_contact |= set(bodies) - {OBJECT, "world"}
    return bodies_in_contact


def _run(world: World, data: mujoco.MjData, rows: Iterable[Floats], watch: Watch | None) -> Iterator[None]:
    for row in rows:
        data.ctrl[world.servos] = row
        world.step(data, CONTROL_STEPS)
        if watch is not None:
            watch(data)
        yield


def _move(world: World, data: mujoco.MjData, joints: Floats, watch: Watch | None) -> None:
    for _ in _run(world, data, commands(joints), watch):
        pass


def _hold(world: World, data: mujoco.MjData, joints: Floats, seconds: float, watch: Watch | None) -> None:
    _move(world, data, np.repeat(joints[None], round(seconds / CONTROL_S), axis=0), watch)


def _close(world: World, data: mujoco.MjData, joints: Floats, watch: Watch | None) -> None:
    """Close at an even speed, until the servo squeezes with all its force."""
    reach = world.object.physics.gripper.opening_m / 2.0
    count = round(CLOSE_S / CONTROL_S)
    grip = np.clip(1.0 - (np.arange(count) + 1) * CONTROL_S / _RAMP_S, 0.0, 1.0) * (reach + _SQUEEZE_M) - _SQUEEZE_M
    moving = _run(world, data, np.repeat(joints[None], count, axis=0), watch)
    for aim in grip:
        data.ctrl[world.grip] = aim
        next(moving)


def _lift(world: World, data: mujoco.MjData, joints: Floats, resting: float, watch: Watch | None) -> None:
    """Lift and hold; end as soon as the object stays behind."""
    start = float(data.site_xpos[world.tool][2])
    rows = [*commands(joints), *np.repeat(joints[-1:], round(HOLD_S / CONTROL_S), axis=0)]
    for _ in _run(world, data, rows, watch):
        up = float(data.site_xpos[world.tool][2]) - start
        if up - (float(data.xpos[world.body][2]) - resting) > _LEFT_BEHIND_M:
            return


def _tool_error(world: World, data: mujoco.MjData, joints: Floats) -> float:
    """Distance of the tool from where these joint angles (6,) would put it, metres."""
    wanted = mujoco.MjData(world.model)
    wanted.qpos[world.joints] = joints
    mujoco.mj_kinematics(world.model, wanted)
    return float(np.linalg.norm(wanted.site_xpos[world.tool] - data.site_xpos[world.tool]))
