"""The service as a customer sees it: scenarios stored, beliefs updated and looks ranked, over HTTP alone."""

import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, TypeVar

from tests.acceptance.casting import Floats
from tests.acceptance.worlds import EXACT, SPREAD_M, SPREAD_RAD, Place, World, stated
from voa_client import (
    Client,
    PoseUncertainty,
    Ranking,
    RankingRequest,
    Scan,
    ScanRequest,
    ScenarioRequest,
    UncertainSensorPose,
    UpdatedEstimate,
    UpdateRequest,
)
from voa_client.local import local_service

A = TypeVar("A")
B = TypeVar("B")

THREADS = 3
_MARGIN_M = 0.05


class Service:
    """A running service, called by a few clients at once.

    Attributes:
        url: of the service.
        calls: number of updates that were requested.
    """

    def __init__(self, url: str, clients: ExitStack, pool: ThreadPoolExecutor) -> None:
        self.url = url
        self.calls = 0
        self._clients, self._pool = clients, pool
        self._own = threading.local()
        self._lock = threading.Lock()

    @property
    def client(self) -> Client:
        """Client of the calling thread."""
        if not hasattr(self._own, "client"):
            with self._lock:
                self._own.client = self._clients.enter_context(Client(self.url, timeout_s=300.0, attempt_s=120.0))
        client: Client = self._own.client
        return client

    def each(self, work: Callable[[A], B], items: Iterable[A]) -> list[B]:
        """Do work on each item on a few threads; results come in the order of the items."""
        return list(self._pool.map(work, items))

    def scenario_of(self, world: World, **fields: Any) -> str:
        """Store a world's mesh and scenario, with the spread of the table and every other field at its default.

        Args:
            world: what is stored.
            fields: of the scenario, which add to or replace those of the world.
        """
        with tempfile.TemporaryDirectory(prefix="voa-acceptance-") as folder:
            file = Path(folder) / f"{world.name}.stl"
            world.mesh.export(file)
            stored = self.client.create_object(file)
        return self.client.create_scenario(ScenarioRequest.model_validate(body_of(world, stored.id) | fields)).id

    def update(
        self, scenario: str, place: Place, scan: Scan, belief: Floats, std: PoseUncertainty = EXACT
    ) -> UpdatedEstimate:
        """Update a stated belief by a scan; nothing is stored."""
        with self._lock:
            self.calls += 1
        where = at_place(place, std)
        return self.client.update_once(
            UpdateRequest(scenario=scenario, belief=[float(p) for p in belief], scan=scan, **where)
        )

    def rank(self, scenario: str, belief: Floats, std: PoseUncertainty = EXACT, **fields: Any) -> Ranking:
        """Rank the looks of a scenario for a stated belief, by a robot with these errors."""
        sensor_std = None if std == EXACT else std
        return self.client.rank_once(
            RankingRequest(scenario=scenario, belief=[float(p) for p in belief], sensor_std=sensor_std, **fields)
        )


def at_place(place: Place, std: PoseUncertainty) -> dict[str, Any]:
    """Fields of a scan's request that say where it was taken: a listed sensor, or the pose of a robot that errs."""
    if std == EXACT:
        return {"sensor": place.name}
    pose = stated(place, std)
    return {"sensor_pose": UncertainSensorPose.model_validate(pose.model_dump())}


def scan_request(place: Place, scan: Scan, std: PoseUncertainty) -> ScanRequest:
    """Request to update a session by a scan."""
    return ScanRequest(scan=scan, **at_place(place, std))


def body_of(world: World, object_id: str) -> dict[str, Any]:
    """Body of a scenario: the world's own numbers, and the spread of the table."""
    xy = [pose.position[:2] for pose in world.poses]
    reach = float((world.mesh.vertices[:, :2] ** 2).sum(axis=1).max() ** 0.5) + _MARGIN_M
    lidar: dict[str, Any] = {"preset": world.lidar.preset}
    if world.lidar.preset is None:
        lidar |= {
            "beams": world.lidar.beams,
            "angle_min": world.lidar.angle_min,
            "angle_increment": world.lidar.angle_increment,
            "range_min": 0.05,
            "range_max": world.lidar.range_max,
            "zero": "missing",
            "noise_m": world.noise.near_m,
            "noise_ratio": world.noise.far_share,
            "dropout": world.noise.lost,
        }
    return {
        "name": world.name,
        "object": object_id,
        "poses": [
            {"name": pose.name, "position": list(pose.position), "quaternion_wxyz": list(pose.quaternion)}
            for pose in world.poses
        ],
        "grasps": [{"name": f"G{index}"} for index in range(len(world.scores))],
        "scores": {"probabilities": world.scores.tolist()},
        "sensors": [
            {
                "name": place.name,
                "x": place.x,
                "y": place.y,
                "yaw_rad": place.yaw_rad,
                "height_m": place.height_m,
                "cost": place.cost,
            }
            for place in world.places
        ],
        "lidar": lidar,
        "workspace": {
            "min": [min(x for x, _ in xy) - reach, min(y for _, y in xy) - reach],
            "max": [max(x for x, _ in xy) + reach, max(y for _, y in xy) + reach],
        },
        "spread": {"xy_m": SPREAD_M, "yaw_rad": round(SPREAD_RAD, 5)},
    }


def grasp_index(name: str | None) -> int:
    """Index of a grasp of the table by its name; -1 for none."""
    return -1 if name is None else int(name.removeprefix("G"))


@contextmanager
def service() -> Iterator[Service]:
    """Run `voa serve` on a free port of 127.0.0.1 with a database in a temporary folder, for the length of a `with`."""
    with (
        local_service() as url,
        ExitStack() as clients,
        ThreadPoolExecutor(THREADS, thread_name_prefix="acceptance") as pool,
    ):
        yield Service(url, clients, pool)
