"""The paper's scene, played by processes that import the client alone; over Zenoh or HTTP by one URL."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import pytest

from tests.support.replicas import replicas
from tests.support.routers import router
from voa_assets import path as asset_path
from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_msgs.sessions import SessionRequest

SCRIPT = Path(__file__).with_name("roles.py")
SECONDS = 120.0


@pytest.fixture(scope="module")
def urls(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """URLs of one service: by HTTP and by Zenoh."""
    folder = tmp_path_factory.mktemp("roles")
    with ExitStack() as stack:
        bus = stack.enter_context(router())
        database = f"sqlite:///{folder / 'voa.db'}"
        (service,) = stack.enter_context(replicas(database, folder, 1, "--zenoh", bus.endpoint))
        yield {"http": service.url, "zenoh": f"zenoh://127.0.0.1:{bus.port}"}


class Role:
    """Process that plays a role."""

    def __init__(self, role: str, url: str, session: str) -> None:
        command = [sys.executable, str(SCRIPT), role, url, session, "U_90"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def begins(self) -> None:
        """Wait until the process reports that it follows the session."""
        assert self.process.stderr is not None
        assert self.process.stderr.readline() == "following\n"

    def ends(self) -> Any:
        """Wait for the end of the process and return the JSON that it printed."""
        out, err = self.process.communicate(timeout=SECONDS)
        assert self.process.returncode == 0, err
        return json.loads(out)


@pytest.mark.parametrize("way", ["zenoh", "http"])
def test_two_robots_play_the_papers_scene_while_a_third_process_follows(urls: dict[str, str], way: str) -> None:
    url = urls[way]
    with Client(url) as client, ExitStack() as stack:
        scenario = load_scenario(client, asset_path("mug") / "scenario.json")
        session = client.create_session(SessionRequest(scenario=scenario.id))
        onlooker = stack.enter_context(Role("onlooker", url, session.id))
        onlooker.begins()
        arm, sensor = (stack.enter_context(Role(role, url, session.id)) for role in ("arm", "sensor"))
        looked, grasped = sensor.ends(), arm.ends()
        assert looked["looks"][0] == "ENE"  # the paper's first look
        assert (grasped["reason"], grasped["grasp"]) == ("score", looked["grasp"])
        assert looked["grasp"] == "OI90"
        last = client.get_session(session.id)
        assert (last.version, last.best_grasp) == (2, "OI90")
        client.delete_session(session.id)
        versions = onlooker.ends()["versions"]
        assert versions == sorted(set(versions))
        assert (versions[0], versions[-1]) == (0, last.version)
