"""Ranking by the service's own use cases, on a database that lasts as long as the ranking."""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from voa_msgs.rankings import RankingRequest
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.warnings import ProbableMistake
from voa_service.bootstrap import services
from voa_service.local.document import UNLIMITED, Document
from voa_service.mapping.models import Model
from voa_service.mapping.rankings import ParallelMap
from voa_service.requests.bodies import message
from voa_service.runtime.queues import Check
from voa_service.services import Services
from voa_service.settings import Settings
from voa_store.records import StoredObject, StoredScenario

_MESH_SECONDS = 24 * 3_600


@dataclass(frozen=True)
class Parts:
    """Scenario and request from which the parts of a ranking are computed.

    Attributes:
        scenario: as it is stored.
        object: its mesh; None: all predictions are data.
        model: its mathematics in this process.
        request: with every field, as JSON.
        cache_bytes: memory for cuts, predictions and weights.
        check: called often; an exception that it raises ends the ranking.
    """

    scenario: StoredScenario
    object: StoredObject | None
    model: Model
    request: str
    cache_bytes: int
    check: Check


Distribute = Callable[[ParallelMap, Parts], ParallelMap]
"""A function that replaces the map over the service's threads by another one, for the parts of one ranking."""


@dataclass(frozen=True)
class LocalRanking:
    """A ranking with all warnings about what it was made from.

    Attributes:
        warnings: about the mesh file and the scenario.
        body: the ranking as JSON, equal to the response of POST /v1/rankings.
    """

    warnings: list[ProbableMistake]
    body: bytes


@contextmanager
def local_services(settings: Settings) -> Iterator[Services]:
    """Build the service's use cases on a temporary database and without limits on sizes, for the length of a `with`.

    Raises:
        CannotOpen: the temporary folder cannot be written.
    """
    with tempfile.TemporaryDirectory(prefix="voa-local-") as folder:
        changes = {
            "database_url": f"sqlite:///{Path(folder) / 'voa.db'}",
            "limits": UNLIMITED,
            "mesh_seconds": _MESH_SECONDS,
            "require_keys": False,
        }
        with services(settings.model_copy(update=changes)) as built:
            yield built


def stored(built: Services, document: Document) -> tuple[str, list[ProbableMistake]]:
    """Store the scenario of a document and its mesh; returns the scenario's id, and warnings about both.

    Raises:
        Failure: the mesh is not usable, or its object does not exist.
        VoaError: the scenario contradicts itself.
    """
    scenario, warnings = document.scenario, list[ProbableMistake]()
    if document.mesh is not None:
        mesh = document.mesh
        object_, _ = built.objects.create(mesh.content(), Path(mesh.path).name, None, mesh.scale, mesh.up)
        scenario = ScenarioRequest.model_copy(scenario, update={"object": object_.id})
        warnings += object_.warnings
    created, _ = built.scenarios.create(scenario)
    return created.id, [*warnings, *created.warnings]


def ranked(built: Services, document: Document, distribute: Distribute, check: Check) -> LocalRanking:
    """Rank the looks of a document as POST /v1/rankings does.

    Args:
        built: use cases of `local_services`.
        document: scenario, mesh and request.
        distribute: gives the map by which the parts of the ranking are computed.
        check: called often; an exception that it raises ends the ranking.

    Raises:
        Failure: the document is not valid.
        VoaError: the scenario contradicts itself, or the request does not fit it.
    """
    id_, warnings = stored(built, document)
    request = message(RankingRequest, document.ranking | {"scenario": id_}, UNLIMITED)
    parallel_map = distribute(built.rankings.parallel_map, _parts(built, request, check))
    rankings = replace(built.rankings, parallel_map=parallel_map, is_repeated=False)
    question = rankings.once(request)
    return LocalRanking(warnings, rankings.answer(question, check).to(question))


def _parts(built: Services, request: RankingRequest, check: Check) -> Parts:
    """Collect what the parts of a ranking are computed from."""
    store, places = built.scenarios.store, built.rankings.places
    scenario, model = store.get_scenario(request.scenario), built.rankings.models.get(request.scenario)
    assert scenario is not None  # noqa: S101 - it was stored just now
    assert model is not None  # noqa: S101 - it was stored just now
    mesh = None if model.mesh is None else store.get_object(model.mesh.object_.digest)
    return Parts(scenario, mesh, model, request.model_dump_json(), places.cache.budget, check)
