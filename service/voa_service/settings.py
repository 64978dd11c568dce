"""Settings: from the command line, else from `VOA_*` in the environment, else these defaults."""

import ipaddress
import os
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    FilePath,
    PositiveFloat,
    PositiveInt,
    SecretStr,
    model_validator,
)
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from voa_msgs.keys import ROOT, check_root

MEBIBYTE = 2**20


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
    hosts: Annotated[tuple[str, ...], NoDecode, BeforeValidator(_names)] = ()
    """Names under which the service may be called, with commas between in `VOA_HOSTS` ("voa.lab.example,10.0.0.7").

    A service on loopback answers calls to loopback names and to these alone, so that no page whose name is re-pointed
    to 127.0.0.1 can use it (421). One that listens elsewhere answers to any name, unless this is set.
    """
    insecure: bool = False
    """Serve other addresses than loopback although anyone who reaches them may do anything."""
    limits: Limits = Limits()
    zenoh: ZenohSettings = ZenohSettings()
    robots: Path | None = None
    """Which ROS 2 robots' scans are for which sessions (TOML, see `voa_ros.robots`); needs Zenoh."""
    cache_mebibytes: PositiveInt = 2_048
    """Memory for cuts, predictions and weights. Rankings are float64 while their weights fit into it."""
    workers: PositiveInt = os.cpu_count() or 1
    """Threads for rankings, predictions and meshes."""
    queue: PositiveInt = 16
    """Heavy requests that may wait for a worker; one more is answered 503."""
    readers: PositiveInt = 2
    """Large bodies (above 64 kB) that are parsed and validated at a time."""
    reader_queue: PositiveInt = 8
    """Large bodies that may wait for that; one more is answered 503."""
    scan_queue: PositiveInt = 256
    """Scans and reads that may wait."""
    mesh_seconds: PositiveInt = 30
    """Time to read one mesh."""
    mesh_mebibytes: PositiveInt = 2_048
    """Address space to read one mesh."""
    log_level: str = "INFO"

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
