"""What can go wrong between a client and the service.

VoaClientError
|-- UnreachableError          no answer: not running, wrong address, cut off
|   `-- TimedOutError         no answer in time
|-- UsageError                the call itself makes no sense: no such scheme, an empty id
|-- WireVersionError          the two sides speak different versions of the messages
|-- UnexpectedAnswerError     an answer that is not what was asked for: something else listens there
`-- ProblemError              the service answered with a problem document
    |-- InvalidRequestError   400, 413, 415, 422: sent again, it will be refused again
    |-- DeniedError           401, 403
    |-- NotFoundError         404
    |-- ConflictError         409: it contradicts what is there
    |-- StaleVersionError     412: the session has moved on
    `-- UnavailableError      502, 503, 504: later, perhaps
        `-- OverloadedError   too much to do at the moment
"""

from voa_msgs.problems import Problem

ANSWERED_BETWEEN = "http-error"
"""The kind of a problem that a proxy's answer, or whatever else is no document of the service, stands for."""


class VoaClientError(Exception):
    """Root of what this package raises on purpose."""


class UnreachableError(VoaClientError):
    """There was no answer."""


class TimedOutError(UnreachableError):
    """There was no answer in time."""


class UsageError(VoaClientError, ValueError):
    """The call makes no sense, whatever the service is like; nothing was sent."""


class WireVersionError(VoaClientError):
    """The two sides speak different versions of the messages; says which one to update."""


class UnexpectedAnswerError(VoaClientError):
    """What came back is not what was asked for."""


class ProblemError(VoaClientError):
    """The service refused; `problem` says why, `kind` is the name to program against."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(f"{problem.title}: {problem.detail}")

    @property
    def kind(self) -> str:
        """The last part of the problem's type, as in "no-mesh"."""
        return self.problem.type.rpartition(":")[2]


class InvalidRequestError(ProblemError):
    """The request is not as expected; `problem.errors` says where."""


class DeniedError(ProblemError):
    """The caller may not do that, or did not say who it is."""


class NotFoundError(ProblemError):
    """There is no such thing, or no longer."""

    @property
    def is_of_the_service(self) -> bool:
        """Whether the service says so, and not something in between that answered in its place."""
        return self.kind != ANSWERED_BETWEEN


class ConflictError(ProblemError):
    """The request contradicts what is there, such as a robot's mapping; `problem` says what to change."""


class StaleVersionError(ProblemError):
    """The session is at another version than the caller had seen."""

    @property
    def version(self) -> int | None:
        """Where the session is."""
        return self.problem.version


class UnavailableError(ProblemError):
    """The service cannot answer at the moment."""

    def __init__(self, problem: Problem, retry_after_s: float | None = None) -> None:
        super().__init__(problem)
        self.retry_after_s = retry_after_s


class OverloadedError(UnavailableError):
    """The service has too much to do at the moment."""


_BY_STATUS: dict[int, type[ProblemError]] = {
    400: InvalidRequestError,
    401: DeniedError,
    403: DeniedError,
    404: NotFoundError,
    409: ConflictError,
    412: StaleVersionError,
    413: InvalidRequestError,
    415: InvalidRequestError,
    422: InvalidRequestError,
}


def refusal(problem: Problem, retry_after_s: float | None = None) -> ProblemError:
    """The error that a problem document is.

    Args:
        problem: the document.
        retry_after_s: when to try again, if the answer said so.
    """
    if problem.status in (502, 503, 504):
        kind = OverloadedError if problem.type.endswith(":overloaded") else UnavailableError
        return kind(problem, retry_after_s)
    return _BY_STATUS.get(problem.status, ProblemError)(problem)
