"""The example of an update rule in a package of its own: installed by pip beside a service, and used through it."""

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.serving import LIDAR, PREDICTIONS, SCORES, as_scan, data_scenario
from voa_assets import path
from voa_cli.main import main
from voa_client import Client, InvalidRequestError
from voa_client.local import local_service
from voa_msgs.rankings import RankingRequest
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import ScanRequest, SessionRequest

EXAMPLE = Path(__file__).resolve().parents[2] / "clients" / "examples" / "own_rule"
NO_RETURN_M, SCALE_M, CAP_M = 1.0, 0.2, 0.3
PARAMETERS = {"scale_m": SCALE_M, "cap_m": CAP_M}
UPDATE = {"rule": "plugin", "name": "capped", "no_return_m": NO_RETURN_M, "parameters": PARAMETERS}


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A service in whose environment the example is installed."""
    installed = tmp_path_factory.mktemp("installed")
    source = tmp_path_factory.mktemp("source")
    for file in EXAMPLE.iterdir():
        if file.is_file():
            (source / file.name).write_bytes(file.read_bytes())  # a build leaves nothing in the repository
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-index"]
    command += ["--no-deps", "--no-build-isolation", "--target", str(installed), str(source)]
    subprocess.run(command, check=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join([str(installed), *filter(None, [os.environ.get("PYTHONPATH")])]))
        with local_service(tmp_path_factory.mktemp("service")) as running:
            yield running


def coded(ranges: list[float | None]) -> NDArray[np.float64]:
    return np.array([NO_RETURN_M if value is None else min(value, NO_RETURN_M) for value in ranges])


def weights(scan: list[float | None], sensor: str) -> NDArray[np.float64]:
    """The formula of the example, written once more: one weight for each pose."""
    apart = [np.minimum(abs(coded(scan) - coded(ranges)), CAP_M).sum() for ranges in PREDICTIONS[sensor].values()]
    return np.exp(-np.array(apart) / SCALE_M)


def posterior(belief: NDArray[np.float64], scan: list[float | None], sensor: str) -> NDArray[np.float64]:
    joint = belief * weights(scan, sensor)
    return np.asarray(joint / joint.sum())


def best(belief: NDArray[np.float64]) -> float:
    return float((np.array(SCORES) @ belief).max())


def voa(belief: NDArray[np.float64], sensor: str) -> float:
    """Value of Assistance by its definition (equations 2 and 3)."""
    after = [best(posterior(belief, ranges, sensor)) for ranges in PREDICTIONS[sensor].values()]
    return float(belief @ np.array(after)) - best(belief)


def test_updates_and_rankings_are_those_of_the_formula(url: str) -> None:
    scan = [0.52, 0.5, None, 1.4]
    with Client(url) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario(update=UPDATE)))
        session = client.create_session(SessionRequest(scenario=scenario.id))
        before = np.full(3, 1.0 / 3.0)
        ranked = {look.sensor: look.voa for look in client.rank_looks(session.id).ranking}
        request = ScanRequest.model_validate({"sensor": "Q1", "scan": as_scan(scan)})
        answer = client.apply_scan(session.id, request)
        after = posterior(before, scan, "Q1")
        ranked_after = {look.sensor: look.voa for look in client.rank_looks(session.id).ranking}
        once = client.rank_once(RankingRequest(scenario=scenario.id, belief=after.tolist()))
    assert ranked == pytest.approx({sensor: voa(before, sensor) for sensor in PREDICTIONS}, abs=1e-12)
    assert answer.update.accepted
    assert answer.belief == pytest.approx(after.tolist(), abs=1e-12)
    assert answer.update.best_fit_pose == "P1"
    assert answer.update.log_evidence == pytest.approx(math.log(before @ weights(scan, "Q1")), abs=1e-12)
    assert ranked_after == pytest.approx({sensor: voa(after, sensor) for sensor in PREDICTIONS}, abs=1e-12)
    assert {look.sensor: look.voa for look in once.ranking} == pytest.approx(ranked_after, abs=1e-12)


def test_the_default_of_a_parameter_comes_from_the_lidar(url: str) -> None:
    defaults = UPDATE | {"parameters": {}}
    stated = UPDATE | {"parameters": {"scale_m": 10.0 * 0.02, "cap_m": 0.1}}
    beliefs = []
    with Client(url) as client:
        for update in (defaults, stated):
            body = data_scenario(update=update, lidar=LIDAR | {"noise_m": 0.02})
            scenario = client.create_scenario(ScenarioRequest.model_validate(body))
            session = client.create_session(SessionRequest(scenario=scenario.id))
            request = ScanRequest.model_validate({"sensor": "Q1", "scan": as_scan(PREDICTIONS["Q1"]["P2"])})
            beliefs.append(client.apply_scan(session.id, request).belief)
    assert beliefs[0] == beliefs[1]


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"scale": 1.0}, "no parameter 'scale'; the rule has scale_m, cap_m"),
        ({"cap_m": 0}, "expected a number above 0, got 0"),
    ],
)
def test_the_rule_refuses_wrong_parameters_itself(url: str, parameters: dict[str, float], words: str) -> None:
    body = data_scenario(update=UPDATE | {"parameters": parameters})
    with Client(url) as client, pytest.raises(InvalidRequestError, match=words) as caught:
        client.create_scenario(ScenarioRequest.model_validate(body))
    assert caught.value.kind == "invalid-request"


def test_a_recorded_experiment_is_replayed_with_it(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    folder = str(path("experiments/mug"))
    assert main(["replay", folder, "--url", url, "--rules", "margin,capped", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert list(report["rules"]) == ["margin", "capped"]
    assert all(sensor["aecd"] is not None for sensor in report["rules"]["capped"].values())


def test_a_replay_with_a_rule_that_is_not_installed_says_so(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(path("experiments/mug")), "--url", url, "--rules", "cupped"]) == 1
    assert "the update rule 'cupped' is not installed here; installed are: 'capped'" in capsys.readouterr().err
