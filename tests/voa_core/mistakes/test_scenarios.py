"""Each slip gives its warning, with names and numbers; a scenario without a slip gives none."""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.voa_core.mistakes.table import (
    LIDAR,
    POSES,
    SOUTH,
    WEST,
    mistakes_of_table,
    moved,
    poses_at,
    scenario_of,
    wedge,
    with_y_up,
)
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.mistakes.effort import QUICK, THOROUGH, Effort
from voa_core.mistakes.heights import Mesh
from voa_core.mistakes.mistake import length, listed
from voa_core.mistakes.scenarios import mistakes_of_scenario
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor
from voa_core.workspace import Workspace


def lidar_with(**changed: Any) -> LidarModel:
    return LidarModel(**(vars(LIDAR) | changed))


@pytest.mark.parametrize("effort", [THOROUGH, QUICK], ids=["thorough", "quick"])
def test_where_all_is_well_nothing_is_said(effort: Effort) -> None:
    assert mistakes_of_table(effort) == {}


FLOATING = poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0021, 90.0), (0.05, 0.0, -0.0019, 200.0))
DEGREES = moved(WEST, name="D", yaw_rad=-90.0)
SLIPS: list[tuple[str, dict[str, Any], str, tuple[str, ...], tuple[str, ...]]] = [
    ("pose-height", {"poses": FLOATING}, r"pose 'P1' .* 2.1 mm over it", ("P1",), ()),
    (
        "pose-height",
        {"poses": poses_at((0.0, 0.0, -0.0021, 0.0))},
        r"pose 'P0' .* 2.1 mm under it",
        ("P0",),
        (),
    ),
    ("angle-in-degrees", {"sensors": (WEST, DEGREES)}, r"sensor 'D' .*-90 degrees are -1.571 rad", (), ("D",)),
    (
        "angle-in-degrees",
        {"lidar": lidar_with(grid=BeamGrid(360, 0.0, 1.0))},
        r"360 beams, 1 rad apart, go round 57.3 times",
        (),
        (),
    ),
    (
        "length-in-millimetres",
        {"poses": poses_at((0.0, 0.0, 0.0, 0.0), (50.0, 0.0, 0.0, 0.0)), "sensors": (moved(WEST, x=-500.0), SOUTH)},
        r"pose 'P1', sensor 'W' are more than 10 m",
        ("P1",),
        ("W",),
    ),
    (
        "length-in-millimetres",
        {"workspace": Workspace((-200.0, -200.0), (200.0, 200.0)), "lidar": lidar_with(height_m=20.0)},
        r"the lidar \(height_m\), the workspace",
        (),
        (),
    ),
    ("grasp-never-succeeds", {"scores": [[0.5] * 3, [0.0] * 3]}, r"grasp 'G1'", (), ()),
    ("no-workspace", {"workspace": None}, r"Give the box of the table", (), ()),
    (
        "place-inside-object",
        {"sensors": (moved(WEST, name="I", x=-0.02, y=-0.01), WEST)},
        r"sensor 'I' stands inside the object at pose 'P0'",
        ("P0",),
        ("I",),
    ),
    (
        "place-too-near",
        {"sensors": (moved(WEST, name="N", x=-0.15), SOUTH)},
        r"at pose 'P0' the object is 0.0\d+ m from sensor 'N', and the lidar measures from 0.12 m",
        ("P0",),
        ("N",),
    ),
    (
        "place-too-far",
        {"sensors": (moved(WEST, name="F", x=-4.5), SOUTH)},
        r"at pose 'P0' the object is 4.4\d m from sensor 'F', and the lidar measures up to 3.5 m.*\(2 more such pairs",
        ("P0", "P1", "P2"),
        ("F",),
    ),
    (
        "plane-misses-object",
        {"sensors": (moved(WEST, name="H", height_m=0.05), SOUTH)},
        r"scan plane of sensor 'H' \(at 0.05 m\) does not meet the object at poses 'P0', 'P1', 'P2'",
        ("P0", "P1", "P2"),
        ("H",),
    ),
    (
        "pose-never-seen",
        {"poses": poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, -0.05, 90.0))},
        r"pose 'P1'",
        ("P1",),
        (),
    ),
    (
        "place-sees-nothing",
        {
            "lidar": lidar_with(grid=BeamGrid(91, -math.pi / 4, math.radians(1.0))),
            "sensors": (WEST, moved(SOUTH, yaw_rad=-1.57)),
        },
        r"sensor 'S'",
        (),
        ("S",),
    ),
    (
        "workspace-misses-pose",
        {"workspace": Workspace((-0.2, -0.2), (0.08, 0.2))},
        r"pose 'P2' the object reaches out of the workspace, by \d\S* mm",
        ("P2",),
        (),
    ),
    (
        "twin-poses",
        {"poses": poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 90.0), (0.00005, 0.0, 0.0, 0.0))},
        r"poses 'P0', 'P2'",
        ("P0", "P2"),
        (),
    ),
]


