"""The page New object in a real browser: from a mesh file to a session, beside a real service."""

import io
import math
import re
import shlex
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from playwright.sync_api import Browser, FileChooser, Page, expect
from playwright.sync_api import TimeoutError as TooLate

from tests.support.browser import NARROW, opened, picture
from tests.support.meshes import box, written
from tests.support.waiting import wait_for
from voa_cli.main import main
from voa_client import Client
from voa_console.new_object.folders import FILES

_LONG_MS = 120_000.0
"""Time for what compiles functions when it is the first on a machine."""
_ACT_MS, _ATTEMPTS = 10_000.0, 4
"""Time that a dialogue may take to open, and how often a person would try."""


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A box of 100, 40 and 25 mm in a file in millimetres."""
    return written(box(100.0, 40.0, 25.0), tmp_path_factory.mktemp("mesh") / "part.stl")


@pytest.fixture(scope="module")
def address(browser: Browser, console: str, mesh: Path) -> str:
    """Address of the page of a mesh that was dropped and confirmed, with few choices that are made within seconds."""
    with opened(browser) as page:
        page.goto(f"{console}/new")
        page.set_input_files("input[type=file]", mesh)
        expect(page.get_by_text("it is probably in millimetres")).to_be_visible(timeout=_LONG_MS)
        expect(page.get_by_text("10 cm wide, 4 cm deep, 2.5 cm high.")).to_be_visible()
        page.get_by_role("button", name="Use this size").click()
        expect(page.get_by_text("poses from 3 rests")).to_be_visible(timeout=_LONG_MS)
        page.get_by_role("checkbox", name="on side B").click()
        page.get_by_role("spinbutton", name="Yaws of each rest").fill("2")
        page.get_by_role("spinbutton", name="Most grasps").fill("2")
        expect(page.get_by_text("2 poses from 2 rests")).to_be_visible()
        expect(page.get_by_text("at most 60 attempts in all")).to_be_visible()
        return page.url


@pytest.fixture
def begun(page: Page, address: str, tmp_path: Path) -> Page:
    """The page of the mesh, opened again, with a folder of the test's own for the files."""
    page.goto(address)
    expect(page.get_by_text("2 poses from 2 rests")).to_be_visible()
    page.get_by_label("Folder on the machine of this console").fill(str(tmp_path / "made"))
    return page


def chosen(page: Page, act: Callable[[], None]) -> FileChooser:
    """Return the dialogue for files that an act opens; Chromium opens none for an act that it handles 5 s late."""
    for _ in range(_ATTEMPTS - 1):
        with suppress(TooLate):
            return dialogue(page, act)
    return dialogue(page, act)


def dialogue(page: Page, act: Callable[[], None]) -> FileChooser:
    with page.expect_file_chooser(timeout=_ACT_MS) as chooser:
        act()
    return chooser.value


def drag(page: Page, from_deg: float, to_deg: float) -> None:
    """Drag what stands at a bearing on the map of places to another bearing."""
    drawn = page.get_by_role("img", name="Map of the places")
    drawn.scroll_into_view_if_needed()
    sides = drawn.bounding_box()
    assert sides is not None
    middle = sides["x"] + sides["width"] / 2.0, sides["y"] + sides["height"] / 2.0
    radius = sides["width"] / 2.0 / 1.28

    def at(bearing: float) -> tuple[float, float]:
        angle = math.radians(bearing)
        return middle[0] + radius * math.cos(angle), middle[1] - radius * math.sin(angle)

    page.mouse.move(*at(from_deg))
    page.mouse.down()
    page.mouse.move(*at(to_deg), steps=4)
    page.mouse.up()


def test_a_mesh_file_is_chosen_by_mouse_and_by_keyboard(page: Page, console: str, tmp_path: Path) -> None:
    text = tmp_path / "part.txt"
    text.write_text("no mesh")
    page.goto(f"{console}/new")
    button = page.get_by_role("button", name="Choose a mesh file")
    chosen(page, button.click).set_files(text)  # a browser opens no second dialogue beside an open one
    expect(page.get_by_text("Expected one file of at most 20 MB")).to_be_visible()
    button.focus()
    expect(button).to_be_focused()
    mesh = tmp_path / "broken.stl"
    mesh.write_text("no mesh")
    chosen(page, lambda: page.keyboard.press("Enter")).set_files(mesh)
    expect(page.get_by_text("Expected one file of at most 20 MB")).to_be_hidden()
    expect(page.get_by_role("alert").get_by_text(re.compile(r"\w"))).to_be_visible()
    expect(button).to_be_focused()
    picture(page, "new-start", tmp_path)


