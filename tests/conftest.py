"""Fixtures that several packages' tests share: the real service, in this process and in one of its own."""

import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
import structlog
from coverage import Coverage
from hypothesis import settings
from playwright.sync_api import Browser, Page

from tests.support.browser import console_of, headless, opened
from tests.support.postgres import Server, server
from tests.support.scale import SCALE
from tests.support.serving import Service, box_obj, data_scenario, mesh_scenario, serving
from voa_client.local import local_service

_TRACED = (
    {"voa_core"}
    if "NUMBA_DISABLE_JIT" in os.environ
    else {each.name for each in Path(__file__).parent.glob("voa_*") if each.name != "voa_core"}
)
"""Folders of tests that are traced, where coverage is measured."""

_MOST_TRACED = 8 if "NUMBA_DISABLE_JIT" not in os.environ else sys.maxsize
"""Parameters of one test that are traced in a process."""
_TIMES = pytest.StashKey[Counter[str]]()

settings.register_profile("untimed", deadline=None)  # a busy machine is no fault of the code
settings.load_profile("untimed")


@pytest.fixture(autouse=True)
def logging_as_before() -> Iterator[None]:
    """Log to stderr, as a service does, and undo what a command, called in this process, has set for logs.

    Tracebacks are plain: structlog's own way to write one takes seconds, as it prints every variable in colours.
    """
    before = structlog.get_config()
    *processors, _ = before["processors"]
    plain = structlog.dev.ConsoleRenderer(colors=False, exception_formatter=structlog.dev.plain_traceback)
    structlog.configure(processors=[*processors, plain], logger_factory=lambda *_: structlog.PrintLogger(sys.stderr))
    yield
    structlog.configure(**before)


def pytest_configure(config: pytest.Config) -> None:
    """Let processes that tests start run untraced: tests in this process trace the same code, in half of the time."""
    if hasattr(config, "workerinput"):
        os.environ.pop("COVERAGE_PROCESS_CONFIG", None)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Trace only the tests in the folders of packages, those of `voa_core` where its kernels are not compiled.

    Tracing doubles the time of a test. Tests across packages, and of compiled kernels, run lines that these run too. Of
    a test with many parameters the first ones are traced: the others hardly run any other line.
    """
    tracing = Coverage.current()
    folder = item.path.relative_to(item.config.rootpath / "tests").parts[0]
    test = item.nodeid.partition("[")[0]
    times = item.config.stash.setdefault(_TIMES, Counter())
    times[test] += 1
    if tracing is None or (folder in _TRACED and times[test] <= _MOST_TRACED):
        return (yield)
    tracing.stop()
    try:
        return (yield)
    finally:
        tracing.start()


def pytest_report_header() -> str:
    """Say it once, at the top."""
    return f"VOA_TEST_SCALE: {SCALE}"


@pytest.fixture(scope="session")
def postgres() -> Iterator[Server]:
    """A real PostgreSQL for all tests of this process; each takes a database of its own."""
    with server() as own:
        yield own


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """An empty database of each kind that the service supports."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'voa.db'}"
    own: Server = request.getfixturevalue("postgres")
    return own.new_database()


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """The real service in this process, one per module of tests."""
    with serving(tmp_path_factory.mktemp("service")) as running:
        yield running


@pytest.fixture(scope="module")
def data_id(service: Service) -> str:
    """A scenario whose predictions are data."""
    return service.create(data_scenario())


@pytest.fixture(scope="module")
def mesh_id(service: Service) -> str:
    """A scenario whose predictions come from a box."""
    return service.create(mesh_scenario(service.upload(box_obj())))


@pytest.fixture(scope="session")
def process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The URL of `voa serve` in a process of its own."""
    folder: Path = tmp_path_factory.mktemp("process")
    with local_service(folder) as url:
        yield url


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """A real headless Chromium, one per module: while it runs, `asyncio.run` cannot be used in its thread."""
    with headless() as own:
        yield own


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """An empty page, 1400 x 900; the test fails if the page logs an error, or requests anything of another host."""
    with opened(browser) as own:
        yield own


@pytest.fixture(scope="session")
def console(process: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The URL of a console of the service in `process`, in a process of its own."""
    with console_of(process, tmp_path_factory.mktemp("console")) as url:
        yield url
