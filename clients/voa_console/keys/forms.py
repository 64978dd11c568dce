"""Routes of the forms: one receives a key, the other forgets it. The key is in the body, never in an address."""

from fastapi import FastAPI, Request
from starlette.responses import RedirectResponse

from voa_client import UsageError, VoaClientError
from voa_console.keys.access import KEY_PATH, Access, own_page
from voa_console.keys.admission import cookie_name, secret_of
from voa_console.sentences import sentence_of

_NO_KEY = "This is not a key: expected the text that `voa keys create` prints, which begins with voa_."
_FORGOTTEN = "The key is forgotten."


def serve_forms(app: FastAPI, access: Access) -> None:
    """Declare the routes.

    Args:
        app: the application.
        access: of browsers.
    """

    @app.post(KEY_PATH)
    async def enter(request: Request) -> RedirectResponse:
        async with request.form(max_files=0, max_fields=4) as form:
            key, to = str(form.get("key", "")).strip(), own_page(str(form.get("to", "")))
        try:
            secret = await access.enter(key, secret_of(request.scope))
        except UsageError:
            return _redirect(access.key_page(to, _NO_KEY))
        except VoaClientError as error:
            return _redirect(access.key_page(to, sentence_of(error)))
        response = _redirect(to)
        if secret is not None:
            response.set_cookie(
                cookie_name(request.scope),
                secret,
                path="/",
                httponly=True,
                samesite="lax",
                secure=request.url.scheme == "https",
            )
        return response

    @app.post(f"{KEY_PATH}/forget")
    async def forget(request: Request) -> RedirectResponse:
        secret = secret_of(request.scope)
        if secret is not None:
            access.leave(secret)
        response = _redirect(access.key_page("/", _FORGOTTEN))
        response.delete_cookie(cookie_name(request.scope), path="/", httponly=True, samesite="lax")
        return response


def _redirect(to: str) -> RedirectResponse:
    return RedirectResponse(to, 303, headers={"Cache-Control": "no-store"})
