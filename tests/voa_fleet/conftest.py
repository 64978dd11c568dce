"""Objects and worlds that many tests share: building them takes longer than using them."""

import pytest

from voa_fleet.world.kinematics import GraspPlan, plan_grasp
from voa_fleet.world.objects import OBJECTS, FleetObject, named_object
from voa_fleet.world.scene import World, build_world


@pytest.fixture(scope="session")
def targets() -> dict[str, FleetObject]:
    return {name: named_object(name) for name in OBJECTS}


@pytest.fixture(scope="session")
def mug(targets: dict[str, FleetObject]) -> FleetObject:
    return targets["mug"]


@pytest.fixture(scope="session")
def mug_world(mug: FleetObject) -> World:
    return build_world(mug)


@pytest.fixture(scope="session")
def mug_plans(mug: FleetObject, mug_world: World) -> dict[str, GraspPlan]:
    plans = {grasp: plan_grasp(mug_world, mug.grasp(grasp)) for grasp in mug.grasps}
    return {grasp: plan for grasp, plan in plans.items() if plan is not None}
