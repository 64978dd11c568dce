"""The page `look.html`: warnings first, then drawings and tables of all parts of a scenario."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from voa_fleet.show.page import Block, Items, Notice, Paragraph, write_page
from voa_fleet.world.meshes import Mesh
from voa_fleet.world.objects import GripperSetting
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import ScenarioRequest
from voa_setup.look.sections import grasps_section, outlines_section, places_section, rests_section
from voa_setup.look.shown import Shown, shown
from voa_setup.look.tables import poses_section, scores_section

LOOK = "look.html"
"""Name of the page in the folder of a scenario."""
_USUAL_GRIPPER = GripperSetting(opening_m=0.04, force_n=40.0)
"""Gripper whose fingers are drawn where none is stated."""


def write_look(
    folder: Path,
    scenario: ScenarioRequest,
    mesh: Mesh,
    ranking: Ranking | None,
    warnings: Sequence[str],
    notes: Sequence[str],
    *,
    gripper: GripperSetting = _USUAL_GRIPPER,
) -> Path:
    """Write the page on which a person sees if a scenario is right: one HTML file without scripts or other files.

    Equal arguments give equal bytes on one machine.

    Args:
        folder: of the scenario; the page is written into it.
        scenario: with poses, grasps, scores and places.
        mesh: in metres, in the object's frame.
        ranking: of the places under the prior; None: their values are not shown.
        warnings: probable mistakes in the scenario, a sentence each.
        notes: how the scenario was made, a sentence each.
        gripper: sizes of the fingers in the drawings of grasps.

    Returns:
        The path of the page.

    Raises:
        ValueError: no scan plane has a height, or a pose has no position or orientation.
        ValidationError: the `data` of a grasp has a geometry that does not follow the convention.
    """
    content = shown(scenario, mesh)
    file = folder / LOOK
    with tempfile.TemporaryDirectory(prefix="voa-look-") as temporary:
        drawings = Path(temporary)
        sections = [
            rests_section(content, drawings),
            outlines_section(content, drawings),
            grasps_section(content, gripper, drawings),
            scores_section(content),
            poses_section(content),
            places_section(content, ranking, drawings),
        ]
    write_page(file, f"{scenario.name}: is it right?", _lead(content, warnings, notes), sections, contents=True)
    return file


def _lead(content: Shown, warnings: Sequence[str], notes: Sequence[str]) -> list[Block]:
    """Warnings, the size of the scenario, and the notes."""
    scenario = content.scenario
    lidar = scenario.lidar.preset or "a lidar of its own"
    counts = (
        f"{_count(len(scenario.poses), 'pose')} in {_count(len(content.groups), 'way')} to rest, "
        f"{_count(len(scenario.grasps), 'grasp')}, {_count(len(scenario.sensors), 'place')} of {lidar}. "
        "Go through the drawings before a robot uses the scenario: a mistake here costs more later."
    )
    blocks: list[Block] = [Notice(text) for text in warnings]
    if not warnings:
        blocks.append(Paragraph("The checks of the service give no warning."))
    blocks.append(Paragraph(counts))
    return [*blocks, Items(notes)] if notes else blocks


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
