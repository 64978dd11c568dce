"""The service and its clients behind the router of a lab, with the shipped configuration files and certificates."""

import json
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import zenoh

from tests.support.bus import bridged
from tests.support.lab_router import FOLDER, NAMES, LabRouter, lab_router, noting, opened, script
from tests.support.routers import router
from tests.support.serving import Service, data_scenario, scan_of
from tests.support.waiting import wait_for
from voa_client import Client, Retries, UnreachableError
from voa_msgs.keys import Keys
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, ScanRequest, SessionRequest

KEYS = Keys("voa/v1/lab7")


def config_of(file: str, folder: Path, name: str) -> Path:
    """Write a shipped configuration with the certificates of a folder."""
    text = (FOLDER / file).read_text(encoding="utf-8")
    for before, after in [("/etc/voa/ca.pem", "ca.pem"), ("voa-service", name), ("tb3_1", name)]:
        text = text.replace(before, str(folder / after) if after == "ca.pem" else after)
    written = folder / f"{name}-{file}"
    written.write_text(text.replace("/etc/voa/", f"{folder}/"), encoding="utf-8")
    return written


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LabRouter]:
    with lab_router(tmp_path_factory.mktemp("lab"), "certificates") as running:
        yield running


@pytest.fixture(scope="module")
def joined_service(lab: LabRouter, service: Service) -> Iterator[Service]:
    config = config_of("service.json5", lab.folder, "service")
    with bridged(service, lab.process, config=config, root=KEYS.root):
        yield service


@contextmanager
def client(lab: LabRouter, name: str) -> Iterator[Client]:
    files = f"ca={lab.folder}/ca.pem&cert={lab.folder}/{name}.pem&key={lab.folder}/{name}.key"
    address = f"zenoh+tls://127.0.0.1:{lab.process.port}/{KEYS.root}?{files}"
    with Client(address, retries=Retries(within_s=5.0)) as own:
        yield own


def session_on(own: Client) -> str:
    scenario = own.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    return own.create_session(SessionRequest(scenario=scenario.id)).id


def test_a_robot_updates_a_session_that_others_watch(lab: LabRouter, joined_service: Service) -> None:
    with client(lab, "ur5e") as arm, client(lab, "console") as console, lab.joined("tb3_1") as robot:
        session = session_on(arm)
        states = console.follow(session)
        assert next(states).version == 0
        scan = json.dumps(scan_of([0.5, 0.5, None, 1.0]))
        for name in ("tb3_2", "tb3_1"):
            robot.put(KEYS.scan(session, name), scan, encoding=zenoh.Encoding.APPLICATION_JSON)
        assert next(states).version == 1
        states.close()
        assert [entry.version for entry in arm.history(session)] == [0, 1]  # of the two scans one is its own
        assert arm.rank_looks(session).ranking


def test_a_robot_learns_why_its_scan_was_refused(lab: LabRouter, joined_service: Service) -> None:
    with client(lab, "ur5e") as arm, lab.joined("tb3_1") as robot:
        session = session_on(arm)
        refusals: list[str] = []
        note = noting(refusals, payloads=True)
        with robot.declare_subscriber(KEYS.refused(session, "tb3_1"), note):

            def refused() -> bool:
                robot.put(KEYS.scan(session, "tb3_1"), b"{}", encoding=zenoh.Encoding.APPLICATION_JSON)
                return bool(refusals)

            wait_for(refused, "the refusal", 10.0)


def test_a_viewer_reads_and_cannot_write(lab: LabRouter, joined_service: Service) -> None:
    with client(lab, "ur5e") as arm, client(lab, "recorder") as viewer:
        session = session_on(arm)
        assert viewer.get_session(session).version == 0
        assert [entry.version for entry in viewer.history(session)] == [0]
        assert session in [each.id for each in viewer.list_sessions()]
        refusal = "the router does not let this user query it"
        with pytest.raises(UnreachableError, match=refusal):
            viewer.put_belief(session, BeliefRequest(belief=None))
        with pytest.raises(UnreachableError, match=refusal):
            viewer.apply_scan(session, ScanRequest.model_validate(scan_of([0.5, 0.5, None, 1.0])))
        assert viewer.get_session(session).version == 0


@pytest.mark.parametrize("file", ["bridge.json5", "rmw_router.json5"])
def test_the_shipped_configurations_of_robots_join_the_router(lab: LabRouter, file: str) -> None:
    config = zenoh.Config.from_file(config_of(file, lab.folder, "tb3_2"))
    config.insert_json5("connect/endpoints", json.dumps([lab.process.endpoint]))
    config.insert_json5("listen/endpoints", "[]")
    seen: list[str] = []
    with zenoh.open(config) as robot, lab.joined("service") as service:
        note = noting(seen)
        with service.declare_subscriber("tb3_2/scan", note):

            def arrived() -> bool:
                robot.put("tb3_2/scan", b"x")
                return bool(seen)

            wait_for(arrived, "a sample of the robot", 10.0)


def test_certificates_of_the_shipped_script_work(tmp_path: Path) -> None:
    folder = tmp_path / "certificates"
    for name, *hosts in [("router", "127.0.0.1", "lab"), *((name,) for name in NAMES)]:
        subprocess.run([FOLDER / "make_certificate.sh", folder, name, *hosts], check=True, stdout=subprocess.DEVNULL)
    assert oct((folder / "tb3_1.key").stat().st_mode & 0o777) == "0o600"
    text = (FOLDER / "lab.toml").read_text(encoding="utf-8").replace("/etc/zenoh", str(folder))
    written = script("make_access").configuration(script("lab_list").read(text))
    more = {path: written[path] for path in ("transport", "access_control")}
    with router(more, "tls") as process:
        lab = LabRouter(process, "certificates", folder, {})
        with opened(lab.entries_of("tb3_1")):
            pass
