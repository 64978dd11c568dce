"""Fixtures of objects and worlds that many tests share: building them takes longer than using them.

A folder's conftest.py imports those that its tests use.
"""

from dataclasses import replace

import pytest

from voa_fleet.world.kinematics import GraspPlan, plan_grasp
from voa_fleet.world.objects import OBJECTS, FleetObject, named_object
from voa_fleet.world.scene import World, build_world
from voa_setup.hulls import collision_solids, convex_pieces


@pytest.fixture(scope="session")
def targets() -> dict[str, FleetObject]:
    """The project's objects, by name."""
    return {name: named_object(name) for name in OBJECTS}


@pytest.fixture(scope="session")
def mug(targets: dict[str, FleetObject]) -> FleetObject:
    """The mug."""
    return targets["mug"]


def with_pieces(target: FleetObject) -> FleetObject:
    """An object that collides by convex pieces of its mesh instead of its own solids."""
    physics = target.physics.model_copy(update={"solids": collision_solids("hulls.obj")})
    return replace(target, physics=physics, hulls={"hulls.obj": tuple(convex_pieces(target.mesh))})


@pytest.fixture(scope="session")
def mug_world(mug: FleetObject) -> World:
    """A world with the mug and an arm."""
    return build_world(mug)


@pytest.fixture(scope="session")
def mug_plans(mug: FleetObject, mug_world: World) -> dict[str, GraspPlan]:
    """Plans of the mug's grasps that are within reach, by name."""
    plans = {grasp: plan_grasp(mug_world, mug.grasp(grasp)) for grasp in mug.grasps}
    return {grasp: plan for grasp, plan in plans.items() if plan is not None}
