"""Messages on the wire: one schema for HTTP and Zenoh, used by the service and its clients.

The service refuses requests with unknown fields. Clients ignore unknown fields of responses, so that an old robot can
talk to a new service. All units are SI. The docstring of a field is its description in the OpenAPI document. Depends on
pydantic alone.
"""

WIRE_VERSION = 1
"""Version of the messages: it grows when a change would make a client and a service misunderstand each other."""
