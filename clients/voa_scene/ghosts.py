"""Ghosts: copies of the object at its poses, the more opaque the likelier."""

import math
from collections.abc import Sequence

from voa_msgs.scenarios import Scenario
from voa_scene.colours import GREY, ORANGE
from voa_scene.shapes import AnyShape, MeshShape

MOST_GHOSTS = 60
"""Most poses at which the object is drawn: the likeliest."""
_LEAST = 1e-3
"""Probability, as a share of the largest, below which no ghost is drawn."""
_FAINTEST, _STRONGEST = 0.05, 0.9


def ghosts_of(scenario: Scenario, belief: Sequence[float]) -> list[AnyShape]:
    """Make the ghosts of the likeliest poses, the likeliest pose in orange; none if the scenario has no mesh.

    The opacity grows with the square root of the probability, because opacities of ghosts that overlap add up.

    Args:
        scenario: with its poses.
        belief: probability of each pose, in the order of the scenario.
    """
    if scenario.object is None:
        return []
    order = sorted(range(len(belief)), key=lambda index: -belief[index])  # stable: the first listed of equals is first
    best = order[0]
    shapes: list[AnyShape] = []
    for index in order[:MOST_GHOSTS]:
        pose, probability = scenario.poses[index], belief[index]
        if pose.position is None or pose.quaternion_wxyz is None or probability <= _LEAST * belief[best]:
            continue
        colour = ORANGE if index == best else GREY
        x, y, z = pose.position
        a, b, c, d = pose.quaternion_wxyz
        shapes.append(
            MeshShape(
                group="belief",
                name=pose.name,
                label=f"{pose.name}: {percent(probability)}",
                position=(x, y, z),
                rotation=(a, b, c, d),
                colour=colour.faded(round(_FAINTEST + (_STRONGEST - _FAINTEST) * math.sqrt(probability), 4)),
                object=scenario.object,
            )
        )
    return shapes


def percent(probability: float) -> str:
    """Write a probability in per cent, without claiming a certainty that rounding made."""
    if 0.0 < probability < 0.01:
        return "below 1 %"
    if 0.99 < probability < 1.0:
        return "above 99 %"
    return f"{100.0 * probability:.0f} %"
