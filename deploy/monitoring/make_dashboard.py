"""Write the Grafana dashboard `dashboard.json` from the table of its panels.

Run it by `python deploy/monitoring/make_dashboard.py`.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

DASHBOARD = Path(__file__).parent / "dashboard.json"
_WIDTH, _HEIGHT, _COLUMNS = 8, 8, 3


@dataclass(frozen=True)
class Panel:
    """Panel of the dashboard.

    Attributes:
        title: of the panel, with what a reader should see in it.
        unit: of Grafana: `s`, `reqps`, `percentunit`, `short`, `bytes`.
        series: expressions of Prometheus, by the legend of each.
    """

    title: str
    unit: str
    series: dict[str, str]


def _quantile(share: float, metric: str) -> str:
    return f"histogram_quantile({share}, sum by (le) (rate({metric}_bucket[5m])))"


PANELS = [
    Panel(
        "Scans and outcomes, by result",
        "reqps",
        {"{{kind}} {{result}}": "sum by (kind, result) (rate(voa_observations_total[5m]))"},
    ),
    Panel("Age of each robot's newest scan", "s", {"{{robot}}": "min by (robot) (voa_robot_scan_age_seconds)"}),
    Panel(
        "Promised and reported successes of grasps, last day",
        "short",
        {
            "promised": "sum(increase(voa_grasp_promised_total[1d]))",
            "succeeded": 'sum(increase(voa_grasp_attempts_total{success="true"}[1d]))',
            "attempted": "sum(increase(voa_grasp_attempts_total[1d]))",
        },
    ),
    Panel(
        "Success rate by promised score, last week",
        "percentunit",
        {
            "promised {{promised}}": 'sum by (promised) (increase(voa_grasp_attempts_total{success="true"}[7d]))'
            " / sum by (promised) (increase(voa_grasp_attempts_total[7d]))"
        },
    ),
    Panel(
        "Requests by route",
        "reqps",
        {"{{method}} {{route}}": "sum by (method, route) (rate(voa_http_requests_total[5m]))"},
    ),
    Panel(
        "Requests that failed, by status",
        "reqps",
        {"{{status}} {{route}}": 'sum by (status, route) (rate(voa_http_requests_total{status=~"4..|5.."}[5m]))'},
    ),
    Panel(
        "Time of a request (median and 99 %)",
        "s",
        {
            "median": _quantile(0.5, "voa_http_request_seconds"),
            "99 %": _quantile(0.99, "voa_http_request_seconds"),
        },
    ),
    Panel(
        "Time of a transaction of the database (median and 99 %)",
        "s",
        {"median": _quantile(0.5, "voa_store_seconds"), "99 %": _quantile(0.99, "voa_store_seconds")},
    ),
    Panel(
        "Requests under way or waiting",
        "short",
        {
            "reads": "sum(voa_read_requests)",
            "writes": "sum(voa_write_requests)",
            "rankings": "sum(voa_heavy_requests)",
            "meshes": "sum(voa_mesh_requests)",
            "large bodies": "sum(voa_large_requests)",
        },
    ),
    Panel("Remote calls on Zenoh", "reqps", {"{{method}}": "sum by (method) (rate(voa_rpc_requests_total[5m]))"}),
    Panel("Events on Zenoh", "reqps", {"{{event}}": "sum by (event) (rate(voa_zenoh_samples_total[5m]))"}),
    Panel("Connected to a Zenoh router", "short", {"{{instance}}": "voa_zenoh_connected"}),
    Panel(
        "Connections and followers",
        "short",
        {"connections": "sum(voa_http_connections)", "followers": "sum(voa_followers)"},
    ),
    Panel(
        "Connections refused or ended, by reason",
        "reqps",
        {"{{reason}}": "sum by (reason) (rate(voa_http_connections_refused_total[5m]))"},
    ),
    Panel("Cache of cuts, predictions and weights", "bytes", {"{{instance}}": "voa_cache_bytes"}),
]


def dashboard() -> dict[str, Any]:
    """Make the dashboard as Grafana imports or provisions it; a list on the page chooses the data source."""
    chosen = {"name": "DS_PROMETHEUS", "label": "Prometheus", "type": "datasource", "query": "prometheus"}
    return {
        "title": "VOA service",
        "uid": "voa-service",
        "schemaVersion": 39,
        "refresh": "15s",
        "time": {"from": "now-6h", "to": "now"},
        "templating": {"list": [chosen]},
        "panels": [_panel(number, panel) for number, panel in enumerate(PANELS)],
    }


def _panel(number: int, panel: Panel) -> dict[str, Any]:
    source = {"type": "prometheus", "uid": "${DS_PROMETHEUS}"}
    row, column = divmod(number, _COLUMNS)
    return {
        "id": number + 1,
        "type": "timeseries",
        "title": panel.title,
        "datasource": source,
        "gridPos": {"x": column * _WIDTH, "y": row * _HEIGHT, "w": _WIDTH, "h": _HEIGHT},
        "fieldConfig": {"defaults": {"unit": panel.unit, "min": 0}, "overrides": []},
        "targets": [
            {"refId": chr(ord("A") + index), "expr": expression, "legendFormat": legend, "datasource": source}
            for index, (legend, expression) in enumerate(panel.series.items())
        ],
    }


def main() -> None:
    """Write the dashboard."""
    DASHBOARD.write_text(json.dumps(dashboard(), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
