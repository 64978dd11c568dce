"""A scenario in its stored form, from which every worker builds the scenario's mathematics once."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from threadpoolctl import threadpool_limits

from voa_service.failures import NotReady
from voa_service.mapping.models import Model, Models
from voa_service.mapping.rules import load_installed_rules
from voa_service.runtime.cache import Cache
from voa_service.versions import differences, versions
from voa_store.records import StoredObject, StoredScenario


@dataclass(frozen=True, eq=False)
class Scene:
    """A stored scenario and its object, with what a worker needs to compute as the sender does.

    Attributes:
        scenario: as it is stored.
        object: its mesh; None: all predictions are data.
        cache_bytes: memory for cuts, predictions and weights in each process.
        versions: of the sender.
    """

    scenario: StoredScenario
    object: StoredObject | None
    cache_bytes: int
    versions: dict[str, str]

    def get_scenario(self, id_: str) -> StoredScenario | None:
        """Read the scenario, as a store does."""
        return self.scenario if id_ == self.scenario.id else None

    def get_object(self, id_: str) -> StoredObject | None:
        """Read the mesh, as a store does."""
        return self.object if self.object is not None and id_ == self.object.object.digest else None

    @cached_property
    def model(self) -> Model:
        """Mathematics of the scenario, which this process builds once.

        Raises:
            NotReady: this process has other versions than the sender.
            VoaError: the scenario's update rule is not installed here.
        """
        differing = differences(versions(), self.versions)
        if differing:
            raise NotReady(f"a worker of the cluster would compute other digits: {', '.join(differing)}")
        threadpool_limits(1, user_api="blas")  # for the rest of this process: each of its threads computes a part
        model = Models(self, Cache(self.cache_bytes), installed=load_installed_rules()).get(self.scenario.id)
        assert model is not None  # noqa: S101 - the scene has this scenario
        return model

    def __getstate__(self) -> dict[str, Any]:
        """Return what is sent: the mathematics stays in this process."""
        return {name: value for name, value in self.__dict__.items() if name != "model"}
