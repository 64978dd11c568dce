"""Panels of drawings: the table, a shaded mesh, the scan plane, outlines and grippers, all in millimetres."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_setup.look.glyphs import GripperGlyph
from voa_setup.look.shading import shade
from voa_setup.look.views import View

BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"  # Okabe and Ito's
GREY = "#8a8a8a"
HEIGHT_COLOURS = (ORANGE, GREEN, BLUE, "#cc79a7")
"""Colours of scan planes and their outlines, by height; they repeat from the fifth on."""
HEIGHT_COLOUR_NAMES = ("orange", "green", "blue", "pink")
MM = 1000.0
_SHORT = 0.15
"""Length of a foreshortened arrow, as a share of its length, below which it points into the picture."""


@dataclass(frozen=True)
class Box:
    """Rectangle of a picture, metres."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """Width, metres."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """Height, metres."""
        return self.top - self.bottom


def box_around(points: Floats, margin: float = 0.08) -> Box:
    """Box around points (k, 2) with a margin on each side, a share of its longer side."""
    low, high = points.min(axis=0), points.max(axis=0)
    edge = margin * max(float((high - low).max()), 1e-3)
    return Box(float(low[0]) - edge, float(high[0]) + edge, float(low[1]) - edge, float(high[1]) + edge)


def draw_mesh(axes: Axes, mesh: Mesh, view: View, pixels: int, opacity: float = 1.0) -> None:
    """Draw a mesh in the world frame, shaded."""
    picture = shade(mesh, view, pixels)
    left, right, bottom, top = picture.extent
    axes.imshow(
        picture.pixels,
        extent=(MM * left, MM * right, MM * bottom, MM * top),
        origin="lower",
        alpha=opacity,
        aspect="auto",  # the panel's own shape gives both axes one scale
        zorder=2.0,
    )


def draw_table(axes: Axes, box: Box) -> None:
    """Draw the table in a view from the side: a hatched strip below z = 0."""
    if box.bottom < 0.0:
        axes.axhspan(MM * box.bottom, 0.0, facecolor="#efe9e1", edgecolor="#c9bfb2", hatch="///", linewidth=0.0)
    axes.axhline(0.0, color="#7a6f62", linewidth=1.0, zorder=2.5)


def draw_scan_planes(axes: Axes, heights_m: Sequence[float]) -> None:
    """Draw scan planes in a view from the side: a dashed line at each height."""
    for height, colour in zip(heights_m, cycle(HEIGHT_COLOURS), strict=False):
        axes.axhline(MM * height, color=colour, linewidth=1.3, linestyle=(0, (5, 2)), zorder=4.0)


def draw_outlines_of(axes: Axes, outlines: Sequence[Floats], shift: Floats | None = None) -> None:
    """Draw the outlines of one pose, (s, 2, 2) metres each, in the colours of their scan planes, moved by `shift`."""
    for segments, colour in zip(outlines, cycle(HEIGHT_COLOURS), strict=False):
        draw_outline(axes, segments if shift is None else segments + shift, colour, width=1.8)


def draw_outline(axes: Axes, segments: Floats, colour: str, *, width: float, opacity: float = 1.0) -> None:
    """Draw an outline (s, 2, 2), metres, in a view from above."""
    lines = LineCollection(list(MM * segments), colors=colour, linewidths=width, alpha=opacity, capstyle="round")
    lines.set_zorder(4.0)
    axes.add_collection(lines)


def draw_gripper(axes: Axes, glyph: GripperGlyph, view: View) -> None:
    """Draw a gripper: fingers, bar, and an arrow along the approach, or a crossed circle if it points away."""
    for sides, colour in ((glyph.bar, GREY), (glyph.fingers, ORANGE)):
        axes.add_collection(
            PolyCollection(
                list(MM * view.project(sides)),
                facecolor=colour,
                edgecolor=colour,
                alpha=0.30,
                linewidth=0.6,
                zorder=5.0,
            )
        )
    tail, tip = MM * view.project(glyph.tail), MM * view.project(glyph.tip)
    if np.linalg.norm(tip - tail) < _SHORT * MM * np.linalg.norm(glyph.tip - glyph.tail):
        axes.plot(*tip, marker="o", markersize=9, fillstyle="none", color="black", zorder=6.0)
        axes.plot(*tip, marker="x", markersize=6, color="black", zorder=6.0)
        return
    axes.annotate(
        "",
        xy=tuple(tip),
        xytext=tuple(tail),
        arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.4, "shrinkA": 0.0, "shrinkB": 0.0},
        zorder=6.0,
    )


def finish(axes: Axes, box: Box, view: View, title: str) -> None:
    """Set limits, labels and title of a panel."""
    axes.set_xlim(MM * box.left, MM * box.right)
    axes.set_ylim(MM * box.bottom, MM * box.top)
    axes.set_xlabel(f"{view.right_label}, mm", fontsize=8)
    axes.set_ylabel(f"{view.up_label}, mm", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.set_title(title, fontsize=9)
