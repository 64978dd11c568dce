"""Settings of the service: from the command line, else from `VOA_*` in the environment, else these defaults."""

import ipaddress
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from limits import parse
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

from voa_connections.settings import MEBIBYTE, ConnectionSettings
from voa_msgs.keys import ROOT, check_root

MOST_FLOAT64_WEIGHTS = 240_000_000
"""Product of sensor configurations and squared poses up to which rankings use float64: weights of 1.9 GB."""
PrecisionSetting = Literal["auto", "float64", "float32"]


class Limits(BaseModel):
    """Limits on the size of requests: `VOA_LIMITS__POSES=50000` and so on."""

    model_config = ConfigDict(frozen=True)

    beams: PositiveInt = 4_096
    poses: PositiveInt = 20_000
    sensors: PositiveInt = 4_096
    grasps: PositiveInt = 4_096
    faces: PositiveInt = 200_000
    upload_bytes: PositiveInt = 20_000_000
    body_bytes: PositiveInt = 64_000_000
    scan_bytes: PositiveInt = 1_000_000
    """Bytes of a scan, or of a ROS 2 message, on Zenoh."""
    numbers: PositiveInt = 5_000_000
    """Values in a JSON body of a request or a response; in a request, its commas are counted."""
    parts: PositiveInt = 250_000
    """Texts, lists, objects and escapes in a JSON body, counted by their marks: they take many times their bytes."""
    predicted_scans: PositiveInt = 1_000_000
    """Scans that a ranking predicts: its places times the poses of its scenario."""
    history_bytes: PositiveInt = 8_000_000
    """Bytes of requests, reports and beliefs in a page of a history; a page has at least one version."""


def _endpoint(endpoint: str) -> str:
    """Return a Zenoh endpoint unchanged; raises ValueError unless it has the form PROTOCOL/ADDRESS."""
    protocol, slash, address = endpoint.partition("/")
    if not (protocol.isalnum() or protocol == "unixsock-stream") or not slash or not address:
        raise ValueError("expected PROTOCOL/ADDRESS, as in tcp/192.168.0.2:7447")
    return endpoint


Endpoint = Annotated[str, AfterValidator(_endpoint)]


def _names(given: Any) -> Any:
    """Split a text at its commas into names; return a list unchanged."""
    return [name.strip() for name in given.split(",") if name.strip()] if isinstance(given, str) else given


def _rate(rate: str) -> str:
    """Return a rate unchanged; raises ValueError unless it has the form "200/second" or "300 per 2 minutes"."""
    try:
        parse(rate)
    except ValueError as error:
        raise ValueError(f"expected a number of calls and a time, as in 200/second, got {rate!r}") from error
    return rate


Rate = Annotated[str, AfterValidator(_rate)]


class RateSettings(BaseModel):
    """Calls per key and time, in each process: `VOA_RATES__CALLS=200/second` and so on."""

    model_config = ConfigDict(frozen=True)

    calls: Rate = "200/second"
    """Calls of a key; 40 lidars of 5 Hz that share a key stay within it."""
    heavy: Rate = "600/minute"
    """Rankings, predictions, uploads and other calls of a key that may take long."""
    refused: Rate = "120/minute"
    """Calls without a valid key from an address, or on Zenoh from a robot or from all callers of methods together; from
    all robots together ten times as many."""


class ZenohSettings(BaseModel):
    """Zenoh router and credentials: `VOA_ZENOH__CONNECT='["tcp/192.168.0.2:7447"]'` and so on."""

    model_config = ConfigDict(frozen=True, hide_input_in_errors=True)

    connect: list[Endpoint] = []
    """Endpoints of routers, of which the first that answers is used; empty: no Zenoh."""
    root: Annotated[str, AfterValidator(check_root)] = ROOT
    """Prefix of every key expression; its last chunk names the lab."""
    user: str | None = None
    password: SecretStr | None = None
    config: FilePath | None = None
    """File with a Zenoh configuration (JSON5), for example for TLS; the other settings are added to it."""
    grace_seconds: PositiveFloat = 2.0
    """Time that a replica waits before it handles a sample for which another replica is responsible."""

    @model_validator(mode="after")
    def _password_has_user(self) -> Self:
        if self.password is not None and self.user is None:
            raise ValueError("a password needs a user: expected 'user' too")
        return self


