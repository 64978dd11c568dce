"""The world: an arm with a UR5e's kinematics, objects of the right mass, solids where the mesh is."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import trimesh

from tests.support.fleet_objects import with_pieces
from tests.support.mesh_shapes import open_box, sheet
from voa_fleet.errors import UnstableSimulation
from voa_fleet.world.frames import Floats
from voa_fleet.world.gripper import PALM_M
from voa_fleet.world.groups import OBJECT_SEEN, OBJECT_TOUCHED
from voa_fleet.world.imperfections import room
from voa_fleet.world.meshes import Mesh, volume_of
from voa_fleet.world.object_poses import ObjectPose, scenario_pose
from voa_fleet.world.objects import OBJECTS, FleetObject
from voa_fleet.world.scene import World, build_world
from voa_fleet.world.ur5e import BASE
from voa_setup.pieces.shells import THICKNESS_M

# The manufacturer's published table: a, d, alpha.
UR5E = [
    (0.0, 0.1625, math.pi / 2.0),
    (-0.425, 0.0, 0.0),
    (-0.3922, 0.0, 0.0),
    (0.0, 0.1333, math.pi / 2.0),
    (0.0, 0.0997, -math.pi / 2.0),
    (0.0, 0.0996, 0.0),
]


def flange_by_hand(joints: Floats) -> Floats:
    """The product of the six Denavit-Hartenberg matrices, (4, 4)."""
    frame = np.eye(4)
    for angle, (a, d, alpha) in zip(joints, UR5E, strict=True):
        c, s, ca, sa = math.cos(angle), math.sin(angle), math.cos(alpha), math.sin(alpha)
        frame = frame @ np.array(
            [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0.0, sa, ca, d], [0.0, 0.0, 0.0, 1.0]]
        )
    return frame


@pytest.mark.parametrize("seed", range(5))
def test_the_tool_is_where_the_denavit_hartenberg_table_puts_it(mug_world: World, seed: int) -> None:
    joints = np.random.default_rng(seed).uniform(-3.0, 3.0, 6) if seed else np.zeros(6)
    data = mujoco.MjData(mug_world.model)
    data.qpos[mug_world.joints] = joints
    mujoco.mj_kinematics(mug_world.model, data)
    flange = flange_by_hand(joints)
    finger = mug_world.object.physics.gripper.finger_length_m
    tip = flange @ np.array([0.0, 0.0, PALM_M + finger, 1.0])
    np.testing.assert_allclose(data.site_xpos[mug_world.tool], tip[:3] + BASE, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(data.site_xmat[mug_world.tool].reshape(3, 3), flange[:3, :3], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", OBJECTS)
def test_an_object_weighs_its_volume_times_its_density(targets: dict[str, FleetObject], name: str) -> None:
    target = targets[name]
    world = build_world(target, arm=False)
    volume = trimesh.Trimesh(target.mesh.vertices, target.mesh.faces).volume
    assert world.model.body_mass[world.body] == pytest.approx(volume * target.physics.density_kg_m3, rel=1e-4)


def rays_against(world: World, group: int, places: Floats, directions: Floats) -> Floats:
    data = mujoco.MjData(world.model)
    mujoco.mj_kinematics(world.model, data)
    only = np.array([index == group for index in range(6)], dtype=np.uint8)
    hit = np.zeros(1, dtype=np.int32)
    ranges = [
        mujoco.mj_ray(world.model, data, place, way, only, 1, -1, hit, None)
        for place, way in zip(places, directions, strict=True)
    ]
    return np.array(ranges)


@pytest.mark.parametrize("name", OBJECTS)
def test_the_solids_are_where_the_mesh_is(targets: dict[str, FleetObject], name: str) -> None:
    target = targets[name]
    world = build_world(target, arm=False)
    rng = np.random.default_rng(7)
    corners = target.mesh.vertices[rng.choice(target.mesh.faces, 400)]
    aims = np.einsum("kc,kcx->kx", rng.dirichlet([1.0, 1.0, 1.0], 400), corners)
    outward = rng.standard_normal((400, 3))
    places = 0.4 * outward / np.linalg.norm(outward, axis=1, keepdims=True)
    ways = aims - places
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    mesh = rays_against(world, OBJECT_SEEN, places, ways)
    solids = rays_against(world, OBJECT_TOUCHED, places, ways)
    both = (mesh >= 0.0) & (solids >= 0.0)
    assert both.sum() > 300
    assert ((mesh >= 0.0) == (solids >= 0.0)).mean() > 0.95
    assert np.median(np.abs(mesh - solids)[both]) < 5e-4
    assert np.quantile(np.abs(mesh - solids)[both], 0.95) < 2e-3


@pytest.mark.parametrize("name", OBJECTS)
def test_an_object_that_rests_keeps_still(targets: dict[str, FleetObject], name: str) -> None:
    target = targets[name]
    world = build_world(target)
    data = mujoco.MjData(world.model)
    start = scenario_pose(target, target.poses[0])
    world.put_object(data, start)
    world.step(data, 500)
    assert np.abs(np.array(world.object_pose(data).position) - start.position).max() < 1e-3


@pytest.mark.parametrize("name", ["goblet", "coupling"])
def test_an_object_of_convex_pieces_keeps_still(targets: dict[str, FleetObject], name: str) -> None:
    target = with_pieces(targets[name])
    world = build_world(target)
    for pose in target.poses:
        data = mujoco.MjData(world.model)
        start = scenario_pose(target, pose)
        world.put_object(data, start)
        world.step(data, 300)
        middle = world.object_pose(data)
        world.step(data, 500)
        end = world.object_pose(data)
        assert np.abs(np.array(end.position) - start.position).max() < 1e-3
        assert np.abs(np.array(end.position) - middle.position).max() < 5e-5


@pytest.mark.parametrize(("mesh", "height"), [(open_box(), 0.05), (sheet(), 0.0)], ids=["open box", "sheet"])
def test_an_object_without_an_inside_weighs_as_much_as_its_shell_and_rests_on_it(
    targets: dict[str, FleetObject], mesh: Mesh, height: float
) -> None:
    target = with_pieces(replace(targets["block"], mesh=mesh))
    world = build_world(target, arm=False)
    volume = sum(volume_of(piece) for piece in target.hulls["hulls.obj"])
    expected = volume * target.physics.density_kg_m3
    assert world.model.body_mass[world.body] == pytest.approx(expected, rel=0.01)
    data = mujoco.MjData(world.model)
    world.put_object(data, ObjectPose((0.0, 0.0, height), (1.0, 0.0, 0.0, 0.0)))
    world.step(data, 500)
    assert world.object_pose(data).position == pytest.approx((0.0, 0.0, height + THICKNESS_M / 2.0), abs=1e-5)


def test_an_explosion_is_an_error_and_no_result(mug: FleetObject) -> None:
    world = build_world(mug, arm=False)
    data = mujoco.MjData(world.model)
    data.qvel[:] = 1e12
    with pytest.raises(UnstableSimulation, match="mug became unstable"):
        world.step(data, 5)


def test_clutter_and_robots_are_built_by_name(mug: FleetObject) -> None:
    world = build_world(mug, robots=("one", "two"), clutter=room(2.0))
    assert world.robots == ("one", "two")
    assert len(set(world.mocaps)) == 2
    assert world.model.geom("north").pos[1] == 2.0


def test_a_world_without_an_arm_has_none(mug: FleetObject) -> None:
    world = build_world(mug, arm=False)
    assert len(world.joints) == 0
    assert world.tool == -1
    assert world.model.nu == 0
