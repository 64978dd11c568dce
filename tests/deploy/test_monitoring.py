"""The dashboard and the alerts name metrics that the service has."""

import json
import re
import runpy
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped] # the library has no types

from tests.support.serving import serving
from voa_connections.settings import ConnectionSettings
from voa_service.http.server import supervised
from voa_service.runtime.metrics import Metrics
from voa_service.settings import ZenohSettings
from voa_service.usecases.health import Link
from voa_service.zenoh.link import ZenohLink

MONITORING = Path(__file__).resolve().parents[2] / "deploy" / "monitoring"
MAKER = runpy.run_path(str(MONITORING / "make_dashboard.py"))  # no package: one file
NAMES = re.compile(r"\bvoa_[a-z_]+")
LABELS = re.compile(r"\{([a-z_]+)=|\bby \(([a-z_, ]+)\)")


def rules() -> list[dict[str, Any]]:
    groups = yaml.safe_load((MONITORING / "rules.yml").read_text(encoding="utf-8"))["groups"]
    return [rule for group in groups for rule in group["rules"]]


def expressions() -> list[str]:
    panels = [target["expr"] for panel in MAKER["dashboard"]()["panels"] for target in panel["targets"]]
    return panels + [rule["expr"] for rule in rules()]


def existing(folder: Path) -> set[str]:
    """Names of the series of a service that serves HTTP and Zenoh, once each event was counted."""
    metrics = Metrics()
    metrics.robots(lambda: {"tb3": 1.0})
    supervised(ConnectionSettings(), metrics)
    link = ZenohLink(ZenohSettings(connect=["tcp/127.0.0.1:1"]), Link(), metrics, [])
    link.close()
    with serving(folder) as service:
        text = service.http.get("/metrics").text + metrics.text().decode()
    names = set()
    for name, kind in re.findall(r"(?m)^# TYPE (voa_\w+) (\w+)", text):
        names |= {name + suffix for suffix in (("_bucket", "_sum", "_count") if kind == "histogram" else ("",))}
    return names


def test_every_metric_of_the_dashboard_and_the_alerts_exists(tmp_path: Path) -> None:
    named = {name for expression in expressions() for name in NAMES.findall(expression)}
    assert named - existing(tmp_path) == set()
    assert len(named) > 15


def test_no_metric_has_a_label_for_sessions() -> None:
    labels = {part for groups in LABELS.findall(" ".join(expressions())) for part in ", ".join(groups).split(", ")}
    allowed = {"kind", "result", "robot", "promised", "success", "method", "route", "status", "le", "event", "reason"}
    assert labels - {"", "job"} <= allowed


def test_the_dashboard_is_that_of_the_table() -> None:
    assert json.loads(MAKER["DASHBOARD"].read_text(encoding="utf-8")) == MAKER["dashboard"]()


def test_parentheses_of_every_expression_match() -> None:
    for expression in expressions():
        depth = 0
        for character in expression:
            depth += {"(": 1, ")": -1}.get(character, 0)
            assert depth >= 0, expression
        assert depth == 0, expression


def test_every_alert_says_what_to_look_at() -> None:
    for rule in rules():
        assert set(rule["annotations"]) == {"summary", "look_at", "runbook"}, rule["alert"]
        assert rule["labels"]["severity"] in ("page", "warn")