class Settings(BaseSettings):
    """Settings of the service, for its operator."""

    model_config = SettingsConfigDict(
        env_prefix="VOA_", env_nested_delimiter="__", frozen=True, hide_input_in_errors=True
    )

    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    database_url: str = "sqlite:///voa.db"
    database_patience_s: Annotated[float, Field(ge=1.0, le=600.0)] = 4.0
    """Time that PostgreSQL may be silent before a request is answered 503. A locked row is waited for 0.8 of that,
    unless `options` in the URL say otherwise."""
    hosts: Annotated[tuple[str, ...], NoDecode, BeforeValidator(_names)] = ()
    """Host names under which the service may be called; in `VOA_HOSTS` with commas ("voa.lab.example,10.0.0.7").

    A service on loopback answers requests to loopback names and to these names only (others: 421), so that no web page
    whose host name is made to point to 127.0.0.1 can use it. A service on another address answers to any name unless
    this is set.
    """
    require_keys: bool = False
    """True refuses every call but those about health without a valid key, even before the first key is made."""
    insecure: bool = False
    """True allows addresses other than loopback without keys, where anyone can change beliefs."""
    console: bool = False
    """True runs the console beside the service, which then redirects `/` to it; started by the command `voa serve`."""
    console_port: int = Field(default=8080, ge=0, le=65535)
    tls_cert: Path | None = None
    """PEM file with the certificate of the service, for HTTPS without a proxy; needs `tls_key`."""
    tls_key: Path | None = None
    """PEM file with the private key of that certificate, not encrypted."""
    limits: Limits = Limits()
    rates: RateSettings = RateSettings()
    connections: ConnectionSettings = ConnectionSettings()
    zenoh: ZenohSettings = ZenohSettings()
    robots: Path | None = None
    """File that maps the ROS 2 topics of robots to sessions (TOML, see `voa_ros.robots`); needs Zenoh."""
    memory_mebibytes: PositiveInt | None = None
    """Memory for the service as a whole; None: the limit of the cgroup, else the machine's (see `runtime.memory`)."""
    cache_mebibytes: PositiveInt | None = None
    """Memory for cuts, predictions and weights; None: 2 048, or less where the service's memory is small."""
    workers: PositiveInt | None = None
    """Threads for rankings and predictions; None: one per processor, or fewer where the service's memory is small."""
    precision: PrecisionSetting = "auto"
    """Precision of the weights in rankings; "auto": float64 up to `MOST_FLOAT64_WEIGHTS`, float32 beyond."""
    queue: PositiveInt = 16
    """Rankings and other heavy requests that may wait for a worker; one more is answered 503."""
    readers: PositiveInt = 2
    """Large bodies (above 64 kB) that are parsed and validated at a time."""
    reader_queue: PositiveInt = 8
    """Large bodies that may wait to be parsed; one more is answered 503."""
    scan_queue: PositiveInt = 256
    """Writes that may wait for a worker, and as many reads in another queue; one more is answered 503."""
    followers: PositiveInt = 1_000
    """Event streams at a time; one more is answered 503."""
    mesh_seconds: PositiveInt = 30
    """Most time to read a mesh file."""
    mesh_mebibytes: PositiveInt | None = None
    """Address space to read a mesh file; None: 2 048, or less (at least 320) where the service's memory is small."""
    retention_days: PositiveFloat | None = None
    """Age of a session's newest version, in days, from which the session is removed; None: sessions stay."""
    response_days: PositiveFloat = 7.0
    """Age of a response stored under an idempotency key, in days, from which it is removed; a client may repeat a call
    until then."""
    log_level: str = "INFO"
    wait_for_database: NonNegativeFloat = 0.0
    """Time for which the start is tried again while the database cannot be reached."""
    stop_seconds: PositiveFloat = 9.0
    """Time from the signal to stop to the end of the process; requests have half of what `drain_seconds` leaves."""
    drain_seconds: NonNegativeFloat = 0.0
    """First part of `stop_seconds`, after SIGTERM: /readyz answers 503, and everything else is served as before, so
    that balancers learn to send requests to other replicas before this one refuses connections."""

    @model_validator(mode="after")
    def _bodies_fit(self) -> Self:
        largest = max(self.limits.body_bytes, self.limits.upload_bytes)
        if self.connections.in_flight_mebibytes * MEBIBYTE < largest:
            raise ValueError(
                f"a body of {largest} bytes, which the limits allow, would always be refused: "
                f"expected connections.in_flight_mebibytes of at least {-(-largest // MEBIBYTE)}"
            )
        return self

    @model_validator(mode="after")
    def _certificate_is_whole(self) -> Self:
        if (self.tls_cert is None) != (self.tls_key is None):
            raise ValueError("TLS needs a certificate and its private key: expected 'tls_cert' and 'tls_key'")
        return self

    @model_validator(mode="after")
    def _stop_is_longer_than_drain(self) -> Self:
        if self.drain_seconds >= self.stop_seconds:
            raise ValueError(
                f"a process that drains for {self.drain_seconds:g} s must have longer to stop: "
                f"expected stop_seconds above that, got {self.stop_seconds:g}"
            )
        return self

    @property
    def names(self) -> frozenset[str] | None:
        """Host names under which the service may be called, besides those of loopback; None: any."""
        if not self.hosts and not self.is_loopback:
            return None
        return frozenset(name.lower().rstrip(".") for name in self.hosts)

    @property
    def is_loopback(self) -> bool:
        """True if only this machine can reach the service."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
