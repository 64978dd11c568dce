"""Settings: from the command line, else from `VOA_*` in the environment, else these defaults."""

import ipaddress
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    FilePath,
    PositiveFloat,
    PositiveInt,
    SecretStr,
    model_validator,
)
from pydantic_settings import BaseSettings, SettingsConfigDict

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


def _endpoint(endpoint: str) -> str:
    """The endpoint itself; raises ValueError unless it looks like one."""
    protocol, slash, address = endpoint.partition("/")
    if not (protocol.isalnum() or protocol == "unixsock-stream") or not slash or not address:
        raise ValueError("expected PROTOCOL/ADDRESS, as in tcp/192.168.0.2:7447")
    return endpoint


Endpoint = Annotated[str, AfterValidator(_endpoint)]


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
    insecure: bool = False
    """Serve other addresses than loopback although anyone who reaches them may do anything."""
    limits: Limits = Limits()
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
    scan_queue: PositiveInt = 256
    """Writes that may wait for a worker, and as many reads, in a line of their own."""
    followers: PositiveInt = 1_000
    """Event streams at a time; one more is answered 503."""
    mesh_seconds: PositiveInt = 30
    """Time to read one mesh."""
    mesh_mebibytes: PositiveInt | None = None
    """Address space to read one mesh; None: 2 048, or less (at least 320) where the service's memory is small."""
    log_level: str = "INFO"

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can reach the service."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
