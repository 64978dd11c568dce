"""An asynchronous client with the surface of the synchronous one, so that one suite tests both."""

import asyncio
import inspect
from collections.abc import AsyncIterator, Generator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self, cast

from voa_client import ArmClient, AsyncArmClient, AsyncClient, AsyncSensorClient, Client, SensorClient
from voa_client._transport import AsyncTransport


class Blocking:
    """Runs a loop for as long as each call takes."""

    def __init__(self, runner: asyncio.Runner, inside: Any) -> None:
        self.runner = runner
        self.inside = inside

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __getattr__(self, name: str) -> Any:
        method = getattr(self.inside, name)

        def call(*given: Any, **named: Any) -> Any:
            result = method(*given, **named)
            return self.runner.run(result) if inspect.iscoroutine(result) else self._items(result)

        return call

    def _items(self, items: AsyncIterator[Any]) -> Generator[Any, None, None]:
        async def following() -> Any:
            return await anext(items)

        async def end() -> None:
            close = getattr(items, "aclose", None)
            if close is not None:
                await close()

        try:
            while True:
                try:
                    yield self.runner.run(following())
                except StopAsyncIteration:
                    return
        finally:
            self.runner.run(end())


@contextmanager
def blocking(to: str | AsyncTransport, **more: Any) -> Generator[Client, None, None]:
    """An `AsyncClient` that looks like a `Client`."""
    with asyncio.Runner() as runner:

        async def made() -> AsyncClient:
            return AsyncClient(to, **more)

        with Blocking(runner, runner.run(made())) as client:
            yield cast("Client", client)


def role_of(client: object, kind: str, session: str, **more: Any) -> Any:
    """The arm's or the sensor's side of a session, by whichever client."""
    if isinstance(client, Client):
        return ArmClient(client, session, **more) if kind == "arm" else SensorClient(client, session, **more)
    shown = cast("Blocking", client)
    twin: Any = AsyncArmClient if kind == "arm" else AsyncSensorClient
    return Blocking(shown.runner, twin(shown.inside, session, **more))


def is_blocking(client: object) -> bool:
    """True if the client wraps an asynchronous one."""
    return isinstance(client, Blocking)
