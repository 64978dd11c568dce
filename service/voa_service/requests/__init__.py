"""Requests before a use case sees them, for every entrypoint: HTTP, remote calls and scans on Zenoh.

| file          | purpose                                                                                |
|---------------|----------------------------------------------------------------------------------------|
| `bodies`      | reads a JSON body into a message, large ones in a queue of their own                   |
| `limits`      | refuses bodies with too many bytes, values or keys before they are parsed              |
| `attachments` | reads the attachment of a request on Zenoh, which may say where a scan was taken       |
| `large_json`  | writes and reads JSON of large messages in steps between which other threads run       |
| `idempotency` | makes the idempotency key of a write, and the write that the store records             |
"""
