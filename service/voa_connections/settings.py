"""Bounds on connections, headers, slow bodies and slow readers, as settings."""

from pydantic import BaseModel, ConfigDict, PositiveFloat, PositiveInt

MEBIBYTE = 2**20


class ConnectionSettings(BaseModel):
    """Limits on connections, headers, slow bodies and slow readers: `VOA_CONNECTIONS__MOST=300` and so on."""

    model_config = ConfigDict(frozen=True)

    most: PositiveInt = 1_000
    """Connections at a time; fewer where the process may open fewer files (RLIMIT_NOFILE less 256)."""
    header_bytes: PositiveInt = 65_536
    """Bytes of a request line and its headers together; a larger request is answered 431."""
    headers: PositiveInt = 100
    """Number of headers of a request; a request with more is answered 431."""
    header_seconds: PositiveFloat = 10.0
    """Time from the first byte of a request to the end of its headers; a slower request is answered 408."""
    progress_seconds: PositiveFloat = 20.0
    """Time in which `progress_bytes` more of a body must arrive (else 408), or of a response be read (else it ends)."""
    progress_bytes: PositiveInt = 16_384
    """Bytes that must be sent or read within `progress_seconds`; the last part may have fewer."""
    in_flight_mebibytes: PositiveInt = 128
    """Memory for request bodies, beyond the first 64 kB of each (a body that exceeds it is answered 503), and as much
    again for responses that wait to be read."""
