"""A MuJoCo model of the table, the object, and optionally an arm, lidar robots and clutter.

The contact settings were chosen by measurement: 2 ms steps, implicitfast, elliptic cones, an impedance ratio of 10
against creep. 5 ms steps are too long for the stiffness of a gripper's contacts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from voa_fleet.errors import UnstableSimulation
from voa_fleet.world.frames import Floats, matrix_of
from voa_fleet.world.gripper import FINGERS, SERVO, TOOL, add_gripper
from voa_fleet.world.groups import HAND_TABLE, HARD, OBJECT_SEEN, OBJECT_TABLE, STIFF, WORLD_SEEN
from voa_fleet.world.imperfections import Clutter
from voa_fleet.world.lidar_robot import HEIGHT_M, add_robot
from voa_fleet.world.meshes import encloses_volume
from voa_fleet.world.object_poses import ObjectPose
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.shapes import Hulls
from voa_fleet.world.solids import add_joint_hull, add_piece_meshes, add_solid
from voa_fleet.world.ur5e import add_arm, joint_names

STEP_S = 0.002
OBJECT = "object"
TABLE_HALF_M = 0.22
"""Half the side of the table with an arm: small enough for the robots to drive around it."""
DROP_TABLE_HALF_M = 0.75
"""Half the side of the table without an arm: large enough that no falling object rolls off."""
_COLOUR = (0.90, 0.62, 0.0, 1.0)  # orange of Okabe and Ito, which the colour-blind distinguish from grey


@dataclass(frozen=True, eq=False)
class World:
    """A compiled model, and the indices of its parts in MuJoCo's arrays. Read-only: threads may share it.

    Attributes:
        model: the model.
        object: the object on the table.
        robots: names of the lidar robots.
        body: index of the object's body.
        place: index in `qpos` at which the object's free joint begins.
        joints, speeds: indices of the arm in `qpos` and `qvel`, (6,); empty without an arm.
        servos: indices of the arm in `ctrl`, (6,).
        fingers: indices of the gripper in `qpos`, (2,).
        grip: index of the gripper in `ctrl`, or -1.
        tool: index of the site between the fingertips, or -1.
        mocaps: index of each robot in `mocap_pos`.
    """

    model: mujoco.MjModel
    object: FleetObject
    robots: tuple[str, ...]
    body: int
    place: int
    joints: NDArray[np.intp]
    speeds: NDArray[np.intp]
    servos: NDArray[np.intp]
    fingers: NDArray[np.intp]
    grip: int
    tool: int
    mocaps: tuple[int, ...]

    def put_object(self, data: mujoco.MjData, pose: ObjectPose) -> None:
        """Place the object at a pose, without motion."""
        data.qpos[self.place : self.place + 7] = [*pose.position, *pose.quaternion_wxyz]
        speed = self.model.jnt_dofadr[self.model.body_jntadr[self.body]]
        data.qvel[speed : speed + 6] = 0.0

    def object_pose(self, data: mujoco.MjData) -> ObjectPose:
        """Return the pose of the object's frame."""
        x, y, z, *quaternion = (float(number) for number in data.qpos[self.place : self.place + 7])
        w, i, j, k = quaternion
        return ObjectPose((x, y, z), (w, i, j, k))

    def up(self, data: mujoco.MjData) -> Floats:
        """Return the world's z axis in the object's frame, (3,), which shows how the object rests, whatever its yaw."""
        up: Floats = matrix_of(self.object_pose(data).quaternion_wxyz)[2]
        return up

    def step(self, data: mujoco.MjData, count: int) -> None:
        """Advance by `count` steps of 2 ms; raises UnstableSimulation where MuJoCo reports bad numbers."""
        mujoco.mj_step(self.model, data, nstep=count)
        bad = mujoco.mjtWarning.mjWARN_BADQACC, mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL
        if any(data.warning[int(kind)].number for kind in bad):
            raise UnstableSimulation(f"the simulation of {self.object.name} became unstable at {data.time:.3f} s")


def build_world(
    target: FleetObject, *, arm: bool = True, robots: Sequence[str] = (), clutter: Sequence[Clutter] = ()
) -> World:
    """Build a world around an object.

    Args:
        target: the object on the table.
        arm: True for an arm with the gripper that the object's physics describe.
        robots: names of the lidar robots.
        clutter: boxes that the lidar sees.
    """
    # Without this MuJoCo writes warnings to a file in the working directory; `World.step` raises them.
    mujoco.set_mju_user_warning(_no_log)
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep = STEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    _add_surroundings(spec, target.lidar_height_m, TABLE_HALF_M if arm else DROP_TABLE_HALF_M)
    _add_clutter(spec, clutter, target.lidar_height_m - HEIGHT_M)
    if arm:
        add_gripper(spec, add_arm(spec), target.physics.gripper)
    for name in robots:
        add_robot(spec, name, target.lidar_height_m)
    _add_object(spec, target)
    return _world(spec.compile(), target, tuple(robots), arm)


