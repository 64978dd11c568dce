"""Weights of the looks in a ranking: over exact or simulated scans, kept where they serve other rankings too."""

from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from voa_core.checks import Floats
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Looks, exact_looks
from voa_core.scan_model import ScanModel
from voa_core.simulated_weights import SimulatedWeights
from voa_core.simulation import Sampling, name_of_place
from voa_core.weights import Weigher
from voa_service.mapping.models import Precision
from voa_service.mapping.ranking_tasks import RankingTask
from voa_service.runtime.queues import Check


@dataclass(frozen=True, eq=False)
class Weighing:
    """Choices by which the weights of a ranking are computed.

    Attributes:
        precision: of the weights.
        keep: True to keep them for the next ranking.
        check: called often; an exception that it raises ends the ranking.
    """

    precision: Precision
    keep: bool
    check: Check

    @property
    def dtype(self) -> type[np.floating]:
        """Type of the weights."""
        return np.float64 if self.precision == "float64" else np.float32


def looks_of(task: RankingTask, weighing: Weighing) -> tuple[Looks, Looks | None]:
    """Return the weights of the looks of a ranking, and those over fresh simulated scans; None: scans are exact."""
    if task.samples is None:
        exact = exact_looks(
            lambda sensor: task.model.weigher(sensor, weighing.precision, weighing.keep, weighing.check)
        )
        return Looks(exact, task.pending, task.same_place), None
    model = ScanModel.of(task.scenario, task.std)
    sampling = Sampling(task.scenario.seed, task.samples)
    usual, fresh = (
        Looks(partial(_simulated, task, weighing, model, each), task.pending, task.same_place)
        for each in (sampling, sampling.fresh())
    )
    return usual, fresh


def sampled_looks_of(task: RankingTask, weighing: Weighing) -> Looks:
    """Return the weights of the looks of a ranking over samples of the poses, of which only pending ones are kept.

    There are so many places that their predictions and weights would displace everything else from the cache.
    """
    scenario = replace(task.scenario, predictor=task.scenario.predictor.without_memory())

    def weigher(sensor: SensorConfiguration) -> Weigher:
        return scenario.weigher(sensor, weighing.dtype, keep=False, check=weighing.check)

    pending = {sensor: weigher(sensor) for sensor in task.pending}
    exact = exact_looks(lambda sensor: pending[sensor] if sensor in pending else weigher(sensor))
    return Looks(exact, task.pending, task.same_place)


def _simulated(
    task: RankingTask,
    weighing: Weighing,
    model: ScanModel,
    sampling: Sampling,
    sensor: SensorConfiguration,
    scans: int,
) -> SimulatedWeights:
    """Return the weights after simulated scans in a row from a sensor configuration."""
    listed = task.scenario.lists(sensor)
    taken, log_sums = _earlier_looks(task, model, sensor)

    def make() -> SimulatedWeights:
        return SimulatedWeights.of(
            model,
            sensor,
            sampling,
            weighing.dtype,
            listed=listed,
            looks=scans,
            log_sums=log_sums,
            check=weighing.check,
        )

    if not weighing.keep:
        return make()
    place = name_of_place(sensor, listed=listed)
    return task.model.kept((place, scans, model.std, sampling, weighing.precision, taken), make, weighing.check)


def _earlier_looks(task: RankingTask, model: ScanModel, sensor: SensorConfiguration) -> tuple[Hashable, Floats | None]:
    """Return the log weights of the session's looks from a place, with a key that names them; None: they do not matter.

    Looks that weigh all copies of a pose alike have no effect on later ones.
    """
    looks = task.looks
    index = task.place_of(sensor)
    if index is None or looks.log_sums is None or looks.record.places[index].copies == 1:
        return None, None
    place = looks.record.places[index]
    displacements = model.displacements(sensor, place.copies)
    if displacements is None:
        return None, None
    copies = displacements.shape[1]
    return (looks.session, looks.record.since, index, place.looks, copies), looks.log_sums(index, copies)
