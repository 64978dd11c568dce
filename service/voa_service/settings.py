"""Settings: from the command line, else from `VOA_*` in the environment, else these defaults."""

import ipaddress
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    FilePath,
    NonNegativeFloat,
    PositiveFloat,
    PositiveInt,
    SecretStr,
    model_validator,
)
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from voa_msgs.keys import ROOT, check_root

MEBIBYTE = 2**20
MOST_FLOAT64_WEIGHTS = 240_000_000
"""Sensor configurations x poses^2 up to which rankings are float64 by default: weights of 1.9 GB."""
PrecisionSetting = Literal["auto", "float64", "float32"]


class Limits(BaseModel):
    """How large a request may be: `VOA_LIMITS__POSES=50000` and so on."""

    model_config = ConfigDict(frozen=True)

    beams: PositiveInt = 4_096
    poses: PositiveInt = 20_000
    sensors: PositiveInt = 4_096
    grasps: PositiveInt = 4_096
    faces: PositiveInt = 200_000
    upload_bytes: PositiveInt = 20_000_000
    body_bytes: PositiveInt = 64_000_000
    scan_bytes: PositiveInt = 1_000_000
    """Of a scan that is put on Zenoh."""
    numbers: PositiveInt = 5_000_000
    """Values in one JSON body, either way (counted by their separators on the way in)."""
    parts: PositiveInt = 250_000
    """Texts, lists, objects and escapes in one JSON body (counted by their marks): they cost many times their bytes."""
    history_bytes: PositiveInt = 8_000_000
    """Of requests, reports and beliefs behind one page of a history; a page has at least one version."""


class ConnectionSettings(BaseModel):
    """Bounds for what is no request yet, and for answers not read: `VOA_CONNECTIONS__MOST=300` and so on."""

    model_config = ConfigDict(frozen=True)

    most: PositiveInt = 1_000
    """Connections at once; fewer where the process may open fewer files (RLIMIT_NOFILE less 256)."""
    header_bytes: PositiveInt = 65_536
    """Of a request line and its headers together; more is answered 431."""
    headers: PositiveInt = 100
    """Of a request; more are answered 431."""
    header_seconds: PositiveFloat = 10.0
    """From the first byte of a request to the end of its headers; later is answered 408."""
    progress_seconds: PositiveFloat = 20.0
    """Time in which `progress_bytes` more of a body must come (else 408), or of an answer be read (else it ends)."""
    progress_bytes: PositiveInt = 16_384
    """See `progress_seconds`; the last bytes of a body or an answer may be fewer."""
    in_flight_mebibytes: PositiveInt = 128
    """Of request bodies that the process holds at once beyond the first 64 kB of each (more is answered 503), and as
    many of answers that wait for their readers."""


def _endpoint(endpoint: str) -> str:
    """The endpoint itself; raises ValueError unless it looks like one."""
    protocol, slash, address = endpoint.partition("/")
    if not (protocol.isalnum() or protocol == "unixsock-stream") or not slash or not address:
        raise ValueError("expected PROTOCOL/ADDRESS, as in tcp/192.168.0.2:7447")
    return endpoint


Endpoint = Annotated[str, AfterValidator(_endpoint)]


def _names(given: Any) -> Any:
    """Split names with commas between; leave lists alone."""
    return [name.strip() for name in given.split(",") if name.strip()] if isinstance(given, str) else given


class ZenohSettings(BaseModel):
    """Which router to join, and as whom: `VOA_ZENOH__CONNECT='["tcp/192.168.0.2:7447"]'` and so on."""

    model_config = ConfigDict(frozen=True, hide_input_in_errors=True)

    connect: list[Endpoint] = []
    """Endpoints of routers, the first that answers is taken; none: no Zenoh."""
    root: Annotated[str, AfterValidator(check_root)] = ROOT
    """Of every key; its last chunk is the lab."""
    user: str | None = None
    password: SecretStr | None = None
    config: FilePath | None = None
    """A Zenoh configuration (JSON5) to begin with, for TLS and the like."""
    grace_seconds: PositiveFloat = 2.0
    """How long a replica waits before it works on a sample that another one should have worked on."""

    @model_validator(mode="after")
    def _somebody(self) -> Self:
        if self.password is not None and self.user is None:
            raise ValueError("a password is for a user: expected 'user' too")
        return self