def _no_log(_warning: str) -> None:
    """Ignore a warning: MuJoCo counts them in MjData, and `World.step` reads that."""


def _add_surroundings(spec: mujoco.MjSpec, lidar_height_m: float, half_m: float) -> None:
    """Light, the table with its top at z = 0, and the floor as far below it as the robot's lidar needs."""
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1920, 1080
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97],
        rgb2=[0.62, 0.70, 0.78],
        width=64,
        height=384,
    )
    floor = lidar_height_m - HEIGHT_M
    world = spec.worldbody
    world.add_light(pos=[0.3, -0.6, 2.0], dir=[-0.15, 0.3, -1.0], diffuse=[0.6, 0.6, 0.6], castshadow=True)
    _add_support(
        world, "table", pos=[0.0, 0.0, floor / 2.0], size=[half_m, half_m, -floor / 2.0], rgba=[0.87, 0.86, 0.82, 1.0]
    )
    _add_support(world, "floor", pos=[0.0, 0.0, floor - 0.02], size=[3.0, 3.0, 0.02], rgba=[0.60, 0.63, 0.66, 1.0])


def _add_support(world: Any, name: str, **shape: list[float]) -> None:
    bits = HAND_TABLE | OBJECT_TABLE
    world.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        contype=bits,
        conaffinity=bits,
        friction=[1.0, 0.005, 0.0001],
        solref=list(STIFF),
        solimp=list(HARD),
        group=WORLD_SEEN,
        **shape,
    )


def _add_clutter(spec: mujoco.MjSpec, clutter: Sequence[Clutter], floor: float) -> None:
    for box in clutter:
        x, y = box.centre
        length, depth, height = box.size
        spec.worldbody.add_geom(
            name=box.name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[x, y, (floor + height) / 2.0],
            quat=[np.cos(box.yaw_rad / 2.0), 0.0, 0.0, np.sin(box.yaw_rad / 2.0)],
            size=[length / 2.0, depth / 2.0, (height - floor) / 2.0],
            contype=0,
            conaffinity=0,
            group=WORLD_SEEN,
            rgba=[0.55, 0.62, 0.68, 0.35],
        )


def _add_object(spec: mujoco.MjSpec, target: FleetObject) -> None:
    density = target.physics.density_kg_m3
    # A mesh that encloses no volume has no mass; its convex pieces have.
    heavy_pieces = bool(target.hulls) and not encloses_volume(target.mesh)
    inertia = mujoco.mjtMeshInertia
    spec.add_mesh(
        name=OBJECT,
        uservert=target.mesh.vertices.astype(np.float32).ravel(),
        userface=target.mesh.faces.ravel(),
        # The default computes six times the mass of a hollow mug.
        inertia=inertia.mjMESH_INERTIA_SHELL if heavy_pieces else inertia.mjMESH_INERTIA_EXACT,
    )
    body = spec.worldbody.add_body(name=OBJECT, pos=[0.0, 0.0, 0.0])
    body.add_freejoint(name=OBJECT)
    body.add_geom(
        name=OBJECT,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=OBJECT,
        density=0.0 if heavy_pieces else density,
        contype=0,
        conaffinity=0,
        group=OBJECT_SEEN,
        rgba=list(_COLOUR),
    )
    add_piece_meshes(spec, target.hulls)
    # A mesh that encloses no volume may be flat, and then has no hull; its pieces have.
    hull = add_joint_hull(spec, target.hulls) if heavy_pieces else OBJECT
    for solid in target.physics.solids:
        weighs = heavy_pieces and isinstance(solid, Hulls)
        add_solid(body, solid, target, hull, density if weighs else 0.0)


def _world(model: mujoco.MjModel, target: FleetObject, robots: tuple[str, ...], arm: bool) -> World:
    def ids(kind: Any, names: Sequence[str]) -> list[int]:
        return [mujoco.mj_name2id(model, kind, name) for name in names]

    joint = mujoco.mjtObj.mjOBJ_JOINT
    joints = ids(joint, joint_names() if arm else ())
    fingers = ids(joint, FINGERS if arm else ())
    servo = mujoco.mjtObj.mjOBJ_ACTUATOR
    (free,) = ids(joint, [OBJECT])
    (body,) = ids(mujoco.mjtObj.mjOBJ_BODY, [OBJECT])
    return World(
        model=model,
        object=target,
        robots=robots,
        body=body,
        place=int(model.jnt_qposadr[free]),
        joints=model.jnt_qposadr[joints].astype(np.intp),
        speeds=model.jnt_dofadr[joints].astype(np.intp),
        servos=np.array(ids(servo, joint_names() if arm else ()), dtype=np.intp),
        fingers=model.jnt_qposadr[fingers].astype(np.intp),
        grip=ids(servo, [SERVO])[0],
        tool=ids(mujoco.mjtObj.mjOBJ_SITE, [TOOL])[0],
        mocaps=tuple(int(model.body_mocapid[body]) for body in ids(mujoco.mjtObj.mjOBJ_BODY, robots)),
    )
