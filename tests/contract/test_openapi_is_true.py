"""A schema-driven tester finds nothing: what the OpenAPI document says is what the service does.

Cases per operation follow VOA_TEST_SCALE: 15, or 200 for acceptance. VOA_SCHEMATHESIS_SEED picks others.
The stream of events has no end and is left out; tests/contract/test_events.py reads it.
"""

import os
import subprocess
import sys
from pathlib import Path

from tests.support.scale import scaled
from voa_assets import path as asset_path
from voa_client import Client
from voa_client.local import running
from voa_client.scenario_files import load_scenario
from voa_msgs.sessions import SessionRequest

CONFIGURATION = Path(__file__).with_name("schemathesis.toml")
CASES = scaled(small=15, full=200)
SEED = os.environ.get("VOA_SCHEMATHESIS_SEED", "1")


def test_a_schema_driven_tester_finds_nothing(tmp_path: Path) -> None:
    options = ["--database-url", f"sqlite:///{tmp_path}/voa.db", "--log-level", "ERROR"]
    with running("voa_service", options, tmp_path / "log") as service, Client(service.url) as client:
        scenario = load_scenario(client, asset_path("mug") / "scenario.json")
        client.create_session(SessionRequest(scenario=scenario.id))
        command = [str(Path(sys.executable).with_name("schemathesis")), "--config-file", str(CONFIGURATION), "run"]
        command += [f"{service.url}/openapi.json", "--max-examples", str(CASES), "--seed", SEED]
        command += ["--phases", "examples,coverage,fuzzing", "--exclude-path-regex", "/events$"]
        command += ["--request-timeout", "60"]  # another program may have the machine
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    print(done.stdout[-2000:])
    assert done.returncode == 0, done.stdout[-20_000:]
