"""Fixtures that several packages' tests share: the real service, in this process and in one of its own."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.serving import Service, box_obj, data_scenario, mesh_scenario, serving
from voa_cli.local_service import local_service


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """The real service in this process, one per module of tests."""
    with serving(tmp_path_factory.mktemp("service")) as running:
        yield running


@pytest.fixture(scope="module")
def data_id(service: Service) -> str:
    """A scenario whose predictions are data."""
    return service.create(data_scenario())


@pytest.fixture(scope="module")
def mesh_id(service: Service) -> str:
    """A scenario whose predictions come from a box."""
    return service.create(mesh_scenario(service.upload(box_obj())))


@pytest.fixture(scope="session")
def process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The URL of `voa serve` in a process of its own."""
    folder: Path = tmp_path_factory.mktemp("process")
    with local_service(folder) as url:
        yield url
