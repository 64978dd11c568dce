"""Metrics in the text form of Prometheus: names and labels that dashboards rely on."""

from collections.abc import Callable

import pytest

from voa_service.runtime.metrics import Metrics


@pytest.mark.parametrize(
    ("count", "line"),
    [
        (
            lambda own: own.request("GET", "/v1/sessions/{id}", 200, 0.25),
            'voa_http_requests_total{method="GET",route="/v1/sessions/{id}",status="200"} 1.0',
        ),
        (
            lambda own: own.request("GET", "/livez", 200, 0.25),
            'voa_http_request_seconds_bucket{le="0.25",route="/livez"} 1.0',
        ),
        (
            lambda own: own.observation("scan", "no_match"),
            'voa_observations_total{kind="scan",result="no_match"} 1.0',
        ),
        (
            lambda own: own.rpc("scan.apply", 422, 0.5),
            'voa_rpc_requests_total{method="scan.apply",status="422"} 1.0',
        ),
        (lambda own: own.rpc("scan.apply", 200, 0.5), 'voa_rpc_request_seconds_sum{method="scan.apply"} 0.5'),
        (lambda own: own.zenoh("scan received"), 'voa_zenoh_samples_total{event="scan received"} 1.0'),
        (lambda own: own.store(0.002), 'voa_store_seconds_bucket{le="0.0025"} 1.0'),
        (
            lambda own: own.attempt(1.0, success=True),
            'voa_grasp_attempts_total{promised="0.8-1.0",success="true"} 1.0',
        ),
        (
            lambda own: own.attempt(0.0, success=False),
            'voa_grasp_attempts_total{promised="0.0-0.2",success="false"} 1.0',
        ),
        (lambda own: own.attempt(0.625, success=False), "voa_grasp_promised_total 0.625"),
        (lambda own: own.robots(lambda: {"tb3": 0.5}), 'voa_robot_scan_age_seconds{robot="tb3"} 0.5'),
        (
            lambda own: own.connection("idle-closed"),
            'voa_http_connections_refused_total{reason="idle-closed"} 1.0',
        ),
    ],
)
def test_each_event_is_counted_under_its_labels(count: Callable[[Metrics], None], line: str) -> None:
    metrics = Metrics()
    assert line not in metrics.text().decode()
    count(metrics)
    assert line in metrics.text().decode().splitlines()


def test_a_gauge_is_read_whenever_the_metrics_are() -> None:
    metrics, values = Metrics(), [1.0, 2.0]
    metrics.gauge("voa_example", "An example.", lambda: values[-1])
    assert "voa_example 2.0" in metrics.text().decode()
    values.append(3.0)
    assert "voa_example 3.0" in metrics.text().decode()


def test_two_services_in_a_process_count_for_themselves() -> None:
    one, other = Metrics(), Metrics()
    one.zenoh("link up")
    assert "link up" not in other.text().decode()


def test_calls_of_one_method_are_counted_by_their_statuses() -> None:
    metrics = Metrics()
    for status in (200, 422, 200):
        metrics.rpc("scan.apply", status, 0.5)
    page = metrics.text().decode()
    assert 'voa_rpc_requests_total{method="scan.apply",status="200"} 2.0' in page
    assert 'voa_rpc_requests_total{method="scan.apply",status="422"} 1.0' in page
    assert 'voa_rpc_request_seconds_count{method="scan.apply"} 3.0' in page
