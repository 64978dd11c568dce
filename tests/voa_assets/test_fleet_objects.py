"""The project's own objects: meshes as made, poses at rest, scores as measured, and what the best look depends on."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from tests.voa_assets.mugs import object_of, scenario_of
from voa_assets import path
from voa_assets.block import make_block
from voa_assets.coupling import make_coupling
from voa_assets.goblet import make_goblet
from voa_assets.make_obj import Mesh, obj_text
from voa_assets.mallet import make_mallet
from voa_core.filtering import Belief
from voa_core.ranking import Ranking, rank
from voa_core.scenario import Scenario
from voa_msgs.scenarios import ScenarioRequest

MAKERS: dict[str, Callable[[], Mesh]] = {
    "mallet": make_mallet.make,
    "block": make_block.make,
    "goblet": make_goblet.make,
    "coupling": make_coupling.make,
}
NAMES = list(MAKERS)


def mesh_file(name: str) -> Path:
    return path(f"{name}/{name}.obj")


def body_of(name: str) -> dict[str, Any]:
    body: dict[str, Any] = json.loads(path(f"{name}/scenario.json").read_text(encoding="utf-8"))
    return body


def ranking(scenario: Scenario, **believed: float) -> Ranking:
    belief = [believed.get(pose, 0.0) for pose in scenario.poses.names]
    return rank(
        scenario.sensors,
        lambda sensor: scenario.weigher(sensor, np.float64, keep=True),
        Belief.of(belief),
        scenario.table,
        scenario.policy,
    )


def voa_from(ranking: Ranking, sensor: str) -> float:
    return next(look.net_value for look in ranking.looks if look.sensor.name == sensor)


@pytest.mark.parametrize("name", NAMES)
def test_the_maker_makes_the_mesh_that_is_shipped(name: str) -> None:
    vertices, faces = MAKERS[name]()
    assert obj_text(name, vertices, faces) == mesh_file(name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_mesh_is_one_closed_body(name: str) -> None:
    mesh = trimesh.load_mesh(mesh_file(name), process=False)
    assert object_of(mesh_file(name)).watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.volume > 0.0


def test_the_measures_are_those_of_the_makers() -> None:
    block = make_block.Block()
    slots = block.depth * (block.width - block.rib) * (block.size - block.floor)
    assert trimesh.load_mesh(mesh_file("block")).volume == pytest.approx(block.size**3 - slots, rel=1e-6)
    mallet = make_mallet.Mallet()
    mesh = trimesh.load_mesh(mesh_file("mallet"))
    assert mesh.bounds[1][0] == pytest.approx(mallet.head[0] / 2.0 + mallet.handle_length, abs=1e-6)
    assert mesh.extents[1:] == pytest.approx(mallet.head[1:], abs=1e-6)
    goblet = make_goblet.Goblet()
    mesh = trimesh.load_mesh(mesh_file("goblet"))
    width = goblet.cup_width + goblet.fin_length
    assert mesh.extents == pytest.approx([width, goblet.cup_width, goblet.height], abs=1e-6)
    coupling = make_coupling.Coupling()
    mesh = trimesh.load_mesh(mesh_file("coupling"))
    length = coupling.narrow + 2.0 * coupling.fin_length
    assert mesh.extents == pytest.approx([length, coupling.wide, coupling.height], abs=1e-6)


@pytest.mark.parametrize("name", ["mug", *NAMES])
def test_every_pose_rests_on_the_table(name: str) -> None:
    scenario = scenario_of(path(f"{name}/scenario.json"))
    vertices = object_of(mesh_file(name)).vertices
    assert scenario.poses.rotations is not None
    assert scenario.poses.positions is not None
    for rotation, position in zip(scenario.poses.rotations, scenario.poses.positions, strict=True):
        assert (vertices @ rotation.T + position)[:, 2].min() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_the_service_s_message_takes_the_scenario(name: str) -> None:
    request = ScenarioRequest.model_validate(body_of(name))
    assert request.name == name
    assert request.object == f"{name}.obj"
    assert len(request.sensors) == 8


@pytest.mark.parametrize("name", NAMES)
def test_the_scan_plane_and_the_workspace_hold_every_pose(name: str) -> None:
    scenario = scenario_of(path(f"{name}/scenario.json"))
    box = body_of(name)["workspace"]
    for sensor in scenario.sensors:
        ranges = scenario.predictor.predict(sensor).dense()
        assert np.isfinite(ranges).any(axis=1).all()
        assert ranges[np.isfinite(ranges)].max() < scenario.rule.no_return_m
    vertices = object_of(mesh_file(name)).vertices
    assert scenario.poses.rotations is not None
    for rotation in scenario.poses.rotations:
        assert np.abs((vertices @ rotation.T)[:, :2]).max() < box["max"][0]


def test_the_handle_of_the_mallet_is_hidden_behind_its_head() -> None:
    scenario = scenario_of(path("mallet/scenario.json"))
    east, west = ranking(scenario, F_0=0.5, S_0=0.5), ranking(scenario, F_180=0.5, S_0=0.5)
    assert east.looks[0].net_value > 0.4
    assert west.looks[0].net_value > 0.4
    assert voa_from(east, "WNW") < 0.05
    assert voa_from(west, "ENE") < 0.05


def test_the_recess_of_the_block_is_seen_from_its_side_alone() -> None:
    scenario = scenario_of(path("block/scenario.json"))
    north_or_west = ranking(scenario, U_90=0.5, U_180=0.5)
    east_or_south = ranking(scenario, U_0=0.5, U_270=0.5)
    assert north_or_west.looks[0].sensor.name != east_or_south.looks[0].sensor.name
    assert voa_from(north_or_west, "SSE") < 0.05 < north_or_west.looks[0].net_value - 0.2
    assert voa_from(east_or_south, "NNW") < 0.05 < east_or_south.looks[0].net_value - 0.2
