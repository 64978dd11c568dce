"""Documents for rankings without HTTP: their shape, and the sizes that they may have."""

import json
from pathlib import Path

import pytest

from tests.support.serving import data_scenario
from tests.voa_service.local.documents import data_document, mesh_document
from voa_service.failures import InvalidRequest, MalformedJson
from voa_service.local.document import UNLIMITED, MeshFile, read_document
from voa_service.settings import Limits


def test_a_document_is_a_scenario_a_mesh_file_and_a_request(tmp_path: Path) -> None:
    read = read_document(mesh_document(tmp_path, {"belief": [0.5, 0.5]}))
    assert read.scenario.name == "mesh"
    assert read.mesh == MeshFile(path=str(tmp_path / "box.obj"))
    assert read.ranking == {"belief": [0.5, 0.5]}


def test_without_mesh_and_request_it_ranks_data_under_the_prior() -> None:
    read = read_document(json.dumps({"scenario": data_scenario()}).encode())
    assert read.mesh is None
    assert read.ranking == {"belief": None}


def test_no_limit_of_the_service_holds() -> None:
    most = Limits().sensors
    sensors = [{"name": f"Q{index}", "x": 0.0, "y": 0.0, "yaw_rad": 0.0} for index in range(most + 1)]
    assert len(read_document(data_document({}, sensors=sensors)).scenario.sensors) == most + 1
    assert min(UNLIMITED.model_dump().values()) > 10**18


def test_what_is_no_document_is_a_failure() -> None:
    with pytest.raises(MalformedJson):
        read_document(b"{")
    with pytest.raises(InvalidRequest, match="scenario: this field is required"):
        read_document(b"{}")


def test_a_mesh_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidRequest, match=r"mesh\.path: .*gone\.stl: No such file"):
        MeshFile(path=str(tmp_path / "gone.stl")).content()