def test_a_mesh_becomes_a_session_with_the_files_of_the_command(
    begun: Page, browser: Browser, process: str, mesh: Path, tmp_path: Path
) -> None:
    page, folder = begun, tmp_path / "made"
    drag(page, 22.5, 10.0)
    expect(page.get_by_role("spinbutton", name="Place 1")).to_have_value(re.compile(r"^10(\.0)?$"))
    page.get_by_role("slider").locator("[tabindex='0']").press("ArrowRight")
    expect(page.get_by_role("spinbutton", name="Height, mm")).to_have_value(re.compile(r"^\d+(\.0)?$"))
    expect(page.get_by_role("button", name="Suggest")).to_be_visible()
    page.get_by_role("radio", name="Geometric").click()
    page.get_by_text("As a command").click()
    command = page.get_by_text(re.compile("^voa new .*--scores geometric")).inner_text()  # the choice has arrived
    picture(page, "new-object-choices", tmp_path)
    page.get_by_role("button", name="Make the scenario").click()
    expect(page.get_by_text("The scenario part is made")).to_be_visible(timeout=_LONG_MS)

    words = shlex.split(command)[2:]
    assert words[0] == "part.stl"
    again = [str(mesh), *words[1:], "--url", process, "--json"]
    again[again.index("-o") + 1] = str(tmp_path / "command")
    assert main(["new", *again]) == 0
    files = {*FILES, "part.obj"}
    assert {file.name for file in folder.iterdir()} == files
    for name in files:
        assert (folder / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), name

    with page.expect_download() as download:
        page.get_by_role("link", name="Download as ZIP").click()
    with zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes())) as archive:
        assert archive.read("part/scenario.json") == (folder / "scenario.json").read_bytes()
    expect(page.frame_locator("iframe").get_by_role("heading", name="part: is it right?")).to_be_visible()

    page.get_by_role("button", name="Make the scenario").click()
    page.get_by_role("button", name="Keep it").click()
    with opened(browser, NARROW, dark=True) as narrow:
        narrow.goto(page.url)
        expect(narrow.get_by_text("The scenario part is made")).to_be_visible()
        assert narrow.evaluate("document.documentElement.scrollWidth") <= NARROW[0]
        picture(narrow, "new-object-narrow-dark", tmp_path)

    page.get_by_role("button", name="Open a session").click()
    page.wait_for_url(re.compile("/sessions/"))
    with Client(process) as client:
        session = client.get_session(page.url.rsplit("/", 1)[1])
        scenario = client.get_scenario(session.scenario)
    assert session.poses == ["upright", "on side A"]
    assert [place.name for place in scenario.sensors][:2] == ["at 10", "NNE"]


def test_a_making_is_shown_to_whoever_opens_the_page_and_can_be_cancelled(
    begun: Page, browser: Browser, console: str, process: str, tmp_path: Path
) -> None:
    begun.get_by_role("radio", name="Simulated").click()
    begun.get_by_role("spinbutton", name="Attempts per cell").fill("9000")
    expect(begun.get_by_text("at most 36 000 attempts in all")).to_be_visible()
    before = workers(process)
    begun.get_by_role("button", name="Make the scenario").click()
    expect(begun.get_by_text(re.compile("Scoring the grasps, 0 of 4"))).to_be_visible(timeout=_LONG_MS)
    assert len(workers(process)) > len(before)
    with opened(browser) as other:
        other.goto(f"{console}/new")
        expect(other.get_by_text(re.compile("part: scoring the grasps"))).to_be_visible()
        other.get_by_role("link", name=re.compile("Continue with part: scoring")).click()
        other.get_by_role("button", name="Cancel").click()
        expect(other.get_by_text("Cancelled; finished attempts are kept.")).to_be_visible()
    expect(begun.get_by_text("Cancelled; finished attempts are kept.")).to_be_visible()
    wait_for(lambda: workers(process) == before, "the end of the process that made the scenario")
    assert (tmp_path / "made" / "scores.partial").is_file()


def workers(service_url: str) -> set[int]:
    """Processes that work on new objects for a service."""
    running = set()
    for line in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = line.read_bytes().split(b"\0")
        except OSError:  # a process that has ended in the meantime
            continue
        if b"voa_console.new_object.worker" in words and service_url.encode() in words:
            running.add(int(line.parent.name))
    return running


def test_a_broken_mesh_and_another_file_are_refused_in_a_sentence(page: Page, console: str, tmp_path: Path) -> None:
    page.goto(f"{console}/new")
    broken = tmp_path / "broken.stl"
    broken.write_bytes(b"solid nothing")
    page.set_input_files("input[type=file]", broken)
    expect(page.get_by_role("alert").get_by_text(re.compile(r"^broken\.stl (cannot|holds)"))).to_be_visible(
        timeout=_LONG_MS
    )
    text = tmp_path / "notes.txt"
    text.write_text("no mesh")
    page.set_input_files("input[type=file]", text)
    expect(page.get_by_text("Expected one file of at most 20 MB that ends with stl")).to_be_visible()
    assert page.url.endswith("/new")
    picture(page, "new-object-refused", tmp_path)
