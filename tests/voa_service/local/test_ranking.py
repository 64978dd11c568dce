"""Rankings without HTTP are those of the service."""

import json
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.voa_service.local.documents import data_document, local, mesh_document, nothing
from voa_client import Client
from voa_core.errors import VoaError
from voa_core.scenario import Scenario
from voa_core.weights import Weigher
from voa_msgs.scenarios import ScenarioRequest
from voa_service.failures import InvalidMesh, InvalidRequest, UnknownReference
from voa_service.local.document import read_document
from voa_service.local.ranking import LocalRanking, Parts, ranked
from voa_service.mapping.rankings import ParallelMap
from voa_service.runtime.queues import Cancelled

SIMULATED = {"scans": "simulated", "samples": 5, "outcomes": True, "sensor_std": {"xy_m": 0.01, "yaw_rad": 0.02}}


def on_threads(threads: ParallelMap, _parts: Parts) -> ParallelMap:
    return threads


def ranking(document: bytes) -> LocalRanking:
    with local() as built:
        return ranked(built, read_document(document), on_threads, nothing)


def over_http(url: str, document: bytes) -> bytes:
    """The response of POST /v1/rankings to the request of a document."""
    content = json.loads(document)
    scenario = content["scenario"]
    with Client(url) as client:
        if content.get("mesh"):
            scenario = scenario | {"object": client.create_object(Path(content["mesh"]["path"])).id}
        stored = client.create_scenario(ScenarioRequest.model_validate(scenario))
    response = httpx2.post(f"{url}/v1/rankings", json=content["ranking"] | {"scenario": stored.id})
    return response.raise_for_status().content


@pytest.mark.parametrize(
    "request_", [{"belief": [0.2, 0.3, 0.5], "outcomes": True}, {"belief": None, "grasps": ["G2"], "lookahead": 1}]
)
def test_a_ranking_of_data_is_the_response_of_the_service_byte_for_byte(process: str, request_: Any) -> None:
    document = data_document(request_)
    assert ranking(document).body == over_http(process, document)


@pytest.mark.parametrize("options", [{}, SIMULATED])
def test_a_ranking_of_a_mesh_is_the_response_of_the_service_byte_for_byte(
    process: str, tmp_path: Path, options: dict[str, Any]
) -> None:
    document = mesh_document(tmp_path, {"belief": [0.4, 0.6]} | options)
    assert ranking(document).body == over_http(process, document)


@pytest.mark.parametrize(("lookahead", "keeps"), [(1, False), (2, True)])
def test_weights_are_kept_only_where_pairs_of_looks_may_be_valued(
    lookahead: int, keeps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: list[bool] = []
    plain = Scenario.weigher

    def spying(self: Scenario, *arguments: Any, keep: bool, **options: Any) -> Weigher:
        kept.append(keep)
        return plain(self, *arguments, keep=keep, **options)

    monkeypatch.setattr(Scenario, "weigher", spying)
    ranking(data_document({"belief": [0.2, 0.3, 0.5], "lookahead": lookahead}))
    assert set(kept) == {keeps}


def test_warnings_are_about_the_mesh_file_and_the_scenario(tmp_path: Path) -> None:
    content = json.loads(mesh_document(tmp_path, {"belief": None}))
    content["mesh"]["scale"] = 100.0
    kinds = [warning.kind for warning in ranking(json.dumps(content).encode()).warnings]
    assert kinds[0] == "extent"
    assert "no-workspace" in kinds


def test_mistakes_are_refused_as_over_http(tmp_path: Path) -> None:
    with pytest.raises(VoaError):
        ranking(data_document({"belief": [0.5, 0.5]}))
    with pytest.raises(InvalidRequest, match="no such field"):
        ranking(data_document({"belief": None, "grasp": ["G1"]}))
    with pytest.raises(UnknownReference, match="there is no object"):
        ranking(data_document({"belief": None}, object="f" * 64))
    broken = json.loads(mesh_document(tmp_path, {"belief": None}))
    Path(broken["mesh"]["path"]).write_text("no mesh", encoding="utf-8")
    with pytest.raises(InvalidMesh):
        ranking(json.dumps(broken).encode())


def test_the_check_ends_a_ranking() -> None:
    def ended() -> None:
        raise Cancelled

    with local() as built, pytest.raises(Cancelled):
        ranked(built, read_document(data_document({"belief": None})), on_threads, ended)
