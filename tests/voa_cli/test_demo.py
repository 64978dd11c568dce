"""`voa demo` in a pipe: the episode, the comparison, the page; and it ends when it should."""

import io
import os
import re
import signal
import subprocess
import sys
import threading
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from tests.voa_fleet.show.test_live_report import FIRST, RANKING, session
from voa_cli import demo as command
from voa_cli.demo_console import DATABASE
from voa_cli.main import main
from voa_client import Client
from voa_client.local import local_service
from voa_fleet.devices.protocol import GraspOutcome
from voa_fleet.episodes.bench import make_bench
from voa_fleet.episodes.comparison import Comparison, Tally
from voa_fleet.episodes.episode import Episode
from voa_fleet.episodes.events import Event, GraspEnded
from voa_fleet.episodes.looks import EpisodeLook
from voa_fleet.errors import NoGraphics
from voa_fleet.show.demo_page import Demo, story_of
from voa_fleet.show.episode_pictures import belief_by_look
from voa_fleet.show.interruption import TimeIsUp
from voa_fleet.world.clocks import VirtualClock
from voa_fleet.world.objects import named_object
from voa_msgs.rankings import Ranking

PNG = b"\x89PNG\r\n\x1a\n"
SECONDS = 120.0


def test_the_demo_reports_the_episode_and_leaves_a_page(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "demo"
    assert main(["demo", "--out", str(out), "--drops", "3"]) == 0
    printed = capfd.readouterr().out
    flat = " ".join(printed.split())
    assert "\x1b" not in printed
    assert story_of(named_object("mallet")) in flat
    assert "From behind the head the handle is hidden" in flat
    assert (
        flat.index("0.0 s session")
        < flat.index("s look from")
        < flat.index("looked from")
        < flat.index("the arm tries")
    )
    assert 2 <= printed.count("looked from") <= 3
    truth = re.search(r"The true pose of the mallet was (\S+) \((.*?)\)", flat)
    assert truth is not None
    assert "TOP (top-down on the handle that points up) succeeded." in flat
    counts = re.search(r"Without a look (\d) of 3 grasps failed, with looks (\d) of 3", flat)
    assert counts is not None
    assert int(counts[1]) > int(counts[2])
    assert (out / "demo.html").resolve().as_uri() in printed.replace("\n", "")
    page = (out / "demo.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") >= 4
    assert not re.findall(r'(?:src|href)="(?!data:)', page)  # it needs no other file
    assert f"was {truth[1]} ({truth[2]})" in page
    assert story_of(named_object("mallet")) in page
    for picture in ("belief.png", "from-above.png", "comparison.png", "before-and-after.png"):
        content = (out / picture).read_bytes()
        assert content.startswith(PNG)
        assert len(content) > 10_000


def test_of_the_coupling_two_looks_are_announced_together(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["demo", "--out", str(tmp_path), "--object", "coupling", "--drops", "2"]) == 0
    flat = " ".join(capfd.readouterr().out.split())
    assert re.search(r"look from \S+-(low|mid) next, then from \S+-(low|mid) \(worth \+0\.4\d\d together\)", flat)
    assert flat.count("looked from") == 2
    assert "with looks 0 of 2." in flat


def test_the_goblet_s_first_look_is_at_its_foot(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["demo", "--out", str(tmp_path), "--object", "goblet", "--drops", "2"]) == 0
    flat = " ".join(capfd.readouterr().out.split())
    assert re.search(r"look from \S+-low next \(\S+-low is worth \+0\.4\d\d, ", flat)
    assert flat.count("looked from") == 1
    assert "with looks 0 of 2." in flat


@pytest.mark.parametrize(
    ("text", "story"),
    [
        ("# Cup\n\nOf a cup,\nin two lines.\n\nMore.\n", "Of a cup, in two lines."),
        ("# Cup\n", ""),
        (None, ""),
    ],
)
def test_the_story_of_an_object_is_the_first_paragraph_of_its_readme(
    tmp_path: Path, text: str | None, story: str
) -> None:
    if text is not None:
        (tmp_path / "README.md").write_text(text, encoding="utf-8")
    assert story_of(replace(named_object("mug"), folder=tmp_path)) == story


def test_without_opengl_it_says_so_and_takes_no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_arguments: object, **_more: object) -> None:
        raise NoGraphics("no OpenGL here")

    monkeypatch.setattr(command, "Renderer", refused)
    course = Demo(named_object("mallet"), seed=0)
    bench = make_bench(named_object("mallet"), command.IMPERFECTIONS, 0, VirtualClock(), "robot")
    with ExitStack() as stack:
        camera = command.Camera.of(stack, course, bench)
        camera.record(Event("robot", 0.0, GraspEnded(GraspOutcome("TOP", success=True))))
    assert (course.no_frames, course.frames) == ("no OpenGL here", [])


