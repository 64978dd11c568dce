"""Failures: kinds, statuses and titles that callers rely on, and the problem documents that are made of them."""

import inspect
import json
import re

import pytest
import structlog
from pydantic import BaseModel, ValidationError

from voa_msgs.base import Message
from voa_msgs.bounds import MOST_ERRORS
from voa_msgs.problems import Problem
from voa_service import failures
from voa_service.failures import Failure, HttpError, NotFound, Overloaded, document, malformed, of_message

KINDS = {
    kind
    for _, kind in inspect.getmembers(failures, inspect.isclass)
    if issubclass(kind, Failure) and kind not in (Failure, HttpError)
}
STATUSES = {
    "malformed-json": 400, "malformed-form": 400, "malformed-request": 400, "wire-version": 400, "forbidden": 403,
    "unauthenticated": 401, "too-many-requests": 429, "too-many-without-key": 429,
    "not-found": 404, "method-not-allowed": 405, "request-timeout": 408, "claim-conflict": 409, "look-counted": 409,
    "in-use": 409,
    "stale-version": 412, "too-large": 413, "unsupported-media-type": 415, "unsupported-mesh-type": 415,
    "misdirected-request": 421, "invalid-request": 422, "unknown-name": 422, "no-mesh": 422,
    "beam-grid-mismatch": 422, "invalid-mesh": 422, "not-accepted": 422, "idempotency-key-reused": 422,
    "headers-too-large": 431, "damaged": 500, "internal": 500, "rule-failed": 500, "not-ready": 503, "overloaded": 503,
}  # fmt: skip
"""Status of each kind of problem: part of the contract."""


class Pair(Message):
    """A message with two fields."""

    first: int
    second: list[int]


def invalid(body: object) -> ValidationError:
    with pytest.raises(ValidationError) as error:
        Pair.model_validate(body)
    return error.value


def test_every_kind_has_the_status_of_the_contract() -> None:
    assert {kind.kind: kind.status for kind in KINDS} == STATUSES
    assert len(KINDS) == len(STATUSES), "no two classes have one kind"


def test_titles_are_single_sentences_without_a_full_stop() -> None:
    titles = [kind.title for kind in KINDS]
    assert len(set(titles)) == len(titles)
    assert all(re.fullmatch(r"[A-Z][^.]*", title) for title in titles)


def test_a_document_is_a_problem_under_the_id_of_its_request() -> None:
    with structlog.contextvars.bound_contextvars(request_id="r1"):
        problem = Problem.model_validate_json(document(NotFound("there is no session 'S'", known=["T"])))
    assert (problem.type, problem.title, problem.status) == ("urn:voa:problem:not-found", "Not found", 404)
    assert (problem.detail, problem.known, problem.request_id) == ("there is no session 'S'", ["T"], "r1")


def test_a_document_states_the_seconds_of_its_retry_header() -> None:
    assert json.loads(document(Overloaded("full", {"Retry-After": "7"})))["retry_after_s"] == 7
    assert "retry_after_s" not in json.loads(document(Overloaded("full")))


def test_an_http_error_has_the_status_of_its_instance() -> None:
    assert (HttpError(418, "a teapot").status, HttpError(406, "no").status) == (418, 406)


def test_mistakes_of_a_message_are_listed_under_the_part_of_the_request_that_holds_it() -> None:
    failure = of_message(Pair, invalid({"frist": 1, "second": [1, "x"]}), "attachment")
    assert failure.detail.startswith("attachment.frist: no such field: expected one of first, second (and 2 more)")
    assert [mistake["field"] for mistake in failure.more["errors"]] == [
        "attachment.frist",
        "attachment.first",
        "attachment.second.1",
    ]


def test_no_more_than_the_most_mistakes_are_listed_and_all_are_counted() -> None:
    failure = of_message(Pair, invalid({"first": 1, "second": ["x"] * (MOST_ERRORS + 5)}), "body")
    assert len(failure.more["errors"]) == MOST_ERRORS
    assert failure.detail.endswith(f"(and {MOST_ERRORS + 4} more)")


@pytest.mark.parametrize(("text", "at", "advice"), [('{"a": NaN}', 6, True), ("{", 1, False)])
def test_a_body_that_is_no_json_is_refused_at_its_position_with_advice_for_nan(
    text: str, at: int, advice: bool
) -> None:
    failure = malformed("Expecting value", text, at)
    assert failure.detail.startswith("Expecting value")
    assert failure.detail.endswith(f" at character {at}")
    assert ("`no_return`" in failure.detail) is advice


def test_a_caller_of_another_wire_version_learns_both_versions() -> None:
    failure = failures.wire_failure(99)
    assert re.search(r"version 1 of the messages, the caller version 99", failure.detail)


def test_mistakes_are_described_by_the_type_of_the_message() -> None:
    class Outer(BaseModel):
        pair: Pair

    with pytest.raises(ValidationError) as error:
        Outer.model_validate({"pair": {"first": 1, "second": [], "third": 3}})
    failure = of_message(Outer, error.value, "body")
    assert failure.detail == "body.pair.third: no such field: expected one of first, second"
