"""Connections of an HTTP server: their bytes are counted and timed before they become requests of any application.

| file         | purpose                                                                             |
|--------------|-------------------------------------------------------------------------------------|
| `settings`   | the bounds, with their defaults                                                     |
| `connection` | the protocol of a connection, uvicorn's: parses its bytes and times its stages      |
| `handshake`  | TLS: the handshake before the first request, and the certificate                    |
| `supervisor` | bounds the number of connections, and ends those that make no progress              |
| `in_flight`  | ASGI middleware that bounds the bytes of request bodies in memory                   |
| `refusals`   | the reasons for which a connection or a request is refused or ended                 |
| `responses`  | the responses of refusals; the server's application says how its problems look      |
| `asgi`       | the types of ASGI, and the headers of its requests and responses                    |
"""
