"""What can go wrong between a client and the service.

VoaClientError
|-- UnreachableError    no answer: not running, wrong address, cut off, too slow
`-- ProblemError        the service answered with a problem document
"""

from voa_msgs.problems import Problem


class VoaClientError(Exception):
    """Root of what this package raises on purpose."""


class UnreachableError(VoaClientError):
    """There was no answer."""


class ProblemError(VoaClientError):
    """The service refused; `problem` says why, `kind` is the name to program against."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(f"{problem.title}: {problem.detail}")

    @property
    def kind(self) -> str:
        """The last part of the problem's type, as in "no-mesh"."""
        return self.problem.type.rpartition(":")[2]
