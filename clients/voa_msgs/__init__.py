"""The messages on the wire: one schema for every transport, used by the service and its clients.

Requests refuse what they do not know; a client reads answers with `extra="ignore"`, so that an old robot can
talk to a new service. Units are SI and stand in the field names. Depends on pydantic alone.
"""

WIRE_VERSION = 1
