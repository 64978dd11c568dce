"""Calls about what sessions are made of, as blocking calls: objects, lidars and scenarios."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from voa_client import _calls as calls
from voa_client._call import Call, M
from voa_msgs.lidars import LidarPresets
from voa_msgs.objects import Object, StablePoses, UpAxis
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioRequest, ScenarioSummary
from voa_msgs.warnings import Warnings


class Contents(ABC):
    """Calls about objects, lidars and scenarios; programs use them by `Client`."""

    @abstractmethod
    def _do(self, call: Call[M], key: str | None = None) -> M:
        """Make a call, with as many attempts as it takes; raises VoaClientError."""

    @abstractmethod
    def _items(self, page_after: Callable[[str | None], Call[Any]]) -> Iterator[Any]:
        """Yield the items of every page of a list."""

    def create_object(
        self, mesh: Path, name: str | None = None, scale: float = 1.0, up: UpAxis | None = None
    ) -> Object:
        """Upload a mesh file, and return the stored object.

        Args:
            mesh: the file.
            name: of the object; None: the file's name.
            scale: metres per unit of the file.
            up: the axis of the file that points up, which becomes z; None: +Y in a GLB file, +Z in any other.
        """
        return self._do(calls.create_object(mesh.name, mesh.read_bytes(), name, scale, up))

    def find_object(self, mesh: Path, scale: float = 1.0, up: UpAxis | None = None) -> Object | None:
        """Return the object of a mesh file that was uploaded before with the same scale and axis, without uploading it.

        None: it was not uploaded, or the service is too old to search.
        """
        call = calls.find_object(mesh.name, mesh.read_bytes(), scale, up)
        return calls.matching_object(call, self._do(call))

    def get_object(self, object_id: str) -> Object:
        """Return a stored object."""
        return self._do(calls.get_object(object_id))

    def list_objects(self) -> Iterator[Object]:
        """Yield every object, oldest first; they are fetched a page at a time."""
        return self._items(calls.list_objects)

    def object_mesh(self, object_id: str, most_faces: int | None = None) -> bytes:
        """Return an object's mesh as binary STL, metres, z up; `most_faces` (100 or more) thins it for a picture."""
        return (self._do(calls.object_mesh(object_id, most_faces))).file

    def delete_object(self, object_id: str) -> None:
        """Delete a mesh that no scenario needs."""
        self._do(calls.delete_object(object_id))

    def delete_scenario(self, scenario_id: str) -> None:
        """Delete a scenario that no session is on."""
        self._do(calls.delete_scenario(scenario_id))

    def stable_poses(self, object_id: str) -> StablePoses:
        """Return the poses in which an object can rest on the table, with their probabilities."""
        return self._do(calls.stable_poses(object_id))

    def lidars(self) -> LidarPresets:
        """Return the lidars that scenarios can name."""
        return self._do(calls.lidars())

    def create_scenario(self, request: ScenarioRequest) -> Scenario:
        """Store a scenario, and return it with its id; equal content gives the same id."""
        return self._do(calls.create_scenario(request))

    def get_scenario(self, scenario_id: str) -> Scenario:
        """Return a stored scenario."""
        return self._do(calls.get_scenario(scenario_id))

    def list_scenarios(self) -> Iterator[ScenarioSummary]:
        """Yield every scenario, oldest first; they are fetched a page at a time."""
        return self._items(calls.list_scenarios)

    def warnings(self, scenario_id: str) -> Warnings:
        """Return the probable mistakes in a scenario."""
        return self._do(calls.warnings(scenario_id))

    def predict(self, scenario_id: str, request: PredictionsRequest | None = None) -> Predictions:
        """Return the predicted scan of each pose from each sensor configuration, or from those in the request."""
        return self._do(calls.predict(scenario_id, request or PredictionsRequest()))
