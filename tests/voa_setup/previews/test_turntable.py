"""Turning pictures: an object is drawn at every yaw, within its picture, and standing on the table."""

from io import BytesIO
from itertools import pairwise

import numpy as np
from PIL import Image

from tests.support.shapes import mug, screwdriver
from voa_core.checks import Floats
from voa_setup.previews.turntable import FRAMES, PIXELS, draw_turntable, png_of


def pixels_of(png: bytes) -> Floats:
    return np.asarray(Image.open(BytesIO(png)).convert("RGBA"), dtype=np.float64)


def test_a_turn_has_different_pictures_in_a_row_that_nothing_leaves() -> None:
    strip = pixels_of(draw_turntable(mug()))
    assert strip.shape == (PIXELS, FRAMES * PIXELS, 4)
    frames = [strip[:, index * PIXELS : (index + 1) * PIXELS] for index in range(FRAMES)]
    assert all(frame[0].max() == 0 and frame[-1].max() == 0 for frame in frames)
    solid = [(frame[..., 3] == 255.0).mean() for frame in frames]
    assert min(solid) > 0.15
    assert all((one != other).any() for one, other in pairwise(frames))


def test_a_turn_is_counter_clockwise() -> None:
    strip = pixels_of(draw_turntable(screwdriver()))[..., 3] == 255.0
    rows, columns = np.arange(PIXELS), np.arange(PIXELS)
    quarter = FRAMES // 4
    at_0, at_90, at_180, at_270 = (strip[:, index * PIXELS :][:, :PIXELS] for index in quarter * np.arange(4))
    # The heavy handle points to -x: left at yaw 0, towards the viewer at 90 degrees.
    assert (at_0.sum(axis=0) @ columns) / at_0.sum() < (at_180.sum(axis=0) @ columns) / at_180.sum() - 20.0
    assert (at_90.sum(axis=1) @ rows) / at_90.sum() > (at_270.sum(axis=1) @ rows) / at_270.sum() + 5.0


def test_the_lowest_row_of_pixels_is_the_last_of_the_file() -> None:
    pixels = np.zeros((2, 1, 4))
    pixels[0] = 1.0
    assert pixels_of(png_of(pixels))[:, 0, 3].tolist() == [0.0, 255.0]
