"""HTTP in front of the use cases: resources, problem documents, limits on bodies, and who may call.

The bytes of a connection are parsed, counted and timed by `voa_connections` before they become a request.

A request passes the parts in this order:

| file or folder   | purpose                                                                            |
|------------------|------------------------------------------------------------------------------------|
| `server`         | uvicorn's server, which stops in bounded time                                      |
| `refusals`       | problem documents of connections and requests that `voa_connections` refuses       |
| `app`            | builds the application: the middleware and the routes, in their order              |
| `middleware`     | request ids and the access log, limits on bodies, the version of the messages      |
| `access`         | refuses unknown host names, and calls from web pages of other sites                |
| `authentication` | admits requests by their keys, from the headers alone, and records writes          |
| `direct`         | calls the operations of plain requests without FastAPI's routing and solving       |
| `calls`          | refuses unknown query parameters, and reads the body of a request into its message |
| `routes/`        | the operations: each hands its work to a queue and its result to a response        |
| `headers`        | the headers `ETag`, `If-Match` and `Idempotency-Key`                               |
| `problems`       | turns every error into a problem document (RFC 9457)                               |
| `openapi`        | the OpenAPI document, with the service's limits and problems                       |
"""