@pytest.mark.parametrize("effort", [THOROUGH, QUICK], ids=["thorough", "quick"])
@pytest.mark.parametrize(
    ("kind", "slip", "says", "poses", "sensors"), SLIPS, ids=[f"{s[0]}-{i}" for i, s in enumerate(SLIPS)]
)
def test_a_slip_gives_its_warning(
    kind: str,
    slip: dict[str, Any],
    says: str,
    poses: tuple[str, ...],
    sensors: tuple[str, ...],
    effort: Effort,
) -> None:
    mistake = mistakes_of_table(effort, **slip)[kind]
    assert (mistake.poses, mistake.sensors) == (poses, sensors)
    assert re.search(says, mistake.detail), mistake.detail


def test_a_file_whose_y_axis_is_up_is_distinguished_from_one_that_was_turned_by_mistake() -> None:
    lying = with_y_up(wedge())
    assert "up=+Y" in mistakes_of_table(object_=lying)["up-axis"].detail
    turned = with_y_up(with_y_up(with_y_up(wedge())))
    assert "up=+Z" in mistakes_of_table(object_=turned, up="+Y")["up-axis"].detail
    # No warning proposes the axis that was stated.
    assert "up-axis" not in mistakes_of_table(object_=turned)
    assert "up-axis" not in mistakes_of_table(object_=lying, up="+Y")
    assert "up-axis" not in mistakes_of_table(poses=FLOATING)


def test_twins_have_equal_scores() -> None:
    twins = poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 360.0))
    assert mistakes_of_table(poses=twins)["twin-poses"].poses == ("P0", "P1")
    assert "twin-poses" not in mistakes_of_table(poses=twins, scores=[[0.5, 0.4], [0.25, 0.25]])
    apart = poses_at((0.0, 0.0, 0.0, 0.0), (0.0002, 0.0, 0.0, 0.0))
    assert "twin-poses" not in mistakes_of_table(poses=apart)


def of_data(ranges: Any) -> Any:
    """Two poses that are names alone, with predictions given for the only place."""
    base = scenario_of(poses=PoseSet.named(["A", "B"]), sensors=(WEST,), scores=[[0.5, 0.5]])
    data = ObservationPredictor(base.poses, LIDAR, {"W": np.array(ranges)})
    return replace(base, predictor=data)


def test_given_predictions_are_looked_at_too() -> None:
    seen, nothing = [0.5] + [math.inf] * 359, [math.inf] * 360
    assert mistakes_of_scenario(of_data([seen, seen]), None, THOROUGH) == ()
    kinds = {m.kind: m for m in mistakes_of_scenario(of_data([seen, nothing]), None, THOROUGH)}
    assert set(kinds) == {"pose-never-seen"}
    assert kinds["pose-never-seen"].poses == ("B",)
    kinds = {m.kind: m for m in mistakes_of_scenario(of_data([nothing, nothing]), None, THOROUGH)}
    assert set(kinds) == {"pose-never-seen", "place-sees-nothing"}
    # A mesh does not help poses that are names alone.
    assert mistakes_of_scenario(of_data([seen, seen]), Mesh(wedge()), QUICK) == ()
    # One of two places has neither predictions nor a height for the mesh.
    both = of_data([seen, seen])
    two = replace(both, sensors=(WEST, SOUTH), predictor=replace(both.predictor, lidar=lidar_with(height_m=None)))
    assert mistakes_of_scenario(two, Mesh(wedge()), QUICK) == ()
    # Nobody says how high the lidar is, and nobody has to where all predictions are data.
    placed = replace(scenario_of(sensors=(WEST,)), predictor=ObservationPredictor(POSES, lidar_with(height_m=None)))
    given = replace(placed.predictor, data={"W": np.array([seen] * 3)})
    assert mistakes_of_scenario(replace(placed, predictor=given), Mesh(wedge()), QUICK) == ()
    # Without a mesh, and without the predictions of its only place, nothing can be looked at.
    empty = of_data([seen, seen])
    blind = replace(empty, predictor=ObservationPredictor(empty.poses, LIDAR))
    assert mistakes_of_scenario(blind, None, THOROUGH) == ()


