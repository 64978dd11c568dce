"""Watching a scene: in MuJoCo's viewer, or as a video."""

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco

from voa_fleet.devices.simulated import Scene
from voa_fleet.errors import NoGraphics
from voa_fleet.show.render import Renderer, View, open_video
from voa_fleet.world.attempts import Watch
from voa_fleet.world.clocks import Clock
from voa_fleet.world.groups import DRAWN

FRAMES_PER_S = 10
SPEED = 2.0
"""Speed of videos: most of an episode is driving."""
_WIDTH, _HEIGHT = 640, 427
_ROUNDING_S = 1e-6
"""Rounding error of a clock that adds up many short sleeps."""


@contextmanager
def filmed(scene: Scene, clock: Clock, file: Path, view: View | None = None) -> Iterator[Watch]:
    """Write a video of the scene, twice as fast as its clock, by the function that is yielded.

    Raises:
        NoGraphics: there is no OpenGL library, or no ffmpeg where the file's format needs it.
    """
    apart_s = SPEED / FRAMES_PER_S
    with (
        Renderer(scene.world, _WIDTH, _HEIGHT, view, shadows=False) as renderer,
        open_video(file, FRAMES_PER_S) as video,
    ):
        due = clock.now_s()

        def watch(data: mujoco.MjData) -> None:
            nonlocal due
            if clock.now_s() >= due - _ROUNDING_S:
                due = max(due + apart_s, clock.now_s())
                video.add(renderer.frame(data))

        yield watch


@contextmanager
def viewed(scene: Scene) -> Iterator[Watch]:
    """Keep MuJoCo's viewer up to date by the function that is yielded; a window that was closed stays closed.

    Raises:
        NoGraphics: the viewer is not installed, or there is no display.
    """
    try:
        viewer: Any = importlib.import_module("mujoco.viewer")
    except ImportError as error:
        raise NoGraphics(f"MuJoCo's viewer is not installed ({error}); install it with: pip install glfw") from error
    try:
        window = viewer.launch_passive(scene.world.model, scene.data, show_left_ui=False, show_right_ui=False)
    except Exception as error:  # glfw raises errors of several kinds where there is no display
        raise NoGraphics(f"MuJoCo's viewer cannot open a window: {error}; is there a display?") from error
    with window:
        window.opt.geomgroup[:] = DRAWN

        def watch(_data: mujoco.MjData) -> None:
            if window.is_running():
                window.sync()

        yield watch
