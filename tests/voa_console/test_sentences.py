"""Sentences about calls that failed: what happened, and what to do."""

from typing import Any

import pytest

from voa_client import Problem, UnreachableError, VoaClientError
from voa_client import TimedOutError as TimedOut
from voa_client._errors import refusal
from voa_console.sentences import needs_key, not_followed, sentence_of


def problem(status: int, kind: str, detail: str = "the detail.", **more: Any) -> Problem:
    return Problem(type=f"urn:voa:problem:{kind}", title="Title", status=status, detail=detail, **more)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (refusal(problem(412, "stale-version", version=7)), ["Somebody else changed", "version 7 now"]),
        (refusal(problem(412, "stale-version")), ["Somebody else changed the session in the meantime. Look"]),
        (refusal(problem(409, "claim-conflict")), ["contradicts the present state: the detail."]),
        (refusal(problem(404, "not-found")), ["no longer exists: the detail."]),
        (refusal(problem(422, "invalid-request")), ["cannot use these values: the detail."]),
        (
            refusal(
                problem(422, "invalid-request", errors=[{"field": "body.belief", "problem": "expected 3 numbers"}])
            ),
            ["cannot use these values: belief: expected 3 numbers."],
        ),
        (refusal(problem(401, "unauthenticated")), ["does not accept the key: the detail."]),
        (refusal(problem(429, "too-many-requests"), 3.0), ["more calls than the service allows", "Try again in 3 s."]),
        (refusal(problem(429, "too-many-without-key"), 3.0), ["received no valid key, and too many such calls: the"]),
        (refusal(problem(403, "forbidden")), ["does not allow this: the detail."]),
        (refusal(problem(503, "overloaded"), 2.0), ["busy", "Try again in 2 s."]),
        (refusal(problem(503, "not-ready")), ["cannot answer at the moment: the detail.", "in a moment."]),
        (refusal(problem(500, "internal")), ["The service refused: the detail."]),
        (TimedOut("late"), ["did not answer in time", "voa doctor"]),
        (UnreachableError("no answer"), ["does not respond", "voa doctor"]),
        (VoaClientError("of another kind."), ["The call failed: of another kind."]),
    ],
)
def test_an_error_becomes_a_sentence(error: VoaClientError, words: list[str]) -> None:
    sentence = sentence_of(error)
    assert all(each in sentence for each in words), sentence
    assert sentence.endswith(".")
    assert ".." not in sentence


def test_a_key_is_needed_where_none_is_accepted_and_not_where_the_role_does_not_suffice() -> None:
    assert needs_key(refusal(problem(401, "unauthenticated")))
    assert needs_key(refusal(problem(429, "too-many-without-key"), 3.0))
    for error in (
        refusal(problem(429, "too-many-requests"), 3.0),
        refusal(problem(403, "forbidden")),
        UnreachableError("away"),
        None,
    ):
        assert not needs_key(error)


def test_a_session_that_is_not_followed_keeps_its_last_state_if_there_is_one() -> None:
    error = refusal(problem(429, "too-many-requests"), 3.0)
    assert not_followed(error, is_known=False) == sentence_of(error)
    assert not_followed(error, is_known=True).startswith(f"{sentence_of(error)} What you see is the last state")
