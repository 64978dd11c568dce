"""A bound, for the whole process, on the bytes of request bodies that the application holds."""

from collections.abc import Callable

from starlette.exceptions import HTTPException
from starlette.responses import Response

from voa_connections import refusals
from voa_connections.asgi import Asgi, Message, Receive, Scope, Send
from voa_connections.refusals import Refusal
from voa_connections.responses import Respond

FREE_BYTES = 65_536
"""First bytes of each body that are not counted, so that scans are accepted however many large bodies there are."""


class ByteBudget:
    """A budget of bytes that may be held at once.

    Args:
        most: size of the budget, bytes.
        refused: called for each body that exceeds the budget.
    """

    def __init__(self, most: int, refused: Callable[[Refusal], None] = lambda _: None) -> None:
        self._most = most
        self._refused = refused
        self.held = 0
        self.refusal = refusals.bytes_in_flight(most)

    def take(self, count: int) -> bool:
        """Take bytes from the budget; returns False and takes none where fewer are left."""
        if self.held + count > self._most:
            self._refused(self.refusal)
            return False
        self.held += count
        return True

    def give(self, count: int) -> None:
        """Return bytes to the budget."""
        self.held -= count


class BytesInFlight:
    """ASGI middleware that counts the bodies of requests, and answers 503 where they exceed the budget.

    Args:
        app: the application behind this middleware.
        budget: of the process.
        respond: makes the response of a refusal.
    """

    def __init__(self, app: Asgi, budget: ByteBudget, respond: Respond) -> None:
        self._app = app
        self._budget = budget
        self._respond = respond

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        arrived = held = 0
        refused = begun = False

        async def counted() -> Message:
            nonlocal arrived, held, refused
            message = await receive()
            arrived += len(message.get("body", b""))
            more = max(0, arrived - FREE_BYTES) - held
            if more and not self._budget.take(more):
                refused = True
                raise HTTPException(503, self._budget.refusal.detail)
            held += more
            return message

        async def send_unless_refused(message: Message) -> None:
            nonlocal begun
            if refused and not begun:
                return  # the refusal is sent below, whatever the application answers
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
            response = self._respond(self._budget.refusal)
            await Response(response.body, response.status, response.headers)(scope, receive, send)
