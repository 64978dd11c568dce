"""The bodies that robots send: scans of a shipped scenario, simulated once and sent many times.

A robot stands at each place of its scenario in turn and sends ten scans from there, as a lidar of 5 Hz does within two
seconds. The ranges are those that the service predicts for the true pose, on the other beams the walls of a room, all
with Gaussian noise, in whole millimetres. After its last place a robot opens the next session.
"""

import json
from pathlib import Path

import numpy as np

from voa_client import Client, ScanRequest, SessionRequest
from voa_client.scenario_files import load_scenario

ASSETS = Path(__file__).parents[2] / "assets/voa_assets"
PER_STOP = 10
"""Scans from one place before a robot drives on."""
NOISE_M = 0.01
WALLS_M = 2.5
_SEED = 2310


def prepared(url: str, name: str, file: Path, key: str | None = None) -> None:
    """Store a shipped scenario, and write for each of its poses the bodies of a session's scans to a JSON file.

    A session of its own looks from each place, so that what the service computes once is not measured.
    """
    with Client(url, key=key) as client:
        scenario = load_scenario(client, ASSETS / name)
        predictions = client.predict(scenario.id)
        noise = np.random.default_rng(_SEED)
        tours = [
            [
                _body(sensor, predictions.ranges[place][pose], noise)
                for place, sensor in enumerate(predictions.sensors)
                for _ in range(PER_STOP)
            ]
            for pose in range(len(predictions.poses))
        ]
        session = client.create_session(SessionRequest(scenario=scenario.id))
        for body in tours[0][::PER_STOP]:
            client.apply_scan(session.id, ScanRequest.model_validate_json(body))
    file.write_text(json.dumps({"scenario": scenario.id, "tours": tours}), encoding="utf-8")


def _body(sensor: str, exact: list[float | None], noise: np.random.Generator) -> str:
    """Write one scan as JSON."""
    off = noise.normal(0.0, NOISE_M, len(exact))
    ranges = [round((WALLS_M if r is None else r) + float(d), 3) for r, d in zip(exact, off, strict=True)]
    return json.dumps({"sensor": sensor, "scan": {"ranges": ranges}})
