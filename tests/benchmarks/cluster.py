"""Rankings on a cluster: two workers against one, and what a task and a byte cost the process that sends them.

The machine of a benchmark is shared, and a wall clock would measure the others. A ranking on a cluster takes as long as
the busiest worker computes, and as the sender and the scheduler compute beside it, which here are one process. The
sum of these CPU times is the critical path: the wall time on a machine of one's own, if sender and workers never worked
at the same time. Two workers are compared with one by it.
"""

import json
import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from tests.benchmarks import scene
from tests.benchmarks.measure import Result
from voa_meshes import write_stl
from voa_service.cluster.connecting import Cluster, cluster_at
from voa_service.cluster.mapping import ClusterMap
from voa_service.cluster.scene import Scene
from voa_service.local.document import Document, read_document
from voa_service.local.ranking import Parts, local_services, ranked
from voa_service.mapping.rankings import ParallelMap
from voa_service.services import Services
from voa_service.settings import Settings
from voa_service.versions import versions

_POSES, _PLACES, _GRASPS = 2_100, 96, 20  # so many poses are weighed row by row, as 20 000 are
_ROUNDS = 3
_FIRST_PLACES = 16  # of a ranking by which the workers load their kernels
_TASKS = 400
_NUMBERS = 8_000_000
_HUGE_POSES, _HUGE_PLACES = 20_000, 1_000
_SCENE_BYTES = 10e6  # of 20 000 poses with the scores of 20 grasps, and a mesh of 100 000 faces
_BYTES_OF_OUTCOME = 5 * 8  # of each pose in the result of a place


def run() -> list[Result]:
    """Compare two workers with one, and measure what tasks and bytes cost."""
    with (
        tempfile.TemporaryDirectory() as folder,
        local_services(Settings(workers=1, log_level="ERROR")) as built,
        cluster_at("local:1") as one,
        cluster_at("local:2") as two,
    ):
        content = _content(Path(folder))
        paths: dict[str, list[float]] = {"one": [], "two": []}
        for cluster in (one, two):
            _critical_path(built, _document(content, f"first {cluster.on_this_machine}", _FIRST_PLACES), cluster)
        for turn in range(_ROUNDS):
            for name, cluster in (("one", one), ("two", two)):
                paths[name].append(_critical_path(built, _document(content, f"{name} {turn}", _PLACES), cluster))
        slower, faster = (median(paths[name]) for name in ("one", "two"))
        costs = Costs(slower / _PLACES, _task_seconds(two), _byte_seconds(two))
    size = f"{_HUGE_POSES} poses x {_HUGE_PLACES} places"
    return [
        Result("cluster, two workers / one, critical path", slower / faster, faster, slower, "s"),
        Result("cluster, a task, at the sender and the scheduler", None, 1e3 * costs.task_s, None, "ms"),
        Result("cluster, a megabyte, at the sender", None, 1e9 * costs.byte_s, None, "ms"),
        *(
            Result(f"cluster, {size}, {workers} workers, on paper", None, costs.on_paper(workers), None, "s")
            for workers in (1, 10, 100, 1_000)
        ),
    ]


@dataclass(frozen=True)
class Costs:
    """Costs of an exact ranking on a cluster, CPU seconds.

    Attributes:
        place_s: of a place of this benchmark, on a worker.
        task_s: of a task, at the sender and the scheduler.
        byte_s: of a byte that is sent or received, at the sender.
    """

    place_s: float
    task_s: float
    byte_s: float

    def on_paper(self, workers: int) -> float:
        """Seconds for an exact ranking of 20 000 poses x 1 000 places on so many processors like this one.

        Workers compute at the same time: a place costs as the square of the number of poses, and whole places are
        shared out. The sender writes a task for each place, sends the scene once, and reads every result, after the
        workers have ended. The scene goes from worker to worker, in as many steps as their number has binary digits.
        """
        of_place = self.place_s * (_HUGE_POSES / _POSES) ** 2
        received = _HUGE_PLACES * _HUGE_POSES * _BYTES_OF_OUTCOME
        moved = workers.bit_length() * _SCENE_BYTES + received
        return math.ceil(_HUGE_PLACES / workers) * of_place + _HUGE_PLACES * self.task_s + moved * self.byte_s


