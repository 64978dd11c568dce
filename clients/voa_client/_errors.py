"""Errors that clients raise.

VoaClientError
|-- UnreachableError          no response: the service is not running, the address is wrong, the network is cut
|   `-- TimedOutError         no response in time
|-- UsageError                the call is not valid: unknown scheme, empty id
|-- WireVersionError          client and service use different versions of the messages
|-- UnexpectedResponseError   the response is of another kind: another program listens there
`-- ProblemError              the service answered with a problem document
    |-- InvalidRequestError   400, 413, 415, 422: repeating the same request is of no use
    |-- DeniedError           401, 403: there is no valid key, or its role may not make the call; 429 where too many
    |                         calls without a valid key were made
    |-- NotFoundError         404
    |-- ConflictError         409: the request contradicts the state of the service
    |-- StaleVersionError     412: the session has another version
    `-- UnavailableError      429, 502, 503, 504: may succeed after a while
        `-- OverloadedError   the service is overloaded at the moment, or the key has made too many calls
"""

from voa_msgs.problems import Problem

PROXY_PROBLEM = "http-error"
"""Kind of the problem that stands for an HTTP error that a proxy sent instead of the service."""


_WITHOUT_KEY = ("unauthenticated", "too-many-without-key")
"""Kinds of the problems of calls without a valid key."""

_GIVE_KEY = "name a file with a key in VOA_KEY_FILE, or put the key into VOA_KEY (commands: --key-file)"


class VoaClientError(Exception):
    """Base class of all errors that clients raise on purpose."""


class UnreachableError(VoaClientError):
    """No response of the service was received."""


class TimedOutError(UnreachableError):
    """No response of the service was received in time."""


class UsageError(VoaClientError, ValueError):
    """The call or address is not valid, independent of the service; nothing was sent."""


class WireVersionError(VoaClientError):
    """Client and service use different versions of the messages; the error's text says which one to update."""


class UnexpectedResponseError(VoaClientError):
    """The response is not a message of the requested kind; another program may listen at the address."""


class ProblemError(VoaClientError):
    """The service refused the request; `problem` says why, and programs can match its `kind`."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(f"{problem.title}: {problem.detail}")

    @property
    def kind(self) -> str:
        """Name of the kind of problem, such as "no-mesh"."""
        return self.problem.type.rpartition(":")[2]


class InvalidRequestError(ProblemError):
    """The request is not valid; `problem.errors` lists the fields that are wrong."""


class DeniedError(ProblemError):
    """The service does not allow the request: it needs a key, or the role of the key does not allow the call."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        if self.needs_key:
            self.args = (f"{problem.detail}; {_GIVE_KEY}",)

    @property
    def needs_key(self) -> bool:
        """True if the service needs a key, and the call had none that is valid."""
        return self.kind in _WITHOUT_KEY


class NotFoundError(ProblemError):
    """The requested object, scenario, session or robot does not exist, or no longer exists."""

    @property
    def is_of_the_service(self) -> bool:
        """True if the problem is of the service itself, and not of a proxy before it."""
        return self.kind != PROXY_PROBLEM


class ConflictError(ProblemError):
    """The request contradicts the state of the service, such as a robot's mapping; `problem` says what to change."""


class StaleVersionError(ProblemError):
    """The session has another version than the request requires."""

    @property
    def version(self) -> int | None:
        """Current version of the session; None if the service did not state it."""
        return self.problem.version


class UnavailableError(ProblemError):
    """The service cannot answer at the moment; `retry_after_s` is when to try again, seconds, if it is known."""

    def __init__(self, problem: Problem, retry_after_s: float | None = None) -> None:
        super().__init__(problem)
        self.retry_after_s = retry_after_s


class OverloadedError(UnavailableError):
    """The service is overloaded at the moment, or this client's key has made too many calls."""


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
    """Make the error for a problem document.

    Args:
        problem: the document.
        retry_after_s: seconds after which to try again; None: not stated.
    """
    if problem.type.endswith(":too-many-without-key"):  # to repeat the call is of no use without another key
        return DeniedError(problem)
    if problem.status in (429, 502, 503, 504):
        is_overload = problem.type.endswith((":overloaded", ":too-many-requests"))
        kind = OverloadedError if is_overload else UnavailableError
        return kind(problem, retry_after_s)
    return _BY_STATUS.get(problem.status, ProblemError)(problem)
