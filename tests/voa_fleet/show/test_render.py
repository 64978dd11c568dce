"""Pictures without a display, and a clear word where there can be none."""

import sys
from pathlib import Path

import matplotlib.image
import mujoco
import numpy as np
import pytest
from PIL import Image

from voa_fleet.errors import NoGraphics
from voa_fleet.show.render import Frame, Renderer, View, open_video, write_picture
from voa_fleet.world.object_poses import scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import build_world


def orange(frame: Frame) -> int:
    """Pixels of the object's colour, which nothing else in the scene has."""
    red, green, blue = (frame[..., channel].astype(int) for channel in range(3))
    return int(((red > 90) & (red - blue > 80) & (green - blue > 30)).sum())


def test_the_object_is_in_the_picture_where_there_is_opengl(mug: FleetObject, tmp_path: Path) -> None:
    world = build_world(mug, arm=False)
    data = mujoco.MjData(world.model)
    near = View(target=(0.0, 0.0, 0.04), distance_m=0.5)
    try:
        with Renderer(world, 160, 120, near) as renderer:
            world.put_object(data, scenario_pose(mug, "U_0"))
            mujoco.mj_forward(world.model, data)
            there = renderer.frame(data)
            data.qpos[world.place] = 5.0
            mujoco.mj_forward(world.model, data)
            gone = renderer.frame(data)
    except NoGraphics as error:
        assert "libegl1" in str(error)  # noqa: PT017 - a machine without OpenGL must say so, and how to get it
        return
    assert there.shape == (120, 160, 3)
    assert orange(there) > 500
    assert orange(gone) < 20
    write_picture(tmp_path / "there.png", there)
    assert matplotlib.image.imread(tmp_path / "there.png").shape[:2] == (120, 160)


def test_without_opengl_it_says_what_to_install(mug: FleetObject, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    with pytest.raises(NoGraphics, match="apt-get install libegl1"):
        Renderer(build_world(mug, arm=False), 64, 48)


def frames() -> list[Frame]:
    return [np.full((24, 32, 3), 20 * index, dtype=np.uint8) for index in range(4)]


def test_a_gif_has_every_frame(tmp_path: Path) -> None:
    file = tmp_path / "film.gif"
    with open_video(file, frames_per_s=10) as video:
        for frame in frames():
            video.add(frame)
    with Image.open(file) as film:
        assert getattr(film, "n_frames", 1) == 4
        assert film.size == (32, 24)


def test_other_videos_go_through_ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text('#!/bin/sh\necho "$@" > "$(dirname "$0")/arguments"\nfor last; do :; done\ncat > "$last"\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    file = tmp_path / "film.mp4"
    with open_video(file, frames_per_s=30) as video:
        for frame in frames():
            video.add(frame)
    assert file.read_bytes() == b"".join(frame.tobytes() for frame in frames())
    arguments = (tmp_path / "arguments").read_text()
    assert "-s 32x24" in arguments
    assert "-r 30" in arguments


def test_a_failing_ffmpeg_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\ncat > /dev/null\necho 'unknown codec' >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(NoGraphics, match="unknown codec"), open_video(tmp_path / "film.mp4") as video:
        video.add(frames()[0])


def test_without_ffmpeg_it_says_what_else_there_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NoGraphics, match=r"name a \.gif, or apt-get install ffmpeg"):
        open_video(tmp_path / "film.mp4")