def _critical_path(built: Services, document: Document, cluster: Cluster) -> float:
    """CPU seconds of the sender and of the busiest worker, for one ranking of a scenario that has been read."""
    began = 0.0

    def spread(_: ParallelMap, parts: Parts) -> ParallelMap:
        nonlocal began
        began = time.process_time()  # what comes before is done once for a command, on however many workers
        own = Scene(parts.scenario, parts.object, 2**28, versions())
        return ClusterMap(cluster.client, own, parts.model, parts.check)

    def cpu() -> dict[str, float]:
        seconds: dict[str, float] = cluster.client.run(time.process_time)
        return seconds

    before = cpu()
    ranked(built, document, spread, lambda: None)
    mine, after = time.process_time() - began, cpu()
    return mine + max(after[worker] - before[worker] for worker in after)


def _task_seconds(cluster: Cluster) -> float:
    """CPU seconds of sender and scheduler for a task that computes nothing."""
    cluster.client.gather(cluster.client.map(abs, range(10), pure=False))
    start = time.process_time()
    cluster.client.gather(cluster.client.map(abs, range(_TASKS), pure=False))
    return (time.process_time() - start) / _TASKS


def _byte_seconds(cluster: Cluster) -> float:
    """CPU seconds of the sender for a byte, sent or received, whichever costs more; the cheapest of three each."""
    content = np.ones(_NUMBERS)

    def cpu(call: Callable[[], object]) -> float:
        start = time.process_time()
        call()
        return time.process_time() - start

    sent = min(cpu(lambda: cluster.client.submit(len, content, pure=False).result()) for _ in range(3))
    received = min(cpu(lambda: cluster.client.submit(np.ones, _NUMBERS, pure=False).result()) for _ in range(3))
    return max(sent, received) / content.nbytes


def _content(folder: Path) -> dict[str, Any]:
    """Write the cup into a folder, and make the scenario of a document."""
    object_ = scene.cup("1k")
    path = folder / "cup.stl"
    path.write_bytes(write_stl(object_.vertices, object_.faces.astype(np.int64)))
    poses = scene.poses(object_, _POSES, planar=True)
    assert poses.positions is not None
    assert poses.quaternions_wxyz is not None
    positions, quaternions = poses.positions.tolist(), poses.quaternions_wxyz.tolist()
    scores = np.random.default_rng(3).uniform(size=(_GRASPS, _POSES))
    return {
        "scenario": {
            "name": "cluster",
            "poses": [
                {"name": name, "position": position, "quaternion_wxyz": quaternion}
                for name, position, quaternion in zip(poses.names, positions, quaternions, strict=True)
            ],
            "grasps": [{"name": f"G{index}"} for index in range(_GRASPS)],
            "scores": {"probabilities": scores.tolist()},
            "sensors": [
                {"name": sensor.name, "x": sensor.x, "y": sensor.y, "yaw_rad": sensor.yaw_rad}
                for sensor in scene.sensors(_PLACES)
            ],
            "lidar": {"preset": "lds-01", "height_m": 0.02},
            "update": {"rule": "exponential", "no_return_m": 1.0},
        },
        "mesh": {"path": str(path)},
    }


def _document(content: dict[str, Any], seed: str, places: int) -> Document:
    """Make a document about some places with a belief of its own, so that no earlier answer serves it."""
    belief = np.random.default_rng(list(seed.encode())).dirichlet(np.ones(_POSES))
    sensors = [sensor["name"] for sensor in content["scenario"]["sensors"][:places]]
    ranking = {"belief": (belief / belief.sum()).tolist(), "sensors": sensors, "lookahead": 1, "method": "exact"}
    return read_document(json.dumps(content | {"ranking": ranking}).encode())
