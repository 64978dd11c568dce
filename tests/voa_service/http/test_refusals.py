"""Refusals below the application: problem documents with a request id, as those of the application."""

import json

import pytest
import structlog

from voa_connections.refusals import Refusal
from voa_service.http.refusals import refusal_response


def test_a_refusal_becomes_a_problem_document() -> None:
    response = refusal_response(Refusal("reason", "too many", "overloaded", (("Retry-After", "2"),)))
    problem = json.loads(response.body)
    assert (response.status, problem["type"], problem["detail"]) == (503, "urn:voa:problem:overloaded", "too many")
    assert problem["retry_after_s"] == 2
    assert response.headers["Content-Type"] == "application/problem+json"
    assert response.headers["X-Request-Id"] == problem["request_id"]
    assert (response.headers["Retry-After"], response.headers["Voa-Wire-Version"]) == ("2", "1")


def test_a_refusal_within_a_request_has_that_request_s_id() -> None:
    with structlog.contextvars.bound_contextvars(request_id="r1"):
        response = refusal_response(Refusal("reason", "too late", "request-timeout"))
    assert response.headers["X-Request-Id"] == json.loads(response.body)["request_id"] == "r1"


def test_a_refusal_without_a_response_makes_none() -> None:
    with pytest.raises(ValueError, match="gone: expected a refusal with a response"):
        refusal_response(Refusal("gone", "nobody is there"))
