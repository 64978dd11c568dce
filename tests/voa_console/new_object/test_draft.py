"""Draft: defaults and files are those of `voa new`, and choices out of their limits are refused."""

import math
import shlex
from dataclasses import replace
from pathlib import Path

import pytest

from voa_cli.new.options import choices_of as choices_of_options
from voa_cli.new.options import read_options
from voa_console.new_object.draft import (
    GEOMETRIC,
    GRIPPERS,
    Draft,
    bearings_of,
    command_of,
    describe_size,
    file_name,
    first_draft,
    listed_places,
    place_name,
    problems_of,
    ring_bearings,
    size_cm,
    with_bearing,
)
from voa_console.new_object.tasks import choices_of
from voa_msgs.base import Message
from voa_setup import grippers
from voa_setup.choices import Choices
from voa_setup.mesh import ENDINGS
from voa_setup.places import ring
from voa_setup.previews.messages import MeshMeasure

PLAIN = Draft(mesh="part.stl")
MEASURE = MeshMeasure(name="part", faces=12, extents=(100.0, 40.0, 25.0), up="+Z", scales=[0.001])


def command(draft: Draft) -> Choices:
    """Choices of the command that the page shows."""
    words = shlex.split(command_of(draft, "build/part"))
    assert words[:2] == ["voa", "new"]
    return choices_of_options(read_options("", words[2:]))


def plain_lists(choices: Choices) -> Choices:
    """The choices with tuples and lists alike."""
    rests = None if choices.rests is None else list(choices.rests)
    return replace(choices, positions=list(choices.positions), rests=rests)


def test_the_defaults_are_those_of_the_command() -> None:
    expected = plain_lists(choices_of_options(read_options("", ["part.stl"])))
    assert plain_lists(choices_of(PLAIN)) == replace(expected, scale=1.0, up="+Z")
    assert tuple(ENDINGS) == file_name_endings()
    assert set(GRIPPERS) == set(grippers.GRIPPERS)


def file_name_endings() -> tuple[str, ...]:
    return tuple(ending for ending in ENDINGS if file_name(f"a.{ending}") == f"a.{ending}")


CHANGES = [
    {"scale": 0.001, "up": "+Y"},
    {"rests": ("upright", "on side A")},
    {"yaws": 3, "xy_m": 0.002, "yaw_deg": 1.5},
    {"places": 5, "radius_m": 0.6},
    {"bearings_deg": (0.0, 45.0, 137.0), "radius_m": 0.5},
    {"height_m": 0.0275, "lidar": "lds-01"},
    {"gripper": "0.05", "grasps": 4, "density_kg_m3": 800.0, "friction": 0.7},
    {"scores": GEOMETRIC},
    {"attempts": 3},
]


@pytest.mark.parametrize("change", CHANGES, ids="-".join)
def test_the_command_makes_the_choices_of_the_draft(change: dict[str, object]) -> None:
    draft = replace(PLAIN, **change)  # type: ignore[arg-type] # fields of several types
    assert plain_lists(choices_of(draft)) == plain_lists(command(draft))
    assert choices_of(draft) != choices_of(PLAIN)


def test_the_unit_in_which_an_arm_could_grasp_the_object_comes_first() -> None:
    assert first_draft(Path("x/part.stl"), MEASURE) == Draft(mesh="x/part.stl", scale=0.001)
    assert size_cm(MEASURE, 0.001, "+Z") == pytest.approx((10.0, 4.0, 2.5))
    assert size_cm(MEASURE, 0.001, "+Y") == pytest.approx((10.0, 2.5, 4.0))
    assert describe_size(MEASURE, 0.001, "+Z") == "10 cm wide, 4 cm deep, 2.5 cm high."
    assert "too large" in describe_size(MEASURE, 1.0, "+Z")
    assert "too small" in describe_size(MEASURE, 0.00001, "+Z")


@pytest.mark.parametrize(
    ("sent", "kept"),
    [
        ("bottle.STL", "bottle.stl"),
        ("../../etc/my bottle (2).obj", "my bottle _2_.obj"),
        ("C:\\meshes\\a.glb", "a.glb"),
        (".ply", "object.ply"),
        ("-rf.off", "rf.off"),
    ],
)
def test_the_name_of_a_file_is_harmless(sent: str, kept: str) -> None:
    assert file_name(sent) == kept


@pytest.mark.parametrize("sent", ["bottle.txt", "bottle", "bottle.stl.exe", ""])
def test_another_type_of_file_is_refused(sent: str) -> None:
    with pytest.raises(ValueError, match="expected a name that ends with stl, obj"):
        file_name(sent)


@pytest.mark.parametrize("count", [1, 3, 8, 16])
def test_an_even_ring_is_that_of_the_command(count: int) -> None:
    bearings = [math.degrees(math.atan2(place.y, place.x)) % 360.0 for place in ring(count, 0.45)]
    assert bearings == pytest.approx(ring_bearings(count), abs=1e-4)
    assert bearings_of(replace(PLAIN, places=count)) == ring_bearings(count)


def test_a_place_moves_along_the_circle_and_meets_no_other() -> None:
    moved = with_bearing(PLAIN, 0, 44.4, 0.45)
    assert moved.bearings_deg == (44.0, *ring_bearings(8)[1:])
    assert moved.radius_m == 0.45
    again = with_bearing(moved, 1, 44.0, 0.45)
    assert again.bearings_deg is not None
    assert again.bearings_deg[1] in (43.0, 45.0)
    assert [text.split(",")[0] for text in listed_places(moved)][:2] == ["at 44", "NNE"]
    east = replace(PLAIN, bearings_deg=(0.0,), radius_m=0.5)
    assert listed_places(east) == ["E,0.5,0,180"]
    assert place_name(337.5) == "ESE"
    with pytest.raises(ValueError, match="places that were moved"):
        listed_places(PLAIN)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"yaws": 0}, "number of yaws must lie between 1 and 360, got 0"),
        ({"rests": ()}, "Tick at least one rest"),
        ({"gripper": "0.3"}, "between 0 and 200 mm"),
        ({"gripper": "hand"}, "between 0 and 200 mm"),
        ({"height_m": -0.1}, "height of the scan plane"),
    ],
)
def test_choices_out_of_their_limits_are_sentences(change: dict[str, object], words: str) -> None:
    assert problems_of(PLAIN) == []
    (sentence,) = problems_of(replace(PLAIN, **change))  # type: ignore[arg-type] # fields of several types
    assert words in sentence


def test_a_draft_passes_to_the_process_unchanged() -> None:
    class Envelope(Message):
        draft: Draft

    draft = replace(PLAIN, rests=("upright",), bearings_deg=(1.0, 2.5), radius_m=0.4, up="+Y")
    assert Envelope.model_validate_json(Envelope(draft=draft).model_dump_json()).draft == draft
