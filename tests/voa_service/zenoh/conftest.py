"""Fixtures of the tests of the Zenoh entrypoint."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.support.serving import serving
from tests.voa_service.zenoh.replica_pair import Pair


@pytest.fixture
def pair(tmp_path: Path) -> Iterator[Pair]:
    """Two processes on one database."""
    with ExitStack() as stack:
        yield Pair([stack.enter_context(serving(tmp_path)) for _ in range(2)])
