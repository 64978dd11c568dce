"""Page on which a person gives a key. The text of the key goes from the form to the console, and is shown nowhere."""

from nicegui import ui

from voa_console import layout
from voa_console.context import Console
from voa_console.keys.access import KEY_PATH, Access, own_page
from voa_console.sentences import needs_key, sentence_of

_AGAIN_S = 5
"""Time after which the page leads on while the service does not respond: it may have no keys, seconds."""

_ROLES = (
    ("viewer", "sees everything, and values looks"),
    ("sensor", "as a viewer, and requests and announces looks"),
    ("arm", "as a viewer, and reports outcomes of grasps"),
    ("operator", "does everything: opens and ends sessions, claims robots, makes objects"),
)
_FORM = f'method="post" action="{KEY_PATH}"'
_STYLE = """
.voa-key-field { flex: 1 1 auto; min-width: 0; padding: 0.6rem 0.75rem; border: 1px solid #767676; border-radius: 4px;
  font: inherit; background: white; color: black; }
.body--dark .voa-key-field { background: #1d1d1d; color: white; border-color: #9a9a9a; }
.voa-key-field:focus { outline: 3px solid #E69F00; outline-offset: 1px; }
"""


def register(access: Access) -> None:
    """Declare the page."""

    @ui.page(KEY_PATH)
    def key_page(to: str = "/", notice: str = "") -> None:
        layout.dress("Key")
        ui.add_css(_STYLE)
        layout.plain_header(access.settings.url)
        with ui.column().classes("voa-page gap-4 items-center"), ui.card().classes("w-full max-w-xl gap-4 p-5"):
            _draw(access, own_page(to), access.notices.get(notice))


def _draw(access: Access, to: str, sentence: str) -> None:
    """Draw what a key is, and the form for it."""
    own = access.consoles.own
    caller, why = own.caller, _why(own)
    if _is_away(own):
        ui.add_head_html(f'<meta http-equiv="refresh" content="{_AGAIN_S};url={to}">')
    ui.label("Enter your key").classes("text-2xl").props('role=heading aria-level="1"')
    if sentence and sentence not in why:
        with ui.row().classes("w-full items-center no-wrap rounded p-3 bg-warning text-white").props('role="alert"'):
            ui.icon("info", size="sm")
            ui.label(sentence).classes("min-w-0 break-words")
    ui.label(why).classes("text-base")
    _form(to)
    if caller is not None:
        ui.link("Continue without a key of your own", to)
    with ui.expansion("What is a key, and who makes one?", value=True).classes("w-full").props("dense"):
        ui.label(
            "A key is a line of text that begins with voa_. Its name says who you are, and its role what you may do. "
            "Whoever runs the service makes one, at a terminal on its machine:"
        ).classes("text-sm")
        ui.code("voa keys create YOUR_NAME --role viewer", language="bash").classes("w-full")
        with ui.column().classes("gap-1 w-full pt-2").props('role="list" aria-label="Roles"'):
            for role, does in _ROLES:
                with ui.row().classes("gap-2 no-wrap items-baseline text-sm").props('role="listitem"'):
                    ui.label(role).classes("font-mono w-20 shrink-0")
                    ui.label(does)
    ui.label(
        "This console keeps the key in its memory until you press Forget the key, until none of your pages was open "
        "for 12 hours, or until it stops. It writes the key to no file and no log, and calls the service with it for "
        "your pages alone."
    ).classes("text-sm opacity-80")


def _is_away(own: Console) -> bool:
    """True if the service has not said yet whether it needs a key."""
    return own.caller is None and own.hub.error is not None and not needs_key(own.hub.error)


def _why(own: Console) -> str:
    """Write why a key is given, where the console itself calls the service as it does."""
    url, caller, error = own.settings.url, own.caller, own.hub.error
    if error is not None and _is_away(own):
        return f"{url}: {sentence_of(error)} This page continues by itself."
    if caller is None:
        return f"The service at {url} answers only callers that have a key."
    if caller.key is None:
        return f"The service at {url} has no keys: everybody may do everything, and you need none."
    return (
        f"This console calls the service at {url} by its own key, {caller.name}, with the role {caller.role}. With a "
        "key of your own, your pages do what your role allows."
    )


def _form(to: str) -> None:
    with ui.element("form").props(_FORM).classes("w-full flex gap-3 items-stretch max-sm:flex-col"):
        field = ui.element("input").classes("voa-key-field")
        field.props('type="password" name="key" required autofocus autocomplete="current-password" maxlength="512"')
        field.props('aria-label="Key" placeholder="voa_..." spellcheck="false"')
        hidden = ui.element("input").props('type="hidden" name="to"')
        hidden.props["value"] = to
        ui.button("Open the console", icon="login").props('type="submit"')
