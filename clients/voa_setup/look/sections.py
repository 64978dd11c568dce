"""Sections of the page that are drawings: how the object lies, what the lidar sees, grasps and places."""

import math
from itertools import cycle
from pathlib import Path

from voa_client.formatting import share, signed, unsigned, with_error
from voa_fleet.show.page import Abreast, Block, Paragraph, Picture, Section, Table
from voa_fleet.world.objects import GripperSetting
from voa_msgs.grasp_geometry import grasp_geometry
from voa_msgs.rankings import Look, RankedSensor, Ranking
from voa_setup.look.drawings import draw_grasp, draw_outlines, draw_places, draw_rest
from voa_setup.look.groups import PoseGroup
from voa_setup.look.outlines import placed
from voa_setup.look.panels import HEIGHT_COLOUR_NAMES
from voa_setup.look.scores import best_of, score, score_in_words
from voa_setup.look.shown import Shown
from voa_setup.look.tables import MOST_ROWS

_MOST_PICTURES = 24
"""Most rests, and most grasps, that are drawn; the others are named."""
_MOST_OUTLINES = 96


def rests_section(content: Shown, folder: Path) -> Section:
    """Section with a drawing of each way in which the object rests, from the front and from above."""
    pictures = []
    for number, group in enumerate(content.groups[:_MOST_PICTURES]):
        index = group.poses[0]
        file = folder / f"rest-{number}.png"
        draw_rest(file, placed(content.mesh, content.scenario.poses[index]), content.heights_m, content.outlines[index])
        pictures.append(Picture(file, _rest_caption(content, group)))
    text = (
        "Does the object lie on your table like this? The dashed line is the scan plane of the lidar: "
        f"{_planes(content)} above the table. From above, the line of that colour is what the lidar can see of it."
    )
    return Section("rests", "How it lies", (Paragraph(text), Abreast(pictures), *_left_out(content)))


def _planes(content: Shown) -> str:
    """List the heights of the scan planes with the colours in which they are drawn."""
    named = zip(content.heights_m, cycle(HEIGHT_COLOUR_NAMES), strict=False)
    return ", ".join(f"{_mm(height)} ({colour})" for height, colour in named)


def _left_out(content: Shown) -> list[Block]:
    names = [group.name for group in content.groups[_MOST_PICTURES:]]
    return [Paragraph(f"Not drawn: {', '.join(names)}.")] if names else []


def _rest_caption(content: Shown, group: PoseGroup) -> str:
    """Write the poses of a rest, their prior, and where the scan plane misses the object."""
    names = [content.scenario.poses[index].name for index in group.poses]
    poses = f"{group.name}: drawn at {names[0]}" if len(names) > 1 else f"{names[0]}"
    others = f"; also {', '.join(names[1:])}" if len(names) > 1 else ""
    text = f"{poses}{others}"
    if content.prior is not None:
        text += f". Probability before a look: {share(sum(content.prior[index] for index in group.poses))}"
    unseen = [content.scenario.poses[index].name for index in group.poses if not any(map(len, content.outlines[index]))]
    return text + (f". The lidar sees nothing of the object at {', '.join(unseen)}." if unseen else ".")


def outlines_section(content: Shown, folder: Path) -> Section:
    """Section with the outline that the lidar sees at each pose."""
    names = [pose.name for pose in content.scenario.poses][:_MOST_OUTLINES]
    file = folder / "outlines.png"
    draw_outlines(file, names, content.outlines[:_MOST_OUTLINES])
    text = (
        f"The object at each pose, cut by the scan plane at {_planes(content)} and seen from above, all in one scale; "
        "the cross is the world's origin. No scan can distinguish poses with the same outline; that matters only where "
        "the best grasps differ."
    )
    more = len(content.scenario.poses) - len(names)
    rest = [Paragraph(f"The other {more} poses are not drawn.")] if more else []
    return Section("outlines", "What the lidar sees", (Paragraph(text), Picture(file, "Outlines by pose."), *rest))


