"""Pictures of an object that turns on the table, beside one another in one PNG file."""

import math
from io import BytesIO

import numpy as np
from matplotlib.image import imsave

from voa_core.geometry import turn
from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_setup.look.shading import shade
from voa_setup.look.views import View

FRAMES = 12
"""Pictures of a turn."""
PIXELS = 160
"""Width and height of a picture."""
_ELEVATION_RAD = math.radians(28.0)
_MARGIN = 0.92
"""Share of the picture that the table under the object fills."""
_TABLE = (0.55, 0.50, 0.44, 0.30)
"""Colour of the table: legible on a light page and on a dark page."""


def draw_turntable(mesh: Mesh) -> bytes:
    """Draw a mesh at rest, in the world frame, at yaws that are spread evenly over a turn, counter-clockwise.

    Returns:
        PNG file of `FRAMES` pictures of `PIXELS` by `PIXELS`, from left to right, transparent around the table.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle = np.array([*((low + high)[:2] / 2.0), 0.0])
    points = mesh.vertices - middle
    radius = max(float(np.hypot(points[:, 0], points[:, 1]).max()), 1e-4)
    sine, cosine = math.sin(_ELEVATION_RAD), math.cos(_ELEVATION_RAD)
    view = View(np.array([1.0, 0.0, 0.0]), np.array([0.0, sine, cosine]), "x", "up")
    bottom = -radius * sine
    top = max(radius * sine, float(high[2]) * cosine + radius * sine)
    size = max(2.0 * radius, top - bottom) / (_MARGIN * PIXELS)
    corner = np.array([0.0, (bottom + top) / 2.0]) - size * PIXELS / 2.0
    frames = [
        _frame(Mesh(points @ turn(2.0 * math.pi * index / FRAMES).T, mesh.faces), view, corner, size, radius)
        for index in range(FRAMES)
    ]
    return png_of(np.hstack(frames))


def png_of(pixels: Floats) -> bytes:
    """Return pixels (rows, columns, 4), 0 to 1, the first row lowest, as a PNG file."""
    file = BytesIO()
    imsave(file, np.asarray(np.round(255.0 * pixels), dtype=np.uint8)[::-1], format="png")
    return file.getvalue()


def _frame(mesh: Mesh, view: View, corner: Floats, size: float, radius: float) -> Floats:
    """Draw one picture (PIXELS, PIXELS, 4), the first row lowest.

    Args:
        mesh: about the middle of the table.
        view: from above the table's edge.
        corner: lower left corner of the picture, (2,) metres.
        size: of a pixel, metres.
        radius: of the table, metres.
    """
    at = (np.arange(PIXELS) + 0.5) * size
    across, along = np.meshgrid(corner[0] + at, corner[1] + at)
    canvas = np.zeros((PIXELS, PIXELS, 4))
    canvas[np.hypot(across, along / view.up[1]) <= radius] = _TABLE
    longest = float(np.ptp(view.project(mesh.vertices), axis=0).max())
    picture = shade(mesh, view, max(4, round(longest / size)))
    left, _, bottom, _ = picture.extent
    column, row = round((left - corner[0]) / size), round((bottom - corner[1]) / size)
    rows, columns = picture.pixels.shape[:2]
    first = max(0, -row), max(0, -column)
    part = picture.pixels[first[0] : min(rows, PIXELS - row), first[1] : min(columns, PIXELS - column)]
    place = canvas[row + first[0] :, column + first[1] :][: part.shape[0], : part.shape[1]]
    place[part[..., 3] > 0.0] = part[part[..., 3] > 0.0]
    return canvas
