"""Sections of the page that are tables: the grasp scores, and the poses."""

from collections.abc import Callable

from voa_client.formatting import share
from voa_fleet.show.page import Block, Folded, Paragraph, Section, ShadedCell, ShadedTable, Table
from voa_msgs.scenarios import MeasuredScores
from voa_setup.look.scores import best_of, score, score_text
from voa_setup.look.shown import Shown

MOST_ROWS = 48
"""Rows of a table that are shown at once; the others are folded."""
_MOST_FOLDED = 500
"""Rows of a table that a page holds; the others are in the scenario file alone."""


def scores_section(content: Shown) -> Section:
    """Section with the scores of all grasps at all poses as shaded cells."""
    scenario = content.scenario
    if isinstance(scenario.scores, MeasuredScores):
        text = f"Successes of {scenario.scores.attempts} attempts of each grasp (columns) at each pose (rows)."
    else:
        text = "Probability that each grasp (columns) succeeds at each pose (rows), as the scenario states it."
    rows = [
        (
            pose.name,
            [
                ShadedCell(score_text(scenario, grasp, index), score(scenario, grasp, index))
                for grasp in range(len(scenario.grasps))
            ],
        )
        for index, pose in enumerate(scenario.poses)
    ]
    header = ("pose", *(grasp.name for grasp in scenario.grasps))
    tables = _in_parts(len(rows), lambda first, last: ShadedTable("", header, rows[first:last]))
    advice = (
        "A look helps only where different poses need different grasps. A column that is dark everywhere is a grasp "
        "that needs no look; a row without a dark cell is a pose at which no grasp works."
    )
    return Section("scores", "Grasp scores", (Paragraph(f"{text} {advice}"), *tables))


def poses_section(content: Shown) -> Section:
    """Section with the poses, their prior, and the best grasp at each."""
    scenario = content.scenario
    rest_of = {index: group.name for group in content.groups for index in group.poses}
    rows = []
    for index, pose in enumerate(scenario.poses):
        best = best_of([score(scenario, grasp, index) for grasp in range(len(scenario.grasps))])
        succeeds = score(scenario, best, index) > 0.0
        rows.append(
            (
                pose.name,
                rest_of[index],
                "-" if content.prior is None else share(content.prior[index], 3),
                f"{scenario.grasps[best].name}, {score_text(scenario, best, index)}" if succeeds else "none",
            )
        )
    header = ("pose", "rests", "prior", "best grasp there")
    tables = _in_parts(len(rows), lambda first, last: Table("", header, rows[first:last]))
    text = "The prior is the probability of each pose before the first look."
    if content.prior is None:
        text += " This scenario states it as a model, which the service evaluates."
    return Section("poses", "Poses", (Paragraph(text), *tables))


def _in_parts(rows: int, table: Callable[[int, int], Block]) -> list[Block]:
    """Show the first rows of a table of poses, fold those that follow, and count those that the page leaves out.

    Args:
        rows: number of rows.
        table: makes the table of the rows from an index to below another.
    """
    blocks = [table(0, MOST_ROWS)]
    if rows > MOST_ROWS:
        last = min(rows, _MOST_FOLDED)
        blocks.append(Folded(f"{last - MOST_ROWS} more poses", [table(MOST_ROWS, last)]))
    if rows > _MOST_FOLDED:
        blocks.append(Paragraph(f"The other {rows - _MOST_FOLDED} poses are in the scenario file alone."))
    return blocks