class Settings(BaseSettings):
    """What an operator decides."""

    model_config = SettingsConfigDict(
        env_prefix="VOA_", env_nested_delimiter="__", frozen=True, hide_input_in_errors=True
    )

    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    database_url: str = "sqlite:///voa.db"
    database_patience_s: Annotated[float, Field(ge=1.0, le=600.0)] = 4.0
    """How long PostgreSQL may be silent before a call is answered 503. A row that somebody holds is waited for 0.8 of
    that, unless `options` in the URL say otherwise."""
    hosts: Annotated[tuple[str, ...], NoDecode, BeforeValidator(_names)] = ()
    """Names under which the service may be called, with commas between in `VOA_HOSTS` ("voa.lab.example,10.0.0.7").

    A service on loopback answers calls to loopback names and to these alone, so that no page whose name is re-pointed
    to 127.0.0.1 can use it (421). One that listens elsewhere answers to any name, unless this is set.
    """
    insecure: bool = False
    """Serve other addresses than loopback although anyone who reaches them may do anything."""
    limits: Limits = Limits()
    connections: ConnectionSettings = ConnectionSettings()
    zenoh: ZenohSettings = ZenohSettings()
    robots: Path | None = None
    """Which ROS 2 robots' scans are for which sessions (TOML, see `voa_ros.robots`); needs Zenoh."""
    memory_mebibytes: PositiveInt | None = None
    """Memory for this service as a whole; None: what the cgroup, else the machine has (see `memory.budget`)."""
    cache_mebibytes: PositiveInt | None = None
    """Memory for cuts, predictions and weights; None: 2 048, or less where the service's memory is small."""
    workers: PositiveInt | None = None
    """Threads for rankings and predictions; None: one per processor, or fewer where the service's memory is small."""
    precision: PrecisionSetting = "auto"
    """Of the weights that rankings use. "auto": float64 up to `MOST_FLOAT64_WEIGHTS`, beyond float32."""
    queue: PositiveInt = 16
    """Heavy requests that may wait for a worker; one more is answered 503."""
    readers: PositiveInt = 2
    """Large bodies (above 64 kB) that are parsed and validated at a time."""
    reader_queue: PositiveInt = 8
    """Large bodies that may wait for that; one more is answered 503."""
    scan_queue: PositiveInt = 256
    """Writes that may wait for a worker, and as many reads, in a line of their own."""
    followers: PositiveInt = 1_000
    """Event streams at a time; one more is answered 503."""
    mesh_seconds: PositiveInt = 30
    """Time to read one mesh."""
    mesh_mebibytes: PositiveInt | None = None
    """Address space to read one mesh; None: 2 048, or less (at least 320) where the service's memory is small."""
    log_level: str = "INFO"
    wait_for_database: NonNegativeFloat = 0.0
    """Seconds to try again at the start while the database cannot be reached."""
    stop_seconds: PositiveFloat = 9.0
    """From the signal to stop to the end of the process, whatever is under way; requests have half of it to end."""

    @model_validator(mode="after")
    def _bodies_fit(self) -> Self:
        largest = max(self.limits.body_bytes, self.limits.upload_bytes)
        if self.connections.in_flight_mebibytes * MEBIBYTE < largest:
            raise ValueError(
                f"a body of {largest} bytes, which the limits allow, would always be refused: "
                f"expected connections.in_flight_mebibytes of at least {-(-largest // MEBIBYTE)}"
            )
        return self

    @property
    def names(self) -> frozenset[str] | None:
        """Names under which the service may be called, besides loopback's; None: any."""
        if not self.hosts and not self.is_loopback:
            return None
        return frozenset(name.lower().rstrip(".") for name in self.hosts)

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can reach the service."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
