"""Pictures and videos of the scene without a display, by EGL and an installed OpenGL library.

Simulation and evaluations run without OpenGL; only this module needs it.
"""

import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

import matplotlib.image
import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from voa_client.installing import install_hint
from voa_fleet.errors import NoGraphics
from voa_fleet.world.groups import DRAWN
from voa_fleet.world.scene import World

Frame = NDArray[np.uint8]
"""(height, width, 3), the top row first."""

HOW_TO = f"install an OpenGL library: {install_hint('fleet')}, and on Debian apt-get install libegl1 libgl1-mesa-dri"
_MOST_GEOMS = 1000


@dataclass(frozen=True)
class View:
    """Position and direction of the camera.

    Attributes:
        target: point in the middle of the picture, metres.
        distance_m: from that point.
        azimuth_deg, elevation_deg: direction of the camera's axis; negative elevations look down.
    """

    target: tuple[float, float, float] = (-0.05, 0.0, 0.12)
    distance_m: float = 1.7
    azimuth_deg: float = 125.0
    elevation_deg: float = -28.0


class Renderer:
    """Renderer of one world; use it as a context manager, from one thread."""

    def __init__(
        self, world: World, width: int = 960, height: int = 640, view: View | None = None, *, shadows: bool = True
    ) -> None:
        """Create an OpenGL context of that size, in pixels.

        Raises:
            NoGraphics: there is no OpenGL library, or it does not work without a display.
        """
        self._model = world.model
        self._size = (width, height)
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._graphics = _graphics(width, height)
        self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_resizeOffscreen(width, height, self._context)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._scene = mujoco.MjvScene(self._model, maxgeom=_MOST_GEOMS)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        self._options = mujoco.MjvOption()
        self._options.geomgroup[:] = DRAWN
        self._camera = _camera(view or View())

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._context.free()
        self._graphics.free()

    def frame(self, data: mujoco.MjData) -> Frame:
        """Draw the world in the state `data`; positions of the bodies must be up to date."""
        width, height = self._size
        self._graphics.make_current()
        perturbation = mujoco.MjvPerturb()
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(
            self._model, data, self._options, perturbation, self._camera, everything.value, self._scene
        )
        mujoco.mjr_render(self._rectangle, self._scene, self._context)
        pixels = np.zeros((height, width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(pixels, None, self._rectangle, self._context)
        return np.ascontiguousarray(pixels[::-1])


def write_picture(file: Path, frame: Frame) -> None:
    """Write a frame as PNG."""
    matplotlib.image.imsave(file, frame)


class Video(Protocol):
    """Writer of a video file; use it as a context manager, which finishes the file."""

    def __enter__(self) -> Self:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the file."""

    def add(self, frame: Frame) -> None:
        """Write the next frame."""


def open_video(file: Path, frames_per_s: int = 20) -> Video:
    """Open a video for writing: a GIF where the file's name ends in .gif, any other format by the program ffmpeg.

    Raises:
        NoGraphics: ffmpeg is needed and not installed.
    """
    if file.suffix.lower() == ".gif":
        return _Gif(file, frames_per_s)
    program = shutil.which("ffmpeg")
    if program is None:
        raise NoGraphics(
            f"{file.name} is written with ffmpeg, which is not installed; name a .gif, or apt-get install ffmpeg"
        )
    return _Piped(program, file, frames_per_s)


@dataclass
class _Gif:
    """Frames are kept with 128 colours each until the end: a quarter of a megabyte per frame of 640 x 427."""

    file: Path
    frames_per_s: int
    frames: list[Image.Image] = field(default_factory=list)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.frames:
            first, *others = self.frames
            milliseconds = round(1e3 / self.frames_per_s)
            first.save(self.file, save_all=True, append_images=others, duration=milliseconds, loop=0)

    def add(self, frame: Frame) -> None:
        self.frames.append(Image.fromarray(frame).quantize(128))


class _Piped:
    """Frames are piped to ffmpeg, which starts with the first one, when their size is known."""

    def __init__(self, program: str, file: Path, frames_per_s: int) -> None:
        self._command = [program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
        self._rest = ["-r", str(frames_per_s), "-i", "-", "-an", "-pix_fmt", "yuv420p", str(file)]
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._process is None:
            return
        _, errors = self._process.communicate()
        if self._process.returncode and kind is None:
            raise NoGraphics(f"ffmpeg could not write the video: {errors.decode(errors='replace').strip()}")

    def add(self, frame: Frame) -> None:
        if self._process is None:
            height, width, _ = frame.shape
            command = [*self._command, "-s", f"{width}x{height}", *self._rest]
            self._process = subprocess.Popen(  # noqa: S603 - ffmpeg by its own path, without a shell
                command, stdin=subprocess.PIPE, stderr=subprocess.PIPE
            )
        pipe = self._process.stdin
        if pipe is not None:
            pipe.write(frame.tobytes())


def _graphics(width: int, height: int) -> Any:
    """A current OpenGL context without a window."""
    try:
        from mujoco.egl import GLContext  # noqa: PLC0415 - loads OpenGL, which need not be there

        context = GLContext(width, height)
        context.make_current()
    except Exception as error:  # PyOpenGL raises several kinds, AttributeError among them
        raise NoGraphics(f"cannot draw ({type(error).__name__}: {error}); {HOW_TO}") from error
    return context


def _camera(view: View) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = view.target
    camera.distance = view.distance_m
    camera.azimuth = view.azimuth_deg
    camera.elevation = view.elevation_deg
    return camera
