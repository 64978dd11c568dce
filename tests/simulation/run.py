"""Runs the plan of a seed, and returns what was wrong."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from structlog.testing import capture_logs

from tests.simulation.checks import problems_of
from tests.simulation.clients import Client
from tests.simulation.database import simulated
from tests.simulation.plan import CLIENTS, ROBOT, SLOTS, Plan, Weather
from tests.simulation.replica import START, use_cases
from tests.simulation.scheduler import Endless, Scheduler
from tests.simulation.world import World, folder_in_memory
from tests.support.serving import data_scenario
from voa_msgs.scenarios import ScenarioRequest
from voa_service.mapping.models import Model
from voa_service.runtime.changes import Changes
from voa_service.usecases.robots import Robots
from voa_store.sql import SqlStore

_GRACE_SECONDS = 45.0
"""Virtual time between the last operation and the end, in which late messages arrive."""
_DONE = "all clients are done"
_CREATION = 1_000_000
"""Number of the first session's creation, above those of all operations."""


@dataclass
class Result:
    """Outcome of a run.

    Attributes:
        plan: that was run.
        problems: what was wrong; empty where nothing was.
        trace: steps, as time, task and label.
        writes: that processes have worked on.
        versions: that are in the histories at the end.
    """

    plan: Plan
    problems: list[str]
    trace: list[tuple[float, str, str]] = field(repr=False)
    writes: int = 0
    versions: int = 0

    def lines(self) -> list[str]:
        """Return the trace as text."""
        return [f"{time:12.6f} {name:32} {label}" for time, name, label in self.trace]

    def last_lines(self, count: int) -> list[str]:
        """Return the last lines of the trace before the clients were done, without the work of retention."""
        lines = self.lines()
        ends = [index for index, step in enumerate(self.trace) if step[2] == _DONE]
        return [line for line in lines[: ends[0] if ends else None] if "/main" not in line][-count:]


def _scenario() -> dict[str, Any]:
    """Return the scenario of `data_scenario` with a third sensor, Q3, from which no scan is ever taken."""
    sensor = {"name": "Q3", "x": 0.0, "y": 0.0, "yaw_rad": 0.0}
    plain = data_scenario()
    return plain | {
        "sensors": [*plain["sensors"], sensor],
        "predictions": plain["predictions"] | {"Q3": plain["predictions"]["Q2"]},
    }


@contextmanager
def template() -> Iterator[tuple[Path, dict[str, Model]]]:
    """Make a database with one scenario, which every run copies."""
    with folder_in_memory() as folder:
        path = Path(folder) / "voa.db"
        store = SqlStore(f"sqlite:///{path}", seconds=lambda: 0.0)
        inside = use_cases(store, lambda: START, str, Changes(), Robots(lambda: START, store.robot_session))
        id_ = inside.scenarios.create(ScenarioRequest.model_validate(_scenario()))[0].id
        model = inside.models.get(id_)
        store.close()
        if model is None:
            raise RuntimeError("the scenario that was just stored is not there")
        yield path, {id_: model}


class Simulator:
    """Runs plans, each on a copy of one database.

    Args:
        database: file with the scenario.
        model: of the scenario, by its id.
    """

    def __init__(self, database: Path, model: dict[str, Model]) -> None:
        self._database = database
        self._model = model

    def run(self, plan: Plan) -> Result:
        """Run a plan to its end, and check all that was seen."""
        scheduler = Scheduler(plan.seed)
        with folder_in_memory() as name, capture_logs(), simulated_world(plan, scheduler, Path(name), self) as world:
            try:
                scheduler.run()
            except Endless as error:
                world.records.refusals.append(str(error))
            for replica in world.replicas:
                replica.close()
            problems, versions = problems_of(world)
        return Result(plan, problems, scheduler.trace, world.records.writes, versions)

    def copy_to(self, folder: Path) -> dict[str, Model]:
        """Copy the database into a folder; returns the model of its scenario."""
        shutil.copyfile(self._database, folder / "voa.db")
        return self._model


@contextmanager
def simulated_world(plan: Plan, scheduler: Scheduler, folder: Path, simulator: Simulator) -> Iterator[World]:
    """Make the world of a plan, with all that will happen in it."""
    world = World(plan, scheduler, folder, simulator.copy_to(folder))
    with simulated(scheduler, world.disk):
        for replica in world.replicas:
            replica.start()
        scheduler.spawn("setup", lambda: _begin(world))
        yield world


def _begin(world: World) -> None:
    """Open the sessions while the sky is clear, then let the clients begin, and the plan's troubles."""
    scheduler, plan = world.scheduler, world.plan
    clients = [Client(number, world) for number in range(CLIENTS)]
    world.busy = len(clients)
    scheduler.pause(1.0)
    scheduler.spawn("robot", clients[ROBOT].run)  # its first looks come while the sessions are opened
    for slot in range(SLOTS):
        Client(-1, world).create(_CREATION + slot, slot)
    world.weather = plan.weather
    world.disk.errors = plan.weather.failed
    scheduler.stalls = plan.weather.stalled
    for index, after in plan.crashes:
        world.replicas[index].crashes.append(after)
    for replica in world.replicas:
        replica.plan_crash()
    for delay, index, seconds in plan.jumps:
        scheduler.at(delay, partial(_jump, world, index, seconds))
    for number, client in enumerate(clients):
        if number != ROBOT:
            scheduler.spawn(f"client{number}", client.run)
    while world.busy:
        scheduler.pause(1.0)
    scheduler.note(_DONE)
    world.weather, world.disk.errors, scheduler.stalls = Weather(), 0.0, 0.0
    scheduler.pause(_GRACE_SECONDS)
    scheduler.stop()


def _jump(world: World, index: int, seconds: float) -> None:
    replica = world.replicas[index]
    world.scheduler.note(f"its clock jumps by {seconds:.3f} s", replica.name)
    replica.skew += seconds
