"""Proves that a scenario of 20 000 poses and 1 000 places can be ranked on a desk, in bounded memory.

20 grasps, the 10k cup, `exponential`, float32, over samples of the poses (`sampled_ranking`): prediction of all scans
included, nothing kept. A process of its own, because memory is that of the process at its peak; its two threads share
the places. The figures are CPU minutes and GiB, as the ratio too: they have limits, and no peer.

In the same run the values of three places are compared with those over all poses: that of the best place, which has
the largest sample, and those of two that were left behind.
"""

import json
import resource
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from tests.benchmarks import scene
from tests.benchmarks.measure import Result, require
from voa_core.assistance import Valuation
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Looks, exact_looks
from voa_core.prediction import predictor_of_mesh
from voa_core.ranking import RankedLook
from voa_core.rules.registry import rule_of
from voa_core.sampled_ranking import rank_over_samples
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher

_POSES, _SENSORS, _GRASPS, _THREADS = 20_000, 1_000, 20, 2
_RULE = "exponential"
_STANDARD_ERRORS, _ROUNDING = 4.0, 1e-5
_SEED = "huge"


@dataclass(frozen=True)
class Measured:
    """Measured use of a ranking: CPU time in minutes, and the largest memory of the process in GiB.

    Attributes:
        cpu_min: of the ranking, over all threads.
        memory_gib: of the process when the ranking has ended.
        best_error: standard error of the best look.
    """

    cpu_min: float
    memory_gib: float
    best_error: float


def run() -> list[Result]:
    """Two figures with limits, and the standard error of the best look."""
    measured = _measured()
    what = f"huge, {_POSES} poses x {_SENSORS} places x {_GRASPS} grasps"
    return [
        Result(f"{what}, CPU minutes", measured.cpu_min, measured.cpu_min, None, "min"),
        Result(f"{what}, GiB of memory", measured.memory_gib, measured.memory_gib, None, "GiB"),
        Result(f"{what}, standard error of the best look", None, measured.best_error, None, "1"),
    ]


def _measured() -> Measured:
    """Measure in a process of its own."""
    finished = subprocess.run(
        [sys.executable, "-m", "tests.benchmarks.huge"], check=True, stdout=subprocess.PIPE, text=True
    )
    return Measured(**json.loads(finished.stdout))


def measure(poses: int, sensors: int) -> Measured:
    """Rank the places of a scene over samples of the poses, and check three of the values.

    Raises:
        AssertionError: a value is not that over all poses, within four standard errors.
    """
    object_ = scene.cup("10k")
    predictor = predictor_of_mesh(object_, scene.poses(object_, poses, planar=True), scene.LIDAR)
    rule, places, belief = rule_of(_RULE, scene.LIDAR), scene.sensors(sensors), Belief.of(scene.belief(poses))
    table = GraspTable.of_probabilities([f"G{x}" for x in range(_GRASPS)], scene.scores(_GRASPS, poses), poses)
    valuation = Valuation(belief, table, UpdatePolicy())

    def weigher(sensor: SensorConfiguration) -> Weigher:
        return Weigher.of(rule, predictor.predict(sensor), np.float32, keep=False)

    looks = Looks(exact_looks(weigher))
    start = time.process_time()
    with ThreadPoolExecutor(_THREADS) as pool:
        ranking = rank_over_samples(places, looks, valuation, seed=_SEED, ordered_map=pool.map)
    cpu_min = (time.process_time() - start) / 60.0
    memory_gib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    for look in (ranking.looks[0], ranking.looks[len(ranking.looks) // 2], ranking.looks[-1]):
        _check(look, valuation.value(looks.together(look.sensor)).voa)
    return Measured(cpu_min, memory_gib, ranking.looks[0].assistance.standard_error or 0.0)


def _check(look: RankedLook, exact: float) -> None:
    off, error = look.assistance.voa - exact, look.assistance.standard_error
    require(
        error is not None and abs(off) <= _STANDARD_ERRORS * error + _ROUNDING,
        f"the value of {look.sensor.name} over a sample is off by {off}, and its standard error is {error}",
    )


if __name__ == "__main__":
    with threadpool_limits(1):
        print(json.dumps(asdict(measure(_POSES, _SENSORS))))
