"""Errors of the HTTP parser, below the framework, as problem documents."""

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from voa_service.failures import NOT_HTTP, Failure, document
from voa_service.http.problems import MEDIA_TYPE


class ProblemProtocol(HttpToolsProtocol):
    """Protocol of a connection that answers what is no HTTP with a problem document, and ends."""

    def send_400_response(self, msg: str) -> None:
        """Answer what the parser could not read."""
        body = document(Failure(NOT_HTTP, f"expected a request in HTTP/1.1: {msg}"))
        head = f"HTTP/1.1 400 Bad Request\r\ncontent-type: {MEDIA_TYPE}\r\ncontent-length: {len(body)}\r\n"
        self.transport.write(head.encode() + b"connection: close\r\n\r\n" + body)
        self.transport.close()
