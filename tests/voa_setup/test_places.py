"""Places and heights: the ring, lists of places, and refusals that name what would work."""

import math
from pathlib import Path

import pytest

from tests.support.meshes import box, mug, setup_mesh, stable_poses
from voa_assets import lidar_presets
from voa_msgs.lidars import LidarPreset
from voa_msgs.scenarios import Pose
from voa_setup.errors import InvalidOption
from voa_setup.heights import check_height, describe_height, sights, suggested
from voa_setup.mesh import SetupMesh
from voa_setup.places import check_places, fitting_radius, listed_places, read_places, ring
from voa_setup.poses import even_yaws, make_poses


@pytest.fixture(scope="module")
def lidar() -> LidarPreset:
    return LidarPreset.model_validate(lidar_presets()["lds-02"])


@pytest.fixture(scope="module")
def mug_mesh(tmp_path_factory: pytest.TempPathFactory) -> SetupMesh:
    return setup_mesh(mug(), tmp_path_factory.mktemp("mug"))


@pytest.fixture(scope="module")
def upright(mug_mesh: SetupMesh) -> list[Pose]:
    poses = make_poses(mug_mesh, stable_poses(mug_mesh), yaws_deg=even_yaws(8)).poses
    return [pose for pose in poses if pose.name.startswith("upright")]


def test_the_places_of_a_ring_face_its_middle() -> None:
    places = ring(8, 0.45, (0.1, 0.0))
    assert [place.name for place in places] == ["ENE", "NNE", "NNW", "WNW", "WSW", "SSW", "SSE", "ESE"]
    for place in places:
        assert math.hypot(place.x - 0.1, place.y) == pytest.approx(0.45, abs=1e-5)
        ahead = place.x + 0.45 * math.cos(place.yaw_rad), place.y + 0.45 * math.sin(place.yaw_rad)
        assert ahead == pytest.approx((0.1, 0.0), abs=1e-5)
    assert [place.name for place in ring(4, 0.4)] == ["NE", "NW", "SW", "SE"]
    assert [place.name for place in ring(3, 0.4)] == ["at 0", "at 120", "at 240"]


def test_listed_places_are_read_from_options_and_files(tmp_path: Path) -> None:
    file = tmp_path / "places.csv"
    file.write_text("name, x, y, yaw_deg\n# by the door\nE, 0.45, 0, 180\n\nN,0,0.5,-90\n")
    places = read_places(file)
    assert places == listed_places(["E,0.45,0,180", "N,0,0.5,-90"])
    assert [(place.name, place.x, place.y) for place in places] == [("E", 0.45, 0.0), ("N", 0.0, 0.5)]
    assert places[1].yaw_rad == pytest.approx(-math.pi / 2, abs=1e-6)
    for texts, words in {
        ("E,0.45,0",): "NAME,X,Y,YAW_DEG",
        ("E,0.45,0,west",): "got 'E,0.45,0,west'",
        ("E,1,0,0", "E,0,1,0"): "'E' twice",
    }.items():
        with pytest.raises(InvalidOption, match=words):
            listed_places(texts)
    file.write_text("name,x,y,yaw_deg\n")
    with pytest.raises(InvalidOption, match="lists no places"):
        read_places(file)


def test_a_radius_that_does_not_fit_is_refused_with_one_that_does(
    mug_mesh: SetupMesh, upright: list[Pose], lidar: LidarPreset
) -> None:
    with pytest.raises(InvalidOption, match=r"measures from 0.16 m on: state --radius 0.23 or more"):
        fitting_radius(0.1, mug_mesh, upright, lidar, (0.0, 0.0))
    with pytest.raises(InvalidOption, match=r"measures up to 8 m: state at most 7\.9"):
        fitting_radius(9.0, mug_mesh, upright, lidar, (0.0, 0.0))
    assert fitting_radius(None, mug_mesh, upright, lidar, (0.0, 0.0)) == 0.45
    check_places(ring(8, fitting_radius(0.23, mug_mesh, upright, lidar, (0.0, 0.0))), mug_mesh, upright, lidar)
    with pytest.raises(InvalidOption, match=r"place 'near' stands 0.*m from the object at pose 'upright .*: move it"):
        check_places(listed_places(["near,0.2,0,180"]), mug_mesh, upright, lidar)


def test_the_suggested_height_sees_every_pose_and_distinguishes_most_pairs(
    tmp_path: Path, mug_mesh: SetupMesh, lidar: LidarPreset
) -> None:
    poses = make_poses(mug_mesh, stable_poses(mug_mesh), yaws_deg=even_yaws(4))
    candidates = sights(mug_mesh, poses.poses, poses.prior, ring(8, 0.45), lidar)
    best = suggested(candidates)
    assert best.unseen == ()
    assert best.pairs >= max(each.pairs for each in candidates if not each.unseen) - 0.02
    assert 0.02 <= best.height_m <= 0.075  # the handle's, and below the lying mug's top
    # A flat part: only planes below its top see it.
    plate = setup_mesh(box(0.1, 0.06, 0.008), tmp_path)
    lying = make_poses(plate, stable_poses(plate), yaws_deg=[0.0, 45.0], least_probability=0.3)
    flat = sights(plate, lying.poses, lying.prior, ring(8, 0.45), lidar)
    assert 0.0 < suggested(flat).height_m < 0.008


def test_a_height_that_sees_nothing_is_refused_with_those_that_see(
    mug_mesh: SetupMesh, upright: list[Pose], lidar: LidarPreset
) -> None:
    prior, places = [1 / 8] * 8, ring(8, 0.45)
    candidates = sights(mug_mesh, upright, prior, places, lidar)
    high = sights(mug_mesh, upright, prior, places, lidar, [0.2])[0]
    assert (high.seen, len(high.unseen)) == (0.0, 8)
    with pytest.raises(
        InvalidOption, match=r"--height 0.2: .* sees the object from 0.01 to 0.0.* suggestion is --height"
    ):
        check_height(high, candidates)
    low = sights(mug_mesh, upright, prior, places, lidar, [0.095])[0]
    check_height(low, candidates)
    assert "; with --height 0.0" in describe_height(low, suggested(candidates))
    assert "; with --height" not in describe_height(suggested(candidates), suggested(candidates))
