"""What robot software installs to talk to the service: messages in, messages out, over HTTP.

Needs pydantic and an HTTP library; never numpy.
"""

from voa_client.client import Client
from voa_client.errors import ProblemError, UnreachableError, VoaClientError

__all__ = ["Client", "ProblemError", "UnreachableError", "VoaClientError"]
