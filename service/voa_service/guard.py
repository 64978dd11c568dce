"""The guard around every entrypoint's work: whatever goes wrong inside becomes a `Failure`.

Use cases, the mathematics and the store raise errors of their own. An entrypoint (HTTP, Zenoh, remote calls) does its
work within `with guarded():` and then needs a single `except Failure`; an exception handler that already holds an
error calls `failure_of(error)`. Within an entrypoint, code that decides by the kind of a failure guards the call that
it decides about. Where an error means something particular to a use case (a mesh that cannot rest, a request in
another encoding), the use case raises the failure of that meaning itself.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import structlog

from voa_core import errors as core
from voa_core.errors import VoaError
from voa_service import failures
from voa_service.failures import Failure
from voa_service.runtime.queues import Cancelled
from voa_store import errors as store
from voa_store.errors import StoreError

EXPECTED_ERRORS = (Failure, VoaError, StoreError)
"""Base classes of the errors that are raised on purpose; any other exception is a defect of the service."""

_MOST_NAMES = 100
_RETRY_SOON = {"Retry-After": "1"}


@contextmanager
def guarded() -> Iterator[None]:
    """Turn every error that leaves the `with` block into a `Failure`; an unexpected one is logged with its traceback.

    Also usable as a decorator: `@guarded()`. `Cancelled` passes unchanged, because nobody waits for a response then.

    Raises:
        Failure: the work failed; its cause is the original error.
    """
    try:
        yield
    except (Failure, Cancelled):
        raise
    except Exception as error:
        raise failure_of(error) from error


def failure_of(error: Exception) -> Failure:
    """Return the failure that describes an error to a caller.

    Args:
        error: raised by the mathematics (`VoaError`), by the store (`StoreError`), a `Failure`, which is returned
            unchanged, or anything else: that is a defect, which is logged with its traceback.
    """
    match error:
        case Failure():
            return error
        case VoaError():
            return _of_mathematics(error)
        case StoreError():
            return _of_store(error)
        case _:
            structlog.get_logger().exception("unexpected error", exc_info=error)
            return failures.InternalError("this is a defect of the service; its log has the request id")


def _of_mathematics(error: VoaError) -> Failure:
    match error:
        case core.UnknownName():
            return failures.UnknownReference(str(error), known=error.known[:_MOST_NAMES])
        case core.NoMesh():
            return failures.MeshRequired(str(error))
        case core.BeamGridMismatch():
            return failures.BeamGridMismatch(str(error))
        case core.RuleFault():
            structlog.get_logger().error("an update rule of another package failed", rule=error.name, exc_info=error)
            return failures.RuleFailed(str(error))
        case core.InvalidInput():
            problem = f"expected {error.expected}, got {error.got}"
            return failures.InvalidRequest(str(error), errors=[{"field": error.field, "problem": problem}])
        case _:
            return failures.InvalidRequest(str(error))


def _of_store(error: StoreError) -> Failure:
    match error:
        case store.VersionMismatch():
            return failures.StaleVersion(str(error), version=error.version)
        case store.DamagedData() if error.version is not None:
            return failures.Damaged(str(error), version=error.version)
        case store.Unavailable() | store.Busy() | store.CannotOpen():
            kind = failures.Overloaded if isinstance(error, store.Busy) else failures.NotReady
            return kind(str(error), _RETRY_SOON)
        case _:
            return _STORE_FAILURES[type(error)](str(error))


_STORE_FAILURES: dict[type[StoreError], type[Failure]] = {
    store.SessionMissing: failures.NotFound,
    store.ContentMissing: failures.UnknownReference,
    store.InUse: failures.InUse,
    store.KeyReused: failures.IdempotencyKeyReused,
    store.LookRepeated: failures.LookCounted,
    store.DamagedData: failures.Damaged,
}