@pytest.mark.parametrize("ended", [None, KeyboardInterrupt(), TimeIsUp()])
def test_the_table_is_printed_when_the_progress_bar_is_gone(
    ended: BaseException | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    screen = io.StringIO()

    @contextmanager
    def bar(*_: object) -> Iterator[Callable[[int], None]]:
        screen.write("<bar>")
        try:
            yield lambda _: None
        finally:
            screen.write("</bar>")

    def run(comparison: Comparison, *_: object) -> None:
        comparison.tallies = {name: Tally(name, (True,)) for name in comparison.policies}
        if ended is not None:
            raise ended

    monkeypatch.setattr(command, "progress_bar", bar)
    monkeypatch.setattr(Comparison, "run", run)
    shown = Demo(named_object("mallet"), seed=0)
    nothing: Any = None
    with suppress(KeyboardInterrupt, TimeIsUp):
        options = Namespace(drops=1, looks=1)
        command.show_comparison(shown, nothing, nothing, nothing, Console(file=screen), options, lambda: None)
    assert screen.getvalue().index("</bar>") < screen.getvalue().index("1 of 1")


def episode(poses: int, places: int) -> tuple[Episode, list[Ranking]]:
    """A look that made one of many poses likely, and what looks from many places were worth before and after it."""
    names = [f"P{index}" for index in range(poses)]
    before = session([1.0 / poses] * poses).model_copy(update={"poses": names})
    after = before.model_copy(update={"belief": [0.9, *[0.1 / (poses - 1)] * (poses - 1)]})
    looks = [FIRST.model_copy(update={"sensor": f"Q{index}"}) for index in range(places)]
    ranking = RANKING.model_copy(update={"ranking": looks})
    taken = (EpisodeLook("Q0", None, after, None),)
    return Episode("robot", "voa", before, taken, "G1", 0.9, None, 1.0), [ranking, ranking]


def height_of(file: Path) -> int:
    return int.from_bytes(file.read_bytes()[20:24], "big")


def test_the_belief_chart_has_room_for_every_row_and_an_end(tmp_path: Path) -> None:
    heights = {}
    for poses, places in ((8, 8), (24, 8), (24, 16), (32, 32), (500, 200)):
        file = tmp_path / f"{poses}-{places}.png"
        belief_by_look(file, *episode(poses, places), f"P{poses - 1}")
        heights[poses, places] = height_of(file)
    label = 8 / 72 * 120  # a label's height in pixels
    assert heights[24, 8] - heights[8, 8] >= 16 * label
    assert heights[24, 16] - heights[24, 8] >= 8 * label
    assert heights[500, 200] == heights[32, 32]


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
    with local_service(tmp_path, DATABASE) as url, Client(url) as client:
        assert len(list(client.list_sessions())) <= 1


@pytest.mark.parametrize("seconds", ["soon", "-1", "nan"])
def test_demo_seconds_that_are_none_are_refused(
    seconds: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DEMO_SECONDS", seconds)
    assert main(["demo", "--out", str(tmp_path)]) == 1
    assert f"DEMO_SECONDS: expected seconds, more than 0, got '{seconds}'" in capfd.readouterr().err
