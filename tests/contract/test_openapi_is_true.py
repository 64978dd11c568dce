"""A schema-driven tester finds nothing: what the OpenAPI document says is what the service does.

It runs against a service without keys, and as an operator against one with keys, where it also tries every call without
a valid key. Cases per operation follow VOA_TEST_SCALE: 15, or 200 for acceptance. VOA_SCHEMATHESIS_SEED picks others.
The stream of events has no end and is left out; tests/contract/test_events.py reads it.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.api_keys import make_key
from tests.support.scale import scaled
from voa_assets import path as asset_path
from voa_client import ApiKey, Client, HttpTransport
from voa_client.local import running
from voa_client.scenario_files import load_scenario
from voa_msgs.sessions import SessionRequest

CONFIGURATION = Path(__file__).with_name("schemathesis.toml")
CASES = {False: scaled(small=15, full=200), True: scaled(small=3, full=200)}
EVERY_PHASE = "examples,coverage,fuzzing"
PHASES = {False: EVERY_PHASE, True: scaled(small="examples,fuzzing", full=EVERY_PHASE)}
"""Cases per operation, and phases, of a service without and with keys: what differs with keys shows in few cases."""
SEED = os.environ.get("VOA_SCHEMATHESIS_SEED", "1")


@pytest.mark.parametrize("closed", [False, True], ids=["open", "with-keys"])
def test_a_schema_driven_tester_finds_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, closed: bool) -> None:
    for rate in ("CALLS", "HEAVY", "REFUSED"):
        monkeypatch.setenv(f"VOA_RATES__{rate}", "1000000/second")
    key = ApiKey(make_key(f"sqlite:///{tmp_path}/voa.db", "operator")) if closed else ApiKey()
    options = ["--database-url", f"sqlite:///{tmp_path}/voa.db", "--log-level", "ERROR"]
    with (
        running("voa_service", options, tmp_path / "log") as service,
        Client(HttpTransport(service.url, key=key)) as client,
    ):
        scenario = load_scenario(client, asset_path("mug") / "scenario.json")
        client.create_session(SessionRequest(scenario=scenario.id))
        command = [str(Path(sys.executable).with_name("schemathesis")), "--config-file", str(CONFIGURATION), "run"]
        command += [f"{service.url}/openapi.json", "--max-examples", str(CASES[closed]), "--seed", SEED]
        command += ["--phases", PHASES[closed], "--exclude-path-regex", "/events$"]
        command += ["--request-timeout", "60"]  # another program may have the machine
        command += [word for header in key.headers().items() for word in ("--header", ": ".join(header))]
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    print(done.stdout[-2000:])
    assert done.returncode == 0, done.stdout[-20_000:]
