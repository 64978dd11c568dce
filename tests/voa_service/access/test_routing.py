"""The call of an HTTP request, by its method and path."""

import pytest

from voa_service.access.roles import CALLS
from voa_service.access.routing import Routes

ROUTES = Routes(CALLS)


@pytest.mark.parametrize(
    ("method", "path", "name", "subject"),
    [
        ("GET", "/livez", "service.alive", None),
        ("HEAD", "/docs", "service.describe", None),
        ("GET", "/static-offline-docs/swagger-ui.css", "service.describe", "swagger-ui.css"),
        ("GET", "/v1/sessions", "session.list", None),
        ("POST", "/v1/sessions", "session.create", None),
        ("GET", "/v1/sessions/s1", "session.get", "s1"),
        ("POST", "/v1/sessions/s1/scans", "scan.apply", "s1"),
        ("DELETE", "/v1/sessions/s1/looks/l1", "look.cancel", "s1"),
        ("PUT", "/v1/robots/tb3_1/session", "robot.claim", "tb3_1"),
        ("PATCH", "/v1/sessions/s1", "unlisted", "s1"),
        ("GET", "/v1/sessions/", "unlisted", None),
        ("GET", "/v1//sessions", "unlisted", None),
        ("GET", "/v1/sessions/s1/scans/more", "unlisted", None),
        ("GET", "/v1", "unlisted", None),
        ("GET", "/", "service.open", None),
        ("GET", "", "unlisted", None),
        ("GET", "*", "unlisted", None),
        ("GET", "/livez/../v1/sessions", "unlisted", None),
        ("GET", "/v1/sessions/{}", "session.get", "{}"),
    ],
)
def test_a_request_is_matched(method: str, path: str, name: str, subject: str | None) -> None:
    matched = ROUTES.match(method, path)
    assert (matched.call.name, matched.subject) == (name, subject)
