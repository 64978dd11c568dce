"""Pictures of the page as SVG: places on their circle, the object in the scan plane, and a turning picture as CSS."""

import math
from collections.abc import Sequence
from html import escape

from voa_setup.previews.messages import PlannedPlace, RestOutline

MAP = 520
"""Width and height of the map of places, in its own units."""
PICTURE = 160
"""Width and height of a picture of a rest, pixels."""
FRAMES = 12
"""Pictures of a turn in the file of a rest."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of the rests: Okabe and Ito's, which people with any sight distinguish."""
STYLE = f"""
.voa-turn {{ width: {PICTURE}px; height: {PICTURE}px; background-size: {FRAMES * PICTURE}px {PICTURE}px;
  animation: voa-turn {FRAMES * 0.5:g}s steps({FRAMES}) infinite; }}
.voa-turn:hover {{ animation-play-state: paused; }}
@keyframes voa-turn {{ to {{ background-position-x: -{FRAMES * PICTURE}px; }} }}
@media (prefers-reduced-motion: reduce) {{ .voa-turn {{ animation: none; }} }}
.voa-plane {{ position: absolute; left: -4px; right: -4px; height: 0; border-top: 2px dashed #D55E00; }}
"""
_MARGIN = 1.28
"""Half of the map's width, as a multiple of the circle's radius."""
_DISC = 15.0
_PICK = 34.0


def to_map(x: float, y: float, radius_m: float) -> tuple[float, float]:
    """Return the point of the map for a position in metres; y points up."""
    scale = MAP / 2.0 / (_MARGIN * radius_m)
    return MAP / 2.0 + scale * x, MAP / 2.0 - scale * y


def bearing_at(map_x: float, map_y: float) -> float:
    """Return the bearing of a point of the map from the middle, degrees counter-clockwise from +x, 0 to 360."""
    return math.degrees(math.atan2(MAP / 2.0 - map_y, map_x - MAP / 2.0)) % 360.0


def place_at(map_x: float, map_y: float, bearings_deg: Sequence[float]) -> int | None:
    """Return the index of the place nearest to a point of the map; None: all are farther than a finger is wide."""
    radius = MAP / 2.0 / _MARGIN
    distances = [
        math.hypot(
            map_x - MAP / 2.0 - radius * math.cos(math.radians(bearing)),
            map_y - MAP / 2.0 + radius * math.sin(math.radians(bearing)),
        )
        for bearing in bearings_deg
    ]
    nearest = min(range(len(distances)), key=distances.__getitem__, default=None)
    return nearest if nearest is not None and distances[nearest] <= _PICK else None


def map_of_places(
    places: Sequence[PlannedPlace], outlines: Sequence[RestOutline], radius_m: float, moved: int | None = None
) -> str:
    """Draw the places on their circle, and in the middle what the lidar can see of the object at each rest.

    Args:
        places: of the lidar.
        outlines: of the object at each rest, in the scan plane.
        radius_m: of the circle.
        moved: index of the place that is being moved; None: none is.
    """
    middle, scale = MAP / 2.0, MAP / 2.0 / (_MARGIN * radius_m) / 1000.0
    parts = [
        f'<circle cx="{middle:g}" cy="{middle:g}" r="{1000.0 * radius_m * scale:.1f}" fill="none" stroke="#888" '
        'stroke-width="1.5" stroke-dasharray="4 5"/>'
    ]
    parts += [
        f'<path d="{escape(outline.path)}" fill="none" '
        f'transform="translate({middle:g} {middle:g}) scale({scale:.5f} {-scale:.5f})" '
        f'stroke="{COLOURS[index % len(COLOURS)]}" stroke-width="{2.0 / scale:.2f}"/>'
        for index, outline in enumerate(outlines)
    ]
    parts += [f'<path d="M{middle - 5:g} {middle:g}h10M{middle:g} {middle - 5:g}v10" stroke="#888" stroke-width="1"/>']
    for index, place in enumerate(places):
        x, y = to_map(place.x, place.y, radius_m)
        inward = x + 30.0 * math.cos(place.yaw_rad), y - 30.0 * math.sin(place.yaw_rad)
        colour = "#D55E00" if index == moved else "#0072B2"
        outward = x + (x - middle) * 0.10, y + (y - middle) * 0.13
        anchor = "middle" if abs(x - middle) < _DISC else "start" if x > middle else "end"
        parts.append(
            f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{inward[0]:.1f}" y2="{inward[1]:.1f}" stroke="{colour}" '
            f'stroke-width="4" stroke-linecap="round"/><circle cx="{x:.1f}" cy="{y:.1f}" r="{_DISC:g}" '
            f'fill="{colour}" stroke="white" stroke-width="2"/><text x="{outward[0]:.1f}" y="{outward[1] + 6:.1f}" '
            f'text-anchor="{anchor}" font-size="17" fill="currentColor">{escape(place.name)}</text>'
        )
    return "".join(parts)


def outline_picture(outline: RestOutline, colour: str, reach_mm: float) -> str:
    """Draw the object from above, with the line at which the scan plane cuts it, as an SVG element.

    Args:
        outline: at a rest.
        colour: of the line.
        reach_mm: half of the width that is shown.
    """
    size = 2.0 * reach_mm
    width = size / 110.0
    return (
        f'<svg viewBox="{-reach_mm:.1f} {-reach_mm:.1f} {size:.1f} {size:.1f}" width="100%" role="img" '
        f'aria-label="{escape(outline.rest)} from above, cut by the scan plane"><g transform="scale(1 -1)" '
        f'fill="none"><path d="{escape(outline.shadow)}" fill="#888" fill-opacity="0.25"/>'
        f'<path d="{escape(outline.path)}" stroke="{colour}" stroke-width="{2.0 * width:.2f}" '
        'stroke-linecap="round"/></g></svg>'
    )


def reach_of(outlines: Sequence[RestOutline]) -> float:
    """Return how far the object reaches from the middle at any rest, millimetres, with a margin."""
    corners = [
        math.hypot(*map(float, corner.split()))
        for outline in outlines
        for corner in outline.shadow.strip("MZ").split("L")
        if corner
    ]
    return 1.08 * max(corners, default=50.0)