def many(count: int) -> PoseSet:
    return poses_at(*((0.02 * math.cos(i), 0.02 * math.sin(i), 0.0, 7.0 * i) for i in range(count)))


def around(count: int) -> tuple[SensorConfiguration, ...]:
    yaws = [2.0 * math.pi * a / count for a in range(count)]
    return tuple(
        SensorConfiguration(f"A{a}", -0.5 * math.cos(yaw), -0.5 * math.sin(yaw), yaw) for a, yaw in enumerate(yaws)
    )


def test_a_selection_stands_for_all_and_says_nothing_that_it_does_not_show() -> None:
    narrow = lidar_with(grid=BeamGrid(21, math.radians(-10.0), math.radians(1.0)))
    places = around(12)
    # Every other place looks away: the few places of a selection may be just those.
    askew = tuple(moved(place, yaw_rad=place.yaw_rad + math.pi * (a % 2 == 0)) for a, place in enumerate(places))
    selected = mistakes_of_table(replace(QUICK, pairs=40), poses=many(100), sensors=askew, lidar=narrow)
    whole = mistakes_of_table(poses=many(100), sensors=askew, lidar=narrow)
    assert "pose-never-seen" not in selected
    assert whole["place-sees-nothing"].sensors == tuple(place.name for place in askew[::2])
    if "place-sees-nothing" in selected:
        assert set(selected["place-sees-nothing"].sensors) <= set(whole["place-sees-nothing"].sensors)


def test_what_a_selection_leaves_open_is_looked_at_while_pairs_are_left() -> None:
    poses, places = many(30), around(6)
    away = moved(places[0], yaw_rad=places[0].yaw_rad + math.pi)
    narrow = lidar_with(grid=BeamGrid(21, math.radians(-10.0), math.radians(1.0)))
    few = mistakes_of_table(replace(QUICK, pairs=150), poses=poses, sensors=(away, *places[1:]), lidar=narrow)
    assert few["place-sees-nothing"].sensors == ("A0",)
    sunk = poses_at((0.0, 0.0, -0.05, 0.0), *((0.01 * i, 0.0, 0.0, 7.0 * i) for i in range(1, 10)))
    assert mistakes_of_table(replace(QUICK, pairs=50), poses=sunk, sensors=places)["pose-never-seen"].poses == ("P0",)
    assert "pose-never-seen" not in mistakes_of_table(replace(QUICK, pairs=6), poses=sunk, sensors=places)


def test_each_scan_plane_has_a_mistake_of_its_own() -> None:
    low, high = moved(WEST, name="low", height_m=0.02), moved(SOUTH, name="high", height_m=0.08)
    poses = poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.06, 90.0))
    mesh = Mesh(wedge())
    missed = [
        (mistake.sensors, mistake.poses)
        for mistake in mistakes_of_scenario(scenario_of(poses=poses, sensors=(low, high)), mesh, THOROUGH)
        if mistake.kind == "plane-misses-object"
    ]
    assert missed == [(("low",), ("P1",)), (("high",), ("P0",))]


def test_a_mesh_of_many_faces_at_many_tilts_is_cut_only_so_often() -> None:
    rolled = PoseSet.from_arrays(
        [f"P{i}" for i in range(40)],
        [[0.0, 0.0, 0.03]] * 40,
        [[math.cos(0.03 * i), math.sin(0.03 * i), 0.0, 0.0] for i in range(40)],
    )
    over = moved(WEST, name="over", height_m=0.5)
    assert len(mistakes_of_table(poses=rolled, sensors=(over,))["plane-misses-object"].poses) == 40
    once = mistakes_of_table(replace(QUICK, cut_faces=7000), poses=rolled, sensors=(over,))["plane-misses-object"]
    assert len(once.poses) == 1
    flat = many(40)
    assert (
        len(mistakes_of_table(replace(QUICK, cut_faces=7000), poses=flat, sensors=(over,))["plane-misses-object"].poses)
        == 40
    )
    dense = mistakes_of_table(replace(QUICK, contour_points=500 * 10), poses=flat, sensors=(over,))[
        "plane-misses-object"
    ]
    assert 1 < len(dense.poses) <= 10


def test_lengths_are_written_as_a_person_reads_them() -> None:
    assert (length(0.0021), length(49.79)) == ("2.1 mm", "49.79 m")


def test_a_long_list_of_names_is_cut() -> None:
    assert listed("pose", ["A"]) == "pose 'A'"
    assert listed("pose", list("ABCDEFG")) == "poses 'A', 'B', 'C', 'D', 'E' and 2 more"
