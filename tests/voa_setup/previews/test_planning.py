"""Plan: poses, places and scan planes as `voa new` makes them, with what cannot be used in a sentence."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.meshes import box, setup_mesh, stable_poses
from voa_client import Client
from voa_msgs.lidars import LidarPreset
from voa_msgs.objects import StablePose
from voa_setup.choices import Choices
from voa_setup.errors import InvalidOption
from voa_setup.mesh import SetupMesh
from voa_setup.previews.planning import preview_outlines, preview_plan
from voa_setup.steps import chosen_height, chosen_places, chosen_poses, preset_named


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> SetupMesh:
    return setup_mesh(box(0.10, 0.05, 0.03), tmp_path_factory.mktemp("mesh"))


@pytest.fixture(scope="module")
def stable(mesh: SetupMesh) -> list[StablePose]:
    return stable_poses(mesh)


@pytest.fixture(scope="module")
def lidar(process: str) -> LidarPreset:
    with Client(process) as client:
        return preset_named(client, "lds-02")


CHOICES = Choices(Path("part.stl"), yaws_deg=(0.0, 90.0), places=4)


def test_a_plan_shows_the_poses_places_and_height_of_the_scenario(
    mesh: SetupMesh, stable: list[StablePose], lidar: LidarPreset
) -> None:
    plan = preview_plan(CHOICES, mesh, stable, lidar)
    poses = chosen_poses(CHOICES, mesh, stable)
    places = chosen_places(CHOICES, mesh, poses, lidar)
    assert [name for rest in plan.rests for name in rest.poses] == [pose.name for pose in poses.poses]
    assert sum(rest.share for rest in plan.rests) == pytest.approx(1.0)
    assert [(place.name, place.x, place.y) for place in plan.places] == [(p.name, p.x, p.y) for p in places]
    assert plan.chosen == plan.suggested
    assert plan.chosen is not None
    assert plan.chosen.height_m == chosen_height(CHOICES, mesh, poses, places, lidar)[0]
    assert (plan.problem, plan.warnings) == (None, [])
    assert plan.notes == poses.merged + poses.left_out


def test_a_plane_over_flat_rests_warns_as_the_service_does(
    mesh: SetupMesh, stable: list[StablePose], lidar: LidarPreset
) -> None:
    plan = preview_plan(replace(CHOICES, height_m=0.06), mesh, stable, lidar)
    assert plan.problem is None
    assert plan.chosen is not None
    assert plan.chosen.unseen
    assert any("does not meet the object at pose" in warning for warning in plan.warnings)


@pytest.mark.parametrize(
    ("change", "words"),
    [({"height_m": 0.5}, "misses the object at every pose"), ({"radius_m": 0.05}, "--radius 0.05: the object reaches")],
)
def test_a_choice_that_cannot_be_used_is_a_sentence(
    mesh: SetupMesh, stable: list[StablePose], lidar: LidarPreset, change: dict[str, float], words: str
) -> None:
    plan = preview_plan(replace(CHOICES, **change), mesh, stable, lidar)  # type: ignore[arg-type] # fields of several types
    assert plan.problem is not None
    assert words in plan.problem
    assert plan.rests


def test_the_outlines_are_those_of_the_kept_rests(mesh: SetupMesh, stable: list[StablePose]) -> None:
    kept = replace(CHOICES, rests=("on side B", "upright"))
    high = preview_outlines(kept, mesh, stable, 0.06)
    assert {rest.rest: bool(rest.path) for rest in high.rests} == {"upright": False, "on side B": True}
    low = preview_outlines(kept, mesh, stable, 0.01)
    assert "L50 25" in low.rests[0].path or "M50 25" in low.rests[0].path
    assert "50.0 25.0" in low.rests[0].shadow
    with pytest.raises(InvalidOption, match="there is no rest 'upside down'"):
        preview_outlines(replace(CHOICES, rests=("upside down",)), mesh, stable, 0.01)
