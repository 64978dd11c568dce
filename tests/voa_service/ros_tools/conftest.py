from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.ros_tools import RosLab, ros_lab
from tests.support.routers import Router, router


@pytest.fixture(scope="package")
def own_router() -> Iterator[Router]:
    with router() as own:
        yield own


@pytest.fixture
def lab(tmp_path: Path, own_router: Router) -> Iterator[RosLab]:
    with ros_lab(tmp_path, own_router) as own:
        yield own
