"""Bytes of request bodies that the application holds, bounded for the whole process."""

from collections.abc import Callable

from starlette.exceptions import HTTPException

from voa_service.http.asgi import Asgi, Message, Receive, Scope, Send
from voa_service.http.connections import refusals
from voa_service.http.connections.refusals import Refusal
from voa_service.http.problems import problem_response

FREE_BYTES = 65_536
"""Of each body, not counted: what robots send is taken however many large bodies are under way."""


class ByteBudget:
    """Bytes that may be held at once.

    Args:
        most: bytes.
        refused: is called for each body that does not fit.
    """

    def __init__(self, most: int, refused: Callable[[Refusal], None] = lambda _: None) -> None:
        self._most = most
        self._refused = refused
        self.held = 0
        self.refusal = refusals.bytes_in_flight(most)

    def take(self, count: int) -> bool:
        """Take bytes; False, and nothing is taken: there are not so many left."""
        if self.held + count > self._most:
            self._refused(self.refusal)
            return False
        self.held += count
        return True

    def give(self, count: int) -> None:
        """Give bytes back."""
        self.held -= count


class BytesInFlight:
    """Counts bodies while their requests are served, and answers 503 to one that the budget has no bytes for.

    Args:
        app: what is served.
        budget: of the process.
    """

    def __init__(self, app: Asgi, budget: ByteBudget) -> None:
        self._app = app
        self._budget = budget

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        came = held = 0
        refused = begun = False

        async def counted() -> Message:
            nonlocal came, held, refused
            message = await receive()
            came += len(message.get("body", b""))
            more = max(0, came - FREE_BYTES) - held
            if more and not self._budget.take(more):
                refused = True
                raise HTTPException(503, self._budget.refusal.detail)
            held += more
            return message

        async def send_unless_refused(message: Message) -> None:
            nonlocal begun
            if refused and not begun:
                return  # whatever the application makes of it
            begun = True
            await send(message)

        try:
            await self._app(scope, counted, send_unless_refused)
        except Exception:
            if not refused or begun:
                raise
        finally:
            self._budget.give(held)
        if refused and not begun:
            await problem_response(self._budget.refusal.failure())(scope, receive, send)
