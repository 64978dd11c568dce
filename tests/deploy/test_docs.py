"""The documentation builds, strictly and without the internet, and its pages load nothing from another host."""

import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.deploy.pages import REPOSITORY

LOADING = {"script": "src", "img": "src", "iframe": "src", "source": "src", "link": "href", "object": "data"}
FAR = re.compile(r"^(?:https?:)?//")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built pages."""
    folder = tmp_path_factory.mktemp("docs")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "-f", "deploy/mkdocs.yml", "--site-dir", str(folder)]
    # A proxy that refuses: whatever the build tries to load fails.
    nowhere = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")
    built = subprocess.run(
        command,
        cwd=REPOSITORY,
        env=os.environ | nowhere | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    return folder


class Loads(HTMLParser):
    """Collects what a page loads: not the links that a reader may follow."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        address = dict(attrs).get(LOADING.get(tag, ""))
        if address and dict(attrs).get("rel") not in ("canonical", "next", "prev"):
            self.addresses.append(address)


def test_pages_load_nothing_from_another_host(site: Path) -> None:
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 40
    for page in pages:
        text = page.read_text(encoding="utf-8")
        loads = Loads()
        loads.feed(text)
        assert loads.addresses
        assert not [address for address in loads.addresses if FAR.match(address)], page.name
        assert 'class="mermaid"' not in text, "the theme would load the program for it from another host"


def test_style_sheets_load_nothing_from_another_host(site: Path) -> None:
    sheets = sorted(site.rglob("*.css"))
    assert sheets
    for sheet in sheets:
        assert not re.findall(r"url\(['\"]?(?:https?:)?//|@import", sheet.read_text(encoding="utf-8")), sheet.name


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("api-core.html", ["rank", "Scenario", "GraspTable", "BeamGrid"]),
        ("api-client.html", ["SensorClient", "ArmClient", "StaleVersionError", "load_scenario"]),
        ("api-ros.html", ["RobotMapping"]),
        ("on-your-robots.html", ["five-measures.svg", "0.17 to 0.19 m"]),
        ("decisions/0004-beam-rule.html", ["z_no_return"]),
    ],
)
def test_a_page_has_what_a_reader_looks_for(site: Path, page: str, words: list[str]) -> None:
    text = (site / page).read_text(encoding="utf-8")
    for word in words:
        assert word in text, word


def test_the_pages_can_be_searched(site: Path) -> None:
    assert "stale-version" in (site / "search/search_index.json").read_text(encoding="utf-8")
