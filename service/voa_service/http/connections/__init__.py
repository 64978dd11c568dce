"""Connections of the HTTP server: their bytes are counted and timed before they become requests.

| file         | purpose                                                                          |
|--------------|----------------------------------------------------------------------------------|
| `connection` | the protocol of a connection: parses its bytes and times its stages              |
| `supervisor` | bounds the number of connections, and ends those that make no progress           |
| `refusals`   | the reasons for which a connection is refused or ended, and the responses        |
| `in_flight`  | bounds the bytes of request bodies that the application holds                    |
"""
