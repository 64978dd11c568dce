"""Watching: a video that is as long as its clock says."""

from pathlib import Path

import pytest
from PIL import Image

from voa_fleet.devices.simulated import make_scene
from voa_fleet.show.watching import FRAMES_PER_S, SPEED, filmed
from voa_fleet.world.clocks import VirtualClock
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.object_poses import scenario_pose
from voa_fleet.world.objects import FleetObject


def test_a_video_has_a_frame_for_every_so_many_seconds_of_the_clock(mug: FleetObject, tmp_path: Path) -> None:
    clock, file = VirtualClock(), tmp_path / "scene.gif"
    scene = make_scene(mug, clock, 0, Imperfections())
    with filmed(scene, clock, file) as watch:
        for step in range(9):  # nine times 0.1 s: at 0.0, 0.2, ... 0.8
            scene.put(scenario_pose(mug, mug.poses[step % len(mug.poses)]))  # or equal frames would become one
            watch(scene.data)
            clock.sleep(0.1)
    with Image.open(file) as video:
        frames = getattr(video, "n_frames", 1)
        assert video.size == (640, 427)
        assert video.info["duration"] == pytest.approx(1e3 / FRAMES_PER_S)
    assert frames == 5
    assert frames / FRAMES_PER_S * SPEED == pytest.approx(1.0)
