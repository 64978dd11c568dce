"""The mug's mesh: what its maker makes, closed, and at rest where the scenario puts it."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.voa_assets.mugs import object_of
from voa_assets import path
from voa_assets.mug.make_mug import Mug, make, to_obj
from voa_core.geometry import matrices_of_quaternions
from voa_core.stable_poses import propose_stable_poses

MESH = path("mug/mug.obj")


def test_the_maker_makes_the_mesh_that_is_shipped() -> None:
    vertices, faces = make()
    shipped = trimesh.load_mesh(MESH, process=False)
    assert shipped.vertices.shape == vertices.shape
    assert shipped.faces.shape == faces.shape
    np.testing.assert_allclose(shipped.vertices, vertices, rtol=0.0, atol=1e-9)


def test_the_maker_makes_the_same_file_every_time() -> None:
    assert to_obj(*make()) == to_obj(*make())


def test_the_mesh_is_one_closed_body_of_the_measures_given() -> None:
    mug, mesh = Mug(), trimesh.load_mesh(MESH, process=False)
    assert object_of(MESH).watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert mesh.body_count == 1
    assert 800 <= len(mesh.faces) <= 1500
    tip = mug.radius - mug.wall / 2.0 + mug.handle_reach + mug.handle_radius
    np.testing.assert_allclose(
        mesh.bounds, [[-mug.radius, -mug.radius, 0.0], [tip, mug.radius, mug.height]], rtol=0.0, atol=1e-6
    )


def test_the_cup_is_empty_and_the_handle_stays_outside() -> None:
    mug, mesh = Mug(), trimesh.load_mesh(MESH, process=False)
    sides = (mug.radius - mug.wall) * np.cos(np.pi / mug.sections)  # the polygon's, nearer than its corners
    inside = np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]) < sides - 1e-6
    assert set(np.round(mesh.vertices[inside, 2], 6)) <= {0.0, mug.floor}


def test_half_a_turn_about_the_handle_maps_the_outside_of_the_mug_on_itself() -> None:
    vertices = object_of(MESH).vertices
    handle = vertices[vertices[:, 0] > Mug().radius + 1e-4]
    turned = np.array([0.0, 0.0, Mug().height]) + handle * np.array([1.0, -1.0, -1.0])
    apart = np.linalg.norm(turned[:, None] - handle[None], axis=2).min(axis=1)
    assert apart.max() < 2e-7


def test_other_measures_make_another_mug(tmp_path: Path) -> None:
    file = tmp_path / "mug.obj"
    file.write_text(to_obj(*make(Mug(height=0.08, sections=32))), encoding="utf-8")
    cup = object_of(file)
    assert cup.watertight
    assert cup.extents[2] == pytest.approx(0.08)


def test_the_mug_rests_in_four_ways_two_of_which_are_the_scenario_s() -> None:
    resting = propose_stable_poses(object_of(MESH))
    ups = matrices_of_quaternions(np.array([pose.quaternion_wxyz for pose in resting]))[:, 2]
    on_its_side = np.abs(ups[:, 2]) < 0.2
    assert len(resting) == 4
    assert on_its_side.tolist() == [True, True, False, False]
    np.testing.assert_allclose(ups[2:, 2], [1.0, -1.0], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose([pose.position[2] for pose in resting[2:]], [0.0, 0.095], rtol=0.0, atol=1e-6)
    assert sum(pose.probability for pose in resting) == pytest.approx(1.0)
