"""Builds the mathematics of stored scenarios, and keeps their cuts, predictions and weights in a bounded cache."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

import numpy as np
import structlog

from voa_core.cutting import Contours, cut_poses
from voa_core.errors import VoaError
from voa_core.lidars import SensorConfiguration
from voa_core.mistakes.effort import QUICK, THOROUGH, Effort
from voa_core.mistakes.heights import Mesh
from voa_core.mistakes.mistake import Mistake
from voa_core.mistakes.scenarios import mistakes_of_scenario
from voa_core.objects import Object
from voa_core.panels import size_in_panels
from voa_core.poses import PoseSet
from voa_core.scenario import Scenario
from voa_core.simulated_weights import SimulatedWeights
from voa_core.weights import Weigher
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.warnings import ProbableMistake
from voa_service.failures import Failure, UnknownReference, not_found
from voa_service.mapping.rules import NO_RULES, InstalledRules
from voa_service.mapping.scenarios import scenario_of
from voa_service.mapping.warnings import warning_messages
from voa_service.ports import Contents
from voa_service.requests import large_json
from voa_service.runtime.cache import Cache, Sized
from voa_service.runtime.queues import Check
from voa_service.settings import MOST_FLOAT64_WEIGHTS, PrecisionSetting

Precision = Literal["float64", "float32"]

_TYPES: dict[Precision, type[np.floating]] = {"float64": np.float64, "float32": np.float32}

_WARNINGS_BYTES = 8 * 2**20
_SHARE_FOR_WEIGHTS = 0.9  # of the cache; a ranking that filled it completely would evict its own weights


K = TypeVar("K", bound=Sized)


@dataclass(frozen=True, eq=False)
class Model:
    """A stored scenario with its mathematics and its object.

    Attributes:
        scenario: the mathematics.
        mesh: the object; None where all predictions are data.
        weigher: returns the weights between the predictions of a sensor configuration. Its arguments are the sensor
            configuration, the precision, whether the weights are kept in the cache, and a check that ends the
            computation by an exception.
        kept: returns the weights of simulated scans of a key, computed by the function beside it where the cache does
            not hold them.
    """

    scenario: Scenario
    mesh: Mesh | None
    weigher: Callable[[SensorConfiguration, Precision, bool, Check], Weigher]
    kept: Callable[[Hashable, Callable[[], SimulatedWeights], Check], SimulatedWeights]

    @property
    def nbytes(self) -> int:
        """Memory held by the scenario's own tables, in bytes, without the cache's separate entries."""
        data = sum(ranges.nbytes for ranges in self.scenario.predictor.data.values())
        table = self.scenario.table
        scores = table.scores.nbytes * (1 if table.attempts is None else 2)  # with their variances
        return data + scores + 512 * len(self.scenario.poses)


@dataclass(frozen=True, eq=False)
class _Warnings:
    """Warnings about a scenario, as an entry of the cache."""

    items: tuple[ProbableMistake, ...]

    @property
    def nbytes(self) -> int:
        return sum(512 + 64 * len([*(each.poses or ()), *(each.sensors or ())]) for each in self.items)


class Models:
    """Models of stored scenarios by id; all of it can be built again from the store.

    Args:
        store: with the scenarios and objects.
        cache: keeps models, cuts, predictions and weights.
        precision: of rankings, as the settings say.
        installed: the update rules of other packages.
    """

    def __init__(
        self, store: Contents, cache: Cache, precision: PrecisionSetting = "auto", installed: InstalledRules = NO_RULES
    ) -> None:
        self._store = store
        self._installed = installed
        self._precision = precision
        self._cache = cache
        self._warnings = Cache(_WARNINGS_BYTES)  # a cache of its own: a large ranking must not evict them

    def get(self, id_: str) -> Model | None:
        """Return the model of a stored scenario; None: there is no such scenario.

        Raises:
            VoaError: its update rule is not installed any more.
        """

        def make() -> Model:
            stored = self._store.get_scenario(id_)
            if stored is None:
                raise KeyError(id_)
            return self.build(id_, ScenarioRequest.model_validate(large_json.loads(stored.body)))

        try:
            return self._cache.get(("model", id_), make)
        except KeyError:
            return None

    def keep(self, id_: str, model: Model) -> None:
        """Keep the model of a scenario that was just stored, so that it need not be built again."""
        self._cache.put(("model", id_), model)

    def forget(self, id_: str) -> None:
        """Drop the model of a scenario that was deleted."""
        self._cache.drop(("model", id_))

    def build(self, id_: str, request: ScenarioRequest) -> Model:
        """Build the model of a filled-in scenario.

        Raises:
            UnknownReference: its object does not exist.
            VoaError: the scenario contradicts itself.
        """
        mesh, contours_at = None, None
        if request.object is not None:
            stored = self._store.get_object(request.object)
            if stored is None:
                raise UnknownReference(f"there is no object {request.object!r}: upload it with POST /v1/objects")
            mesh = Mesh(stored.object, stored.up)
            contours_at = self._contours_at(id_, stored.object)

        def remember(key: Hashable, make: Callable[[], K]) -> K:
            return self._cache.get(("prediction", id_, key), make)

        scenario = replace(scenario_of(request, contours_at, remember, self._installed), seed=id_)

        def weigher(sensor: SensorConfiguration, precision: Precision, keep: bool, check: Check) -> Weigher:
            def make() -> Weigher:
                return scenario.weigher(sensor, _TYPES[precision], keep=keep, check=check)

            return self._cache.get(("weigher", id_, sensor, precision, keep), make, check)

        def kept(key: Hashable, make: Callable[[], SimulatedWeights], check: Check) -> SimulatedWeights:
            return self._cache.get(("simulated", id_, key), make, check)

        return Model(scenario, mesh, weigher, kept)

    def warnings(self, id_: str) -> tuple[ProbableMistake, ...]:
        """Search for probable mistakes in a stored scenario, at a bounded cost; the warnings about them are kept.

        An error of the search is logged, and there are then no warnings: no response depends on them.
        """

        def make() -> _Warnings:
            try:
                return _Warnings(tuple(warning_messages(self.find_mistakes(id_, QUICK))))
            except VoaError:  # its update rule is not installed any more: it can be read all the same
                return _Warnings(())
            except Failure:
                raise
            except Exception:
                structlog.get_logger().exception("the search for probable mistakes failed", scenario=id_)
                return _Warnings(())

        return self._warnings.get(id_, make).items

    def find_mistakes(self, id_: str, effort: Effort = THOROUGH) -> tuple[Mistake, ...]:
        """Search for probable mistakes in a stored scenario, with the given effort.

        Raises:
            NotFound: there is no such scenario.
        """
        model = self.get(id_)
        if model is None:
            raise not_found("scenario", id_)
        return mistakes_of_scenario(model.scenario, model.mesh, effort)

    def _contours_at(self, id_: str, object_: Object) -> Callable[[PoseSet, float], Contours]:
        def contours_at(poses: PoseSet, height_m: float) -> Contours:
            return self._cache.get(("contours", id_, height_m), lambda: cut_poses(object_, poses, height_m))

        return contours_at

    def precision(self, weights: int) -> Precision:
        """Choose the precision of a ranking, from its number of weights; never from the machine's memory."""
        if self._precision != "auto":
            return self._precision
        return "float64" if weights <= MOST_FLOAT64_WEIGHTS else "float32"

    def keeps_weights(self, places: int, scans: int, poses: int, precision: Precision) -> bool:
        """True if the weights of all places of a ranking fit into the cache together.

        Args:
            places: number of sensor configurations.
            scans: number of scans that a look from each may give.
            poses: number of poses.
            precision: of the weights.
        """
        held = places * size_in_panels(scans, poses, np.dtype(_TYPES[precision]))
        return held <= _SHARE_FOR_WEIGHTS * self._cache.budget
