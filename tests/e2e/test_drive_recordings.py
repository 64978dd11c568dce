"""Recordings of many kinds, live through a router and by replay: the same looks."""

import json
import os
from pathlib import Path

import httpx2
import pytest

from tests.support.drive_bench import SECONDS, Bench, both_on, finds_the_box
from tests.support.drives import Put
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_ros.topics import LASER_SCAN, ODOMETRY

CASES = Path(os.environ.get("VOA_CASES", Path(__file__).resolve().parents[3] / "shared" / "cases")) / "lidar"
needs_cases = pytest.mark.skipif(not CASES.is_dir(), reason=f"no recordings at {CASES}; VOA_CASES names another place")
EAST = 'from = "sensor"\nsensor = "E"'
UPSIDE_DOWN = "lidar = { upside_down = true }"


@needs_cases
@pytest.mark.parametrize(
    ("name", "yaw", "more", "place"),
    [
        ("02-beam-count-varies.mcap", "A", "", EAST),
        ("05-zeros-while-spinning-up.mcap", "A", "", ""),
        ("07-upside-down.mcap", "A", UPSIDE_DOWN, ""),
        ("08-increment-sign.mcap", "", "", ""),
        ("09-degrees.mcap", "", "", EAST),
        ("11-three-echoes.mcap", "", "", ""),
        ("11-three-echoes.mcap", "A", 'frame_id = "world_1_0"', ""),
        ("12-inf-flicker.mcap", "A", "", EAST),
        ("14-storage-renamed", "A", "", EAST),
        ("15-metadata-empty", "A", "", EAST),
        ("16-second-part-missing", "A", "", EAST),
        ("17-killed-recorder", "A", "", EAST),
        ("18-ros1.bag", "A", "", EAST),
        ("20-dropped-packets.mcap", "A", "", EAST),
        ("21-topic-by-topic.mcap", "A", "", ""),
    ],
)
def test_a_recording_gives_the_same_looks_live_and_by_replay(
    bench: Bench, capsys: pytest.CaptureFixture[str], name: str, yaw: str, more: str, place: str
) -> None:
    files = {"file": ("box.obj", (CASES / "box.obj").read_bytes())}
    stored = httpx2.post(f"{bench.lab.url}/v1/objects", files=files, timeout=SECONDS).json()["id"]
    scenario_id = bench.post("/v1/scenarios", json.loads((CASES / "scenario.json").read_text()) | {"object": stored})[
        "id"
    ]
    types = {LASER_SCAN.name: LASER_SCAN, ODOMETRY.name: ODOMETRY}
    puts = [
        Put(message.log_ns * 1e-9, message.topic.strip("/"), types[message.type_name], message.data)
        for message in Recording(CASES / name, RosTypes()).messages()
    ]
    report, looks = both_on(bench, capsys, scenario_id, puts, more, place=place)
    assert len(looks) == (1 if yaw else 0), report
    if yaw:
        assert finds_the_box(bench, report["session"], yaw)
