"""`voa demo` in a pipe: the story, the contrast, the page; and it ends when it should."""

import os
import re
import signal
import subprocess
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

import pytest

from voa_cli.main import main
from voa_fleet.clocks import VirtualClock
from voa_fleet.commands import demo as command
from voa_fleet.devices import GraspOutcome
from voa_fleet.errors import NoGraphics
from voa_fleet.objects import FleetObject
from voa_fleet.stage import make_stage
from voa_fleet.story import Event, Grasped

PNG = b"\x89PNG\r\n\x1a\n"
SECONDS = 120.0


def test_the_demo_tells_the_story_and_leaves_a_page(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "demo"
    assert main(["demo", "--out", str(out), "--drops", "3"]) == 0
    told = capfd.readouterr().out
    flat = " ".join(told.split())
    assert "\x1b" not in told
    assert (
        flat.index("0.0 s session")
        < flat.index("s look from")
        < flat.index("looked from")
        < flat.index("the arm tries")
    )
    assert 2 <= told.count("looked from") <= 3
    truth = re.search(r"In truth the mallet was at (\S+) \((.*?)\)", flat)
    assert truth is not None
    assert "TOP (top-down on the handle that points up) succeeded." in flat
    counts = re.search(r"without a look (\d) of 3 grasps failed, with up to 3 looks (\d) of 3", flat)
    assert counts is not None
    assert int(counts[1]) > int(counts[2])
    assert (out / "demo.html").resolve().as_uri() in told.replace("\n", "")
    page = (out / "demo.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") >= 4
    assert not re.findall(r'(?:src|href)="(?!data:)', page)  # it needs no other file
    assert f"at {truth[1]} ({truth[2]})" in page
    for picture in ("belief.png", "from-above.png", "contrast.png", "before-and-after.png"):
        content = (out / picture).read_bytes()
        assert content.startswith(PNG)
        assert len(content) > 10_000


def test_without_opengl_it_says_so_and_takes_no_pictures(
    things: dict[str, FleetObject], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_arguments: object, **_more: object) -> None:
        raise NoGraphics("no OpenGL here")

    monkeypatch.setattr(command, "Renderer", refused)
    told = command.Demo(things["mallet"], seed=0)
    stage = make_stage(things["mallet"], command.FLAWS, 0, VirtualClock(), "robot")
    with ExitStack() as stack:
        camera = command.Camera.of(stack, told, stage)
        camera.hear(Event("robot", 0.0, Grasped(GraspOutcome("TOP", success=True))))
    assert (told.no_frames, told.frames) == ("no OpenGL here", [])


def demo(out: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "voa_cli.main", "demo", "--out", str(out), "--drops", "5000", "--looks", "1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )


def test_ctrl_c_ends_it_in_order_with_a_page(tmp_path: Path) -> None:
    with demo(tmp_path) as process:
        assert process.stdout is not None
        watchdog = threading.Timer(SECONDS, process.kill)
        watchdog.start()
        said = ""
        for line in process.stdout:
            said += line
            if "The same drops without a look" in line:
                process.send_signal(signal.SIGINT)
                break
        said += process.stdout.read()
        errors = process.stderr.read() if process.stderr is not None else ""
        watchdog.cancel()
    assert process.returncode == 0, errors
    assert "Stopped: the demo ends here." in said
    assert "What happened" in (tmp_path / "demo.html").read_text(encoding="utf-8")
    assert "Traceback" not in errors


def test_demo_seconds_end_it_by_itself(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DEMO_SECONDS", "4")
    assert main(["demo", "--out", str(tmp_path), "--drops", "5000"]) == 0
    assert "DEMO_SECONDS are over" in capfd.readouterr().out
    assert (tmp_path / "demo.html").is_file()


@pytest.mark.parametrize("told", ["soon", "-1", "nan"])
def test_demo_seconds_that_are_none_are_refused(
    told: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DEMO_SECONDS", told)
    assert main(["demo", "--out", str(tmp_path)]) == 1
    assert f"DEMO_SECONDS: expected seconds, more than 0, got '{told}'" in capfd.readouterr().err
