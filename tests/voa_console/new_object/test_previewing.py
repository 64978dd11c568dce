"""Previews: which is to be made next, and which belong to the draft as it is."""

from dataclasses import replace

import pytest

from voa_console.new_object.draft import Draft
from voa_console.new_object.previewing import Previews
from voa_setup.previews.messages import Outlines, Plan, PlaneSight, RestsPreview

DRAFT = Draft(mesh="part.stl", confirmed=True)
RESTS = RestsPreview(size_m=(0.1, 0.1, 0.1), watertight=True, notes=[], rests=[]).model_dump_json()
PLANE = PlaneSight(height_m=0.02, seen=1.0, pairs=1.0, unseen=[])
PLAN = Plan(
    rests=[], notes=[], problem=None, places=[], planes=[PLANE], suggested=PLANE, chosen=PLANE, warnings=[]
).model_dump_json()
OUTLINES = Outlines(height_m=0.02, rests=[]).model_dump_json()


@pytest.fixture
def complete() -> Previews:
    previews = Previews()
    for step, result in (("rests", RESTS), ("plan", PLAN), ("outlines", OUTLINES)):
        assert previews.next_step(DRAFT) == step
        previews.keep(step, DRAFT, result)
    return previews


def test_previews_follow_one_another(complete: Previews) -> None:
    assert complete.next_step(DRAFT) is None
    assert complete.is_current("plan", DRAFT)


def test_nothing_is_made_before_the_size_is_confirmed_or_with_choices_out_of_limits() -> None:
    assert Previews().next_step(replace(DRAFT, confirmed=False)) is None
    assert Previews().next_step(replace(DRAFT, yaws=0)) is None


@pytest.mark.parametrize(
    ("change", "step"),
    [
        ({"scale": 0.5}, "rests"),
        ({"yaws": 3}, "plan"),
        ({"radius_m": 0.7}, "plan"),
        ({"grasps": 3}, None),
        ({"scores": "geometric"}, None),
    ],
)
def test_a_change_makes_again_what_depends_on_it(complete: Previews, change: dict[str, object], step: str) -> None:
    changed = replace(DRAFT, **change)  # type: ignore[arg-type] # fields of several types
    assert complete.next_step(changed) == step


def test_a_preview_that_failed_is_not_tried_again_for_the_same_choices(complete: Previews) -> None:
    other = replace(DRAFT, rests=("none",))
    complete.fail("plan", other, "There is no such rest.")
    assert complete.next_step(other) is None
    assert not complete.is_current("plan", other)
    assert complete.next_step(replace(DRAFT, rests=("upright",))) == "plan"


def test_the_scan_plane_is_the_suggestion_until_a_height_is_chosen(complete: Previews) -> None:
    assert complete.height_of(DRAFT) == 0.02
    assert complete.height_of(replace(DRAFT, height_m=0.03)) == 0.03
    assert Previews().height_of(DRAFT) is None
