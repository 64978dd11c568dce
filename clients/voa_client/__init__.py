"""What robot software installs to talk to the service: messages in, messages out, over HTTP or Zenoh.

Needs pydantic and an HTTP library, for Zenoh its library too; never numpy.
"""

from voa_client._arm import ArmClient, AsyncArmClient
from voa_client._async_client import AsyncClient
from voa_client._attempts import Retries
from voa_client._client import Client
from voa_client._errors import (
    ConflictError,
    DeniedError,
    InvalidRequestError,
    NotFoundError,
    OverloadedError,
    ProblemError,
    StaleVersionError,
    TimedOutError,
    UnavailableError,
    UnexpectedAnswerError,
    UnreachableError,
    UsageError,
    VoaClientError,
    WireVersionError,
)
from voa_client._sensor import AsyncSensorClient, SensorClient

__all__ = [
    "ArmClient",
    "AsyncArmClient",
    "AsyncClient",
    "AsyncSensorClient",
    "Client",
    "ConflictError",
    "DeniedError",
    "InvalidRequestError",
    "NotFoundError",
    "OverloadedError",
    "ProblemError",
    "Retries",
    "SensorClient",
    "StaleVersionError",
    "TimedOutError",
    "UnavailableError",
    "UnexpectedAnswerError",
    "UnreachableError",
    "UsageError",
    "VoaClientError",
    "WireVersionError",
]
