"""Event loops of tests beside a browser, whose driver keeps a loop running in the thread of the tests."""

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def run(story: Coroutine[object, object, T]) -> T:
    """Run a coroutine in a loop and a thread of its own, and return its result."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, story).result()
