"""Makes the plan of a seed: the operations of simulated clients, the weather of network and disk, and the crashes."""

import random
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Literal

Kind = Literal["scan", "outcome", "belief", "announce", "cancel", "read", "renew", "look", "claim"]

REPLICAS, SLOTS, CLIENTS = 2, 2, 4
ROBOT = CLIENTS - 1
"""Client whose looks both replicas receive, as those of a mapped robot."""
_WEIGHTS: dict[Kind, int] = {
    "scan": 22,
    "outcome": 22,
    "belief": 26,
    "announce": 8,
    "cancel": 4,
    "read": 16,
}
_RENEWALS = (1, 3, 25)
"""Weights of renewals, of which each plan has one: sessions that live for long, or hardly at all."""
_OF_ROBOT: dict[Kind, int] = {"look": 18, "claim": 1}
_THINKS, _ROBOT_THINKS = 0.15, 0.5
"""Longest pause before an operation of a client, and of the robot, seconds."""
OPERATIONS = 60
"""Number of operations of each client, unless a caller wants another."""


@dataclass(frozen=True)
class Operation:
    """Action of a client.

    Attributes:
        number: in the plan; part of keys and bodies, so that each is unique.
        client: that does it.
        kind: of the call.
        slot: session that it is about.
        keyed: True if it has an idempotency key, and is repeated until it is answered.
        conditional: True if it states the version that the client knows.
        think: pause before it, seconds.
        sensor: name of a sensor configuration.
    """

    number: int
    client: int
    kind: Kind
    slot: int
    keyed: bool
    conditional: bool
    think: float
    sensor: str


@dataclass(frozen=True)
class Weather:
    """Probabilities of trouble: per message lost, repeated or slow; per statement failed; per step stalled."""

    lost: float = 0.0
    repeated: float = 0.0
    slow: float = 0.0
    failed: float = 0.0
    stalled: float = 0.0


@dataclass(frozen=True)
class Plan:
    """All that a run does.

    Attributes:
        seed: of every random choice.
        operations: of all clients.
        weather: of network, disk and processes.
        crashes: a replica, and the number of its step at which it dies.
        jumps: a time in seconds, a replica, and the seconds by which its clock jumps then.
    """

    seed: int
    operations: tuple[Operation, ...]
    weather: Weather
    crashes: tuple[tuple[int, int], ...]
    jumps: tuple[tuple[float, int, float], ...]

    def only(self, numbers: frozenset[int]) -> "Plan":
        """Return the plan with some of its operations; all others happen as before."""
        return replace(self, operations=tuple(each for each in self.operations if each.number in numbers))

    def without(self, troubles: frozenset[str]) -> "Plan":
        """Return the plan without some kinds of trouble, as `troubles` names them."""
        calm = {each.name: 0.0 for each in fields(Weather) if each.name in troubles}
        return replace(
            self,
            weather=replace(self.weather, **calm),
            crashes=() if "crashes" in troubles else self.crashes,
            jumps=() if "jumps" in troubles else self.jumps,
        )

    @property
    def troubles(self) -> list[str]:
        """Kinds of trouble that the plan has."""
        bad = [each.name for each in fields(Weather) if getattr(self.weather, each.name) > 0.0]
        return bad + [name for name in ("crashes", "jumps") if getattr(self, name)]


def plan_of(seed: int, operations: int = OPERATIONS) -> Plan:
    """Make the plan of a seed.

    Args:
        seed: any integer.
        operations: of each client.
    """
    draw = random.Random(seed)  # noqa: S311 - repeatable on purpose
    weights: dict[Kind, int] = {**_WEIGHTS, "renew": draw.choice(_RENEWALS)}
    each = [
        _operation(draw, client + CLIENTS * index, client, _OF_ROBOT if client == ROBOT else weights)
        for client in range(CLIENTS)
        for index in range(operations)
    ]
    steps = 25 * operations * CLIENTS // REPLICAS
    crashes = sorted((draw.randrange(REPLICAS), draw.randrange(20, steps)) for _ in range(draw.choice((0, 1, 2, 4))))
    jumps = [
        (draw.uniform(0.0, 10.0), draw.randrange(REPLICAS), draw.uniform(-200.0, 200.0))
        for _ in range(draw.choice((0, 0, 1, 3)))
    ]
    return Plan(seed, tuple(each), _weather(draw), tuple(crashes), tuple(sorted(jumps)))


def _operation(draw: random.Random, number: int, client: int, weights: Mapping[Kind, int]) -> Operation:
    kind = draw.choices(list(weights), list(weights.values()))[0]
    keyed = kind in ("renew", "look", "claim") or draw.random() < 0.8
    return Operation(
        number=number,
        client=client,
        kind=kind,
        slot=draw.choices(range(SLOTS), (1, 1) if kind == "renew" else (3, 1))[0],
        keyed=keyed,
        conditional=kind in ("scan", "outcome", "belief") and draw.random() < 0.25,
        think=draw.random() * draw.choice((0.0, 0.2, 1.0)) * (_ROBOT_THINKS if client == ROBOT else _THINKS),
        sensor="Q3" if kind == "announce" and draw.random() < 0.8 else draw.choice(("Q1", "Q2")),
    )


def _weather(draw: random.Random) -> Weather:
    def sometimes(most: float) -> float:
        return draw.choice((0.0, 0.3, 1.0)) * most

    return Weather(sometimes(0.1), sometimes(0.2), sometimes(0.1), sometimes(0.01), sometimes(0.004))
