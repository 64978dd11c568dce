"""Runs tasks one at a time in virtual time: each pauses at every step, and a seeded generator decides who goes on.

A task is a greenlet, so that production code that blocks (the store, its pools) runs unmodified in one thread. Nothing
here reads a clock or creates a thread: the steps of a run depend on its seed alone.
"""

import heapq
import random
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from greenlet import getcurrent, greenlet

_STEP_SECONDS = 0.002
"""Longest ordinary duration of a step."""
_STALL_SECONDS = 4.0
"""Longest duration of a step that stalls, as where the machine swaps."""


class Killed(BaseException):
    """The process of a task has died: thrown into the task at the step where it paused."""


class Endless(Exception):
    """A run took more steps than any run should."""


@dataclass(eq=False)
class Owner:
    """A process: the tasks in it die together.

    Attributes:
        name: for the trace.
        steps: number of steps that its tasks have taken.
        crash_at: number of the step at which it dies; None: it lives on.
        on_crash: called by the scheduler when it dies.
    """

    name: str
    steps: int = 0
    crash_at: int | None = None
    on_crash: Callable[[], None] = lambda: None


@dataclass(eq=False)
class Task:
    """A thread of control; `random` is its own, so that other tasks do not change what it draws."""

    name: str
    owner: Owner | None
    random: random.Random
    greenlet: Any = None
    ticket: int = 0
    dead: bool = False


@dataclass(eq=False)
class Signal:
    """Condition that tasks wait for."""

    waiting: list[Task] = field(default_factory=list)


class Scheduler:
    """Virtual time, the tasks, and the trace of their steps.

    Args:
        seed: of all random choices.
        most_steps: of one run.
    """

    def __init__(self, seed: int, most_steps: int = 1_000_000) -> None:
        self.now = 0.0
        self.stalls = 0.0
        """Probability that a step stalls."""
        self.trace: list[tuple[float, str, str]] = []
        self.errors: list[tuple[Task, BaseException]] = []
        self.current: Task | None = None
        self._seed = seed
        self._left = most_steps
        self._heap: list[tuple[float, int, Task | Callable[[], None], int]] = []
        self._count = 0
        self._stopped = False
        self._tasks: dict[Task, None] = {}
        self._hub = getcurrent()

    def generator(self, name: str) -> random.Random:
        """Return the random generator of a name; those of other names never change what it draws."""
        return random.Random((self._seed << 32) + zlib.crc32(name.encode()))  # noqa: S311 - repeatable on purpose

    def spawn(self, name: str, work: Callable[[], None], owner: Owner | None = None, delay: float = 0.0) -> Task:
        """Start a task after a delay."""
        task = Task(name, owner, self.generator(name))

        def run() -> None:
            try:
                work()
            except Killed:
                pass
            except Exception as error:
                self.errors.append((task, error))
            self._tasks.pop(task, None)

        task.greenlet = greenlet(run, self._hub)
        self._tasks[task] = None
        self._push(self.now + delay, task, task.ticket)
        return task

    def at(self, delay: float, act: Callable[[], None]) -> None:
        """Call `act`, which must not pause, after a delay."""
        self._push(self.now + delay, act, 0)

    def note(self, label: str, name: str | None = None) -> None:
        """Add a line to the trace."""
        if name is None:
            name = "-" if self.current is None else self.current.name
        self.trace.append((self.now, name, label))

    def step(self, label: str) -> None:
        """Let other tasks go on before what `label` says happens; returns at once outside of any task.

        Raises:
            Killed: the task's process has died meanwhile.
        """
        task = self.current
        if task is None or task.dead:
            return
        self._left -= 1
        if self._left <= 0:
            raise Endless("the run took more steps than any run should: some task goes on for ever")
        self.trace.append((self.now, task.name, label))
        owner = task.owner
        if owner is not None:
            owner.steps += 1
            if owner.steps == owner.crash_at:
                self.at(0.0, owner.on_crash)
        draw = task.random.random()
        stalled = draw < self.stalls
        self.pause(task.random.random() * _STALL_SECONDS if stalled else draw * _STEP_SECONDS)

    def pause(self, seconds: float) -> None:
        """Pause the present task; raises Killed if its process has died meanwhile."""
        task = self._task()
        self._push(self.now + seconds, task, task.ticket)
        self._switch(task)

    def wait(self, signal: Signal, seconds: float) -> None:
        """Pause the present task until a signal, at most so many seconds; raises Killed."""
        task = self._task()
        signal.waiting.append(task)
        self._push(self.now + seconds, task, task.ticket)
        self._switch(task)

    def notify(self, signal: Signal) -> None:
        """Wake all tasks that wait for a signal, in a random order."""
        woken, signal.waiting = signal.waiting, []
        for task in woken:
            if not task.dead:
                self._push(self.now + task.random.random() * _STEP_SECONDS, task, task.ticket)

    def kill(self, owner: Owner) -> None:
        """End all tasks of a process at the step where each paused; called by the scheduler, not by a task."""
        self._end([each for each in self._tasks if each.owner is owner])

    def _end(self, tasks: list[Task]) -> None:
        for task in tasks:
            task.dead = True
            self.current = task
            task.greenlet.throw(Killed)
            self._tasks.pop(task, None)
        self.current = None

    def run(self) -> None:
        """Run until a task calls `stop`; every task that is left then is ended where it paused."""
        while self._heap and not self._stopped:
            self.now, _, due, ticket = heapq.heappop(self._heap)
            if isinstance(due, Task):
                if due.dead or due.ticket != ticket:
                    continue
                self.current = due
                due.ticket += 1
                due.greenlet.switch()
            else:
                due()
            self.current = None
        self._end(list(self._tasks))

    def stop(self) -> None:
        """End the run after the present step."""
        self._stopped = True

    def _task(self) -> Task:
        if self.current is None:
            raise RuntimeError("only a task can wait")
        return self.current

    def _switch(self, task: Task) -> None:
        if task.dead:
            raise Killed
        self._hub.switch()

    def _push(self, time: float, due: Task | Callable[[], None], ticket: int) -> None:
        self._count += 1
        heapq.heappush(self._heap, (time, self._count, due, ticket))
