"""The page of a session as its tests read it: regions by name, the version that is shown, the shapes of the scene."""

import re

from playwright.sync_api import Locator, Page, expect

from voa_client import Session

SMALL = (600, 700)
"""Size of a window whose scene is small, pixels."""


def open_page(page: Page, console: str, session: Session) -> None:
    """Open the page of a session, and wait for its advice."""
    page.goto(f"{console}/sessions/{session.id}")
    expect(region(page, "Advice").get_by_text(re.compile("^(Look from|Grasp) "))).to_be_visible()


def region(page: Page, name: str) -> Locator:
    """Return a part of the page by its name."""
    return page.get_by_role("region", name=name)


def expect_version(page: Page, version: int, newest: int, when: str = "now") -> None:
    """Wait until the page shows a version."""
    title = region(page, "Time line").get_by_text(f"Version {version} of {newest}, {when}", exact=True)
    expect(title).to_be_visible()


def shapes(page: Page) -> list[str]:
    """Return the names of the shapes in the scene of a page."""
    names: list[str] = page.evaluate(f"() => {{ {_NAMES} return names; }}")
    return names


def wait_for_shape(page: Page, name: str, *, gone: bool = False) -> None:
    """Wait until the scene has a shape whose name begins with `name`, or has none any more."""
    condition = f"names.some((each) => each.startsWith({name!r}))"
    page.wait_for_function(f"() => {{ {_NAMES} return {'!' if gone else ''}{condition}; }}")


def look_from_above(page: Page) -> None:
    """Move the camera above the table, and wait until it is there."""
    page.get_by_role("button", name="From above").click()
    page.wait_for_function(f"() => {{ {_CAMERA} return Math.abs(camera.position.y) < 0.05; }}")


def on_screen(page: Page, name: str) -> tuple[float, float]:
    """Return where the middle of a shape is in the window, pixels, once the scene has that shape."""
    point: dict[str, float] = page.wait_for_function(_ON_SCREEN, arg=name).json_value()
    return point["x"], point["y"]


_SCENE = 'const scene = Object.entries(window).find(([name]) => name.startsWith("scene_"))[1];'
_CAMERA = 'const camera = getElement(parseInt(document.querySelector(".nicegui-scene").id.slice(1))).camera;'
_NAMES = _SCENE + " const names = []; scene.traverse((object) => object.name && names.push(object.name));"
_ON_SCREEN = """(name) => {
    SCENE
    let shape;
    scene.traverse((object) => { if (object.name === name) shape = object; });
    if (!shape) return null;
    const canvas = document.querySelector("canvas").getBoundingClientRect();
    CAMERA
    camera.updateMatrixWorld();
    const point = shape.getWorldPosition(camera.position.clone()).project(camera);
    return {x: canvas.x + (point.x + 1) / 2 * canvas.width, y: canvas.y + (1 - point.y) / 2 * canvas.height};
}""".replace("SCENE", _SCENE).replace("CAMERA", _CAMERA)
