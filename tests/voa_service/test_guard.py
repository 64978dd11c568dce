"""Every error of a call becomes a failure in the guard: the kinds that callers program against, and nothing lost."""

import inspect

import pytest
import structlog

from voa_core import errors as core
from voa_core.errors import VoaError
from voa_service import failures
from voa_service.failures import Failure
from voa_service.guard import EXPECTED_ERRORS, failure_of, guarded
from voa_service.runtime.queues import Cancelled
from voa_store import errors as store
from voa_store.errors import StoreError

KINDS: list[tuple[Exception, str, int, dict[str, object]]] = [
    (core.UnknownName("grasp", "G9", ["G1"]), "unknown-name", 422, {"known": ["G1"]}),
    (core.RuleNotInstalled("mine", ["capped"]), "unknown-name", 422, {"known": ["capped"]}),
    (core.RuleFault("mine", "statistic", "NaN", "numbers"), "rule-failed", 500, {}),
    (core.NoMesh("no mesh"), "no-mesh", 422, {}),
    (core.BeamGridMismatch("beams"), "beam-grid-mismatch", 422, {}),
    (
        core.InvalidInput("prior", "a belief", "3"),
        "invalid-request",
        422,
        {"errors": [{"field": "prior", "problem": "expected a belief, got 3"}]},
    ),
    (VoaError("else"), "invalid-request", 422, {}),
    (store.SessionMissing("S"), "not-found", 404, {}),
    (store.VersionMismatch(frozenset({1}), 2), "stale-version", 412, {"version": 2}),
    (store.KeyReused("K"), "idempotency-key-reused", 422, {}),
    (store.LookRepeated("r", 3), "look-counted", 409, {}),
    (store.ContentMissing("object", "O"), "unknown-name", 422, {}),
    (store.InUse("needed"), "in-use", 409, {}),
    (store.DamagedData("bits", 4), "damaged", 500, {"version": 4}),
    (store.DamagedData("pages"), "damaged", 500, {}),
    (store.Unavailable("gone"), "not-ready", 503, {}),
    (store.Busy("full"), "overloaded", 503, {}),
    (store.CannotOpen("closed"), "not-ready", 503, {}),
    (store.FileInUse("in use"), "not-ready", 503, {}),
    (store.NewerTables("9", "6"), "not-ready", 503, {}),
]


@pytest.mark.parametrize(("error", "kind", "status", "more"), KINDS, ids=lambda value: type(value).__name__)
def test_an_expected_error_becomes_its_failure(
    error: Exception, kind: str, status: int, more: dict[str, object]
) -> None:
    failure = failure_of(error)
    assert (failure.kind, failure.status, failure.more, failure.detail) == (kind, status, more, str(error))
    assert ("Retry-After" in failure.headers) == (status == 503)
    assert isinstance(error, EXPECTED_ERRORS)


def test_every_error_of_the_store_and_the_mathematics_is_in_the_table() -> None:
    roots = (StoreError, VoaError)
    defined = {
        kind
        for module in (core, store)
        for _, kind in inspect.getmembers(module, inspect.isclass)
        if issubclass(kind, roots) and kind is not StoreError
    }
    assert {type(error) for error, *_ in KINDS} == defined


def test_work_within_the_guard_raises_failures_alone() -> None:
    with pytest.raises(failures.StaleVersion) as raised, guarded():
        raise store.VersionMismatch(frozenset({1}), 2)
    assert isinstance(raised.value.__cause__, store.VersionMismatch)


def test_failures_and_cancelled_work_pass_unchanged() -> None:
    for error in (failures.NotFound("nothing there"), Cancelled()):
        with pytest.raises(type(error)) as raised, guarded():
            raise error
        assert raised.value is error
        assert raised.value.__cause__ is None


def test_a_defect_is_logged_with_its_traceback_and_hidden_from_the_caller() -> None:
    with structlog.testing.capture_logs() as logs, pytest.raises(Failure) as raised, guarded():
        raise ZeroDivisionError("a secret")
    assert raised.value.kind == "internal"
    assert "secret" not in raised.value.detail
    (event,) = logs
    assert event["event"] == "unexpected error"
    assert isinstance(event["exc_info"], ZeroDivisionError)
