"""Layer between the network and requests: bytes are counted and timed before anything is made of them.

`connection` is a connection's protocol, `guard` looks after all connections, `refusals` lists why one is refused, and
`in_flight` counts the bytes of bodies that the application holds.
"""
