"""Update rules of other packages in the service: which are loaded, and how a fault of one is answered."""

import re
from pathlib import Path
from typing import Any

import pytest
import structlog

from tests.support.packages import write_package
from tests.support.serving import PREDICTIONS, Json, Service, as_scan, data_scenario, serving
from voa_service.mapping.rules import load_installed_rules

SOURCE = """
import numpy as np
from voa_core.rules.exponential import Exponential

class Failing(Exponential):
    def log_weights(self, statistic, beams, /):
        raise RuntimeError("out of order")

class NotANumber(Exponential):
    def log_weights(self, statistic, beams, /):
        return np.full_like(statistic, np.nan)

def plain(parameters, no_return_m, lidar):
    if parameters:
        raise ValueError(f"no parameters, not {sorted(parameters)}")
    return Exponential(no_return_m)

def failing(parameters, no_return_m, lidar):
    return Failing(no_return_m)

def nan(parameters, no_return_m, lidar):
    return NotANumber(no_return_m)
"""
BELIEF = [0.5, 0.5, 0.0]
RULES = {name: f"faulty_rules:{name}" for name in ("plain", "failing", "nan")}


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder on the path of Python with a package that provides three rules."""
    folder = tmp_path / "packages"
    folder.mkdir()
    write_package(folder, "faulty_rules", SOURCE, RULES)
    monkeypatch.syspath_prepend(folder)
    return folder


def plugin(name: str, **more: Any) -> Json:
    return data_scenario(update={"rule": "plugin", "name": name, "no_return_m": 1.0} | more)


def problem(service: Service, path: str, body: Json, status: int) -> Json:
    answer = service.http.post(path, json=body)
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    return dict(answer.json())


def test_without_packages_no_rule_is_installed() -> None:
    assert load_installed_rules() == {}


@pytest.mark.usefixtures("installed")
def test_the_rules_of_entry_points_are_loaded() -> None:
    assert set(load_installed_rules()) == set(RULES)


def test_a_rule_that_cannot_be_loaded_is_logged_and_left_out(installed: Path) -> None:
    write_package(installed, "broken_rules", "raise ImportError('no such library')\n", {"broken": "broken_rules:make"})
    write_package(installed, "other_rules", "plain = None\n", {"plain": "other_rules:plain"})
    with structlog.testing.capture_logs() as logs:
        rules = load_installed_rules()
    assert set(rules) == set(RULES)
    refused = [(entry["rule"], entry["source"]) for entry in logs if entry["event"] == "an update rule is not loaded"]
    assert len(refused) == 2
    assert ("broken", "broken_rules:make") in refused
    assert {rule for rule, _ in refused} == {"broken", "plain"}


@pytest.mark.usefixtures("installed")
def test_a_rule_that_is_not_installed_is_422_and_lists_those_that_are(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        refused = problem(service, "/v1/scenarios", plugin("other"), 422)
    assert refused["type"] == "urn:voa:problem:unknown-name"
    assert refused["known"] == sorted(RULES)
    assert "'other' is not installed here; installed are: 'failing', 'nan', 'plain'" in refused["detail"]


@pytest.mark.usefixtures("installed")
def test_parameters_are_the_rules_to_refuse_and_part_of_the_scenarios_id(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        refused = problem(service, "/v1/scenarios", plugin("plain", parameters={"scale": 1}), 422)
        ids = {
            service.create(plugin("failing", parameters=parameters))
            for parameters in ({}, {"scale": 1}, {"scale": 2}, {"scale": [1, {"of": None}]})
        }
        assert len(ids | {service.create(plugin("plain"))}) == 5
        assert service.create(plugin("plain", parameters={})) == service.create(plugin("plain"))
        stored = service.get(f"/v1/scenarios/{service.create(plugin('plain'))}")["update"]
    assert refused["errors"][0]["field"] == "update.parameters"
    assert "no parameters, not ['scale']" in refused["detail"]
    assert (stored["rule"], stored["name"], stored["parameters"], stored["no_return_m"]) == ("plugin", "plain", {}, 1.0)


@pytest.mark.usefixtures("installed")
def test_a_rule_of_a_package_that_computes_what_a_built_in_rule_does_gives_the_same(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        scan = {"sensor": "Q1", "scan": as_scan(PREDICTIONS["Q1"]["P2"])}
        answers = []
        for body in (plugin("plain"), data_scenario()):
            scenario = service.create(body)
            session = service.open(scenario)
            update = service.post(f"/v1/sessions/{session}/scans", scan)
            ranking = service.get(f"/v1/sessions/{session}/voa?outcomes=true")
            answers.append((update["belief"], update["update"], ranking["ranking"], ranking["recommendation"]))
        assert answers[0] == answers[1]


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("rule", "words"), [("failing", "failed in log_weights: .* RuntimeError: out of order"), ("nan", "got NaN")]
)
def test_a_fault_of_a_rule_is_a_problem_with_words_and_changes_nothing(tmp_path: Path, rule: str, words: str) -> None:
    with serving(tmp_path) as service:
        scenario = service.create(plugin(rule))
        session = service.open(scenario)
        scan = {"sensor": "Q1", "scan": as_scan(PREDICTIONS["Q1"]["P2"])}
        for path, body in (
            (f"/v1/sessions/{session}/scans", scan),
            ("/v1/updates", scan | {"scenario": scenario, "belief": BELIEF}),
            ("/v1/rankings", {"scenario": scenario, "belief": BELIEF}),
        ):
            failed = problem(service, path, body, 500)
            assert failed["type"] == "urn:voa:problem:rule-failed"
            assert re.search(words, failed["detail"]), failed["detail"]
        assert service.get(f"/v1/sessions/{session}")["version"] == 0


def test_a_stored_scenario_whose_rule_is_gone_can_be_read_and_says_why_it_cannot_be_used(
    tmp_path: Path, installed: Path
) -> None:
    with serving(tmp_path) as service:
        scenario = service.create(plugin("plain"))
        session = service.open(scenario)
    for file in installed.glob("*.dist-info/*"):
        file.unlink()
    with serving(tmp_path) as service:
        assert service.get(f"/v1/scenarios/{scenario}")["update"]["name"] == "plain"
        for answer in (
            service.http.get(f"/v1/sessions/{session}/voa"),
            service.http.post("/v1/sessions", json={"scenario": scenario}),
        ):
            assert answer.status_code == 422
            assert "the update rule 'plain' is not installed here; installed are: none" in answer.json()["detail"]