def grasps_section(content: Shown, gripper: GripperSetting, folder: Path) -> Section:
    """Section with a drawing of each grasp, on the object at the pose where it succeeds most often."""
    pictures: list[Picture] = []
    unknown: list[str] = []
    for number, grasp in enumerate(content.scenario.grasps):
        geometry = grasp_geometry(grasp.data)
        if geometry is None:
            unknown.append(grasp.name)
            continue
        if len(pictures) == _MOST_PICTURES:
            continue
        index = best_of([score(content.scenario, number, pose) for pose in range(len(content.scenario.poses))])
        file = folder / f"grasp-{number}.png"
        draw_grasp(file, placed(content.mesh, content.scenario.poses[index]), geometry, gripper)
        where = f"{grasp.name} at {content.scenario.poses[index].name}"
        pictures.append(Picture(file, f"{where}: {score_in_words(content.scenario, number, index)}."))
    blocks: list[Block] = []
    if pictures:
        text = (
            "Each grasp on the object at the pose where it succeeds most often: two fingers (orange) that have closed, "
            "and the approach (arrow; a crossed circle where it points away from you). A grasp stays where it is when "
            "the object lies in another pose. Do the fingers touch what they should, and nothing else?"
        )
        blocks = [Paragraph(text), Abreast(pictures)]
        more = len(content.scenario.grasps) - len(unknown) - len(pictures)
        blocks += [Paragraph(f"{more} more grasps are not drawn.")] if more else []
    if unknown:
        text = (
            "Not drawn, because their `data` in the scenario has no geometry (tool_centre_point, approach, closing): "
        )
        blocks.append(Paragraph(f"{text}{', '.join(unknown)}."))
    return Section("grasps", "Grasps", blocks)


def places_section(content: Shown, ranking: Ranking | None, folder: Path) -> Section:
    """Section with the places around the table and the value of a look from each."""
    file = folder / "places.png"
    draw_places(file, content.scenario, content.outlines[:_MOST_OUTLINES], ranking)
    intro = "The places of the lidar, seen from above, with the object in the middle. Can the robot stand there? "
    if ranking is None:
        return Section("places", "Places", (Paragraph(f"{intro}No ranking was computed."), Picture(file, "Places.")))
    value = (
        "The area of a disc is the Value of Assistance (VOA) of a look from there: by how much the look is expected to "
        "raise the probability that the next grasp succeeds."
    )
    caption = "Places and their VOA; orange: look from here first."
    if content.scenario.workspace is not None:
        caption += " Dotted: the workspace; returns from outside it are ignored."
    looks = ranking.ranking[:MOST_ROWS]
    rows = [(look.sensor, with_error(look.voa, look.standard_error), _in_words(look)) for look in looks]
    more = len(ranking.ranking) - len(looks)
    return Section(
        "places",
        "Places",
        (
            Paragraph(intro + value),
            Paragraph(_advice(ranking)),
            Picture(file, caption),
            Table("", ("place", "VOA", "successes of 100 grasps"), rows),
            *([Paragraph(f"{more} more places have less.")] if more else []),
        ),
    )


def _advice(ranking: Ranking) -> str:
    """Write the recommendation as two sentences for people who know no VOA."""
    best, before = ranking.best_grasp_before or "none", share(ranking.expected_score_before)
    start = f"Without a look the best grasp is {best}, which succeeds with probability {before}."
    advice = ranking.recommendation
    if not isinstance(advice, Look):
        return f"{start} No look is worth it: grasp at once."
    then = "" if advice.then is None else f", then from {advice.then}"
    return (
        f"{start} Look first from {advice.sensor}{then}: that is expected to raise it by {signed(advice.net_value, 2)}."
    )


def _in_words(look: RankedSensor) -> str:
    """Write a VOA with its standard error as a number of successes in 100 grasps."""
    hundred = 100.0 * look.voa
    if math.isclose(hundred, 0.0, abs_tol=0.05):
        text = "no more"
    else:
        text = f"{abs(hundred):.1f} {'more' if hundred > 0.0 else 'fewer'}"
    if look.standard_error:
        text += f", give or take {unsigned(100.0 * look.standard_error, 1)}"
    return text


def _mm(height: float) -> str:
    return f"{1000.0 * height:.4g} mm"
