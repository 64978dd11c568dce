"""How the service is."""

from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Literal

from voa_msgs import WIRE_VERSION
from voa_msgs.problems import Health, Memory
from voa_service.failures import NOT_READY, Failure
from voa_service.ports import Clock, Store

Joined = Literal["off", "connecting", "connected"]


@dataclass
class Link:
    """Whether this process is joined to Zenoh; whoever joins it says so here."""

    state: Joined = "off"


@dataclass(frozen=True)
class HealthCheck:
    """For whoever restarts processes, routes requests, or looks for what is wrong."""

    store: Store
    now: Clock
    replica: str
    """The name of this process."""
    memory: Memory | None = None
    """What its parts may hold."""
    link: Link = field(default_factory=Link)

    def ready(self) -> Health:
        """The service can work. It can without a router, so `zenoh` only tells.

        Raises:
            Failure: the store does not answer.
        """
        try:
            self.store.ping()
        except Failure:
            raise
        except Exception as error:
            raise Failure(NOT_READY, f"the store does not answer: {type(error).__name__}") from error
        return Health(
            status="ready",
            version=version("voa"),
            wire_version=WIRE_VERSION,
            replica=self.replica,
            zenoh=self.link.state,
            now=self.now(),
            memory=self.memory,
        )
