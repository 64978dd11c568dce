"""Scenes: what a worker builds a scenario from."""

import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from tests.voa_service.local.documents import local, mesh_document
from voa_service.cluster.scene import Scene
from voa_service.failures import NotReady
from voa_service.local.document import read_document
from voa_service.local.ranking import stored
from voa_service.versions import versions


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    with local() as built:
        id_, _ = stored(built, read_document(mesh_document(tmp_path, {})))
        store, model = built.scenarios.store, built.rankings.models.get(id_)
        scenario = store.get_scenario(id_)
        assert scenario is not None
        assert model is not None
        assert model.mesh is not None
        return Scene(scenario, store.get_object(model.mesh.object_.digest), 2**20, versions())


def test_its_model_is_built_once_and_stays_here(scene: Scene) -> None:
    assert scene.model is scene.model
    assert scene.model.scenario.seed == scene.scenario.id
    arrived = pickle.loads(pickle.dumps(scene))  # noqa: S301 - our own
    assert "model" not in vars(arrived)
    assert arrived.model.scenario.seed == scene.scenario.id


def test_it_reads_as_a_store_does(scene: Scene) -> None:
    assert scene.object is not None
    assert scene.get_scenario(scene.scenario.id) is scene.scenario
    assert scene.get_object(scene.object.object.digest) is scene.object
    assert (scene.get_scenario("other"), scene.get_object("other")) == (None, None)


def test_other_versions_would_give_other_digits(scene: Scene) -> None:
    with pytest.raises(NotReady, match=r"other digits: numpy .* there, 1\.0 here"):
        assert replace(scene, versions=versions() | {"numpy": "1.0"}).model
