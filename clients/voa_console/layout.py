"""The frame around every page: links, the key, dark or light, the service's address, and whether it responds."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from nicegui import ui

from voa_console.context import Console
from voa_console.keys.access import Admitted
from voa_console.keys.admission import admitted_of
from voa_console.keys.header import draw_key
from voa_console.keys.leaving import Leaving
from voa_console.sentences import needs_key, sentence_of

LINKS = {"Now": "/", "New object": "/new", "Robots": "/robots"}
"""Names and paths of the pages in the header; the page of a session is linked from its card."""
_COOKIE = "voa_dark"
_STYLE = """
a:focus-visible, button:focus-visible, [tabindex]:focus-visible { outline: 3px solid #E69F00; outline-offset: 2px; }
.voa-link { color: inherit; text-decoration: none; padding: 0.35rem 0.6rem; border-radius: 4px; }
.voa-link:hover, .voa-link[aria-current] { background: rgba(255, 255, 255, 0.2); }
.q-btn { text-transform: none; }
.q-btn--dense:not(.q-btn--round) { padding: 0.285em 0.8em; }
.nicegui-code pre { white-space: pre-wrap; overflow-wrap: anywhere; padding-right: 2.75rem; }
.nicegui-code-copy { --q-primary: currentColor; opacity: 0.9; top: 0.2rem; }
.voa-page a { color: var(--q-primary); }
.body--dark .voa-page a { color: #56b4e9; }
.voa-page { max-width: 1600px; margin: 0 auto; width: 100%; }
"""


@contextmanager
def page(title: str) -> Iterator[Console]:
    """Draw the frame of a page; elements of the `with` block become its content.

    The page counts as open in the hub until its browser has left. It leaves for the page of the key when its key is
    forgotten, or no longer accepted.

    Args:
        title: of the page, as its heading and in the browser's tab.

    Yields:
        The console of the key by which the page calls the service.
    """
    client = ui.context.client
    admitted = admitted_of(client.request)
    console = admitted.console
    leaving = Leaving(client, console)
    while_open(console.hub.open_page())
    while_open(admitted.open_page(leaving.forgotten))
    dress(title)
    _header(admitted, title)
    show = banner(console)
    while_open(console.hub.subscribe(leaving.check))
    while_open(console.hub.subscribe(show))
    with ui.column().classes("voa-page gap-4"):
        ui.label(title).classes("text-2xl").props('role=heading aria-level="1"')
        yield console


def dress(title: str) -> None:
    """Give a page its title in the browser's tab, its colours and its style."""
    ui.page_title(f"{title} · VOA")
    ui.add_css(_STYLE)
    ui.colors(primary="#00507A", negative="#B3400A", positive="#00735A", warning="#8A5A00")


def plain_header(url: str) -> None:
    """Draw a header without links, for a page that needs no key.

    Args:
        url: address of the service.
    """
    with ui.header().classes("items-center gap-1 px-3 py-1"), ui.row().classes("items-center gap-1 w-full"):
        ui.label("VOA console").classes("text-base px-2")
        ui.space()
        _address(url)
        _dark_or_light()


def while_open(unsubscribe: Callable[[], None]) -> None:
    """Call a function when the browser has left the page that is being drawn."""
    ui.context.client.on_delete(unsubscribe)


def banner(console: Console) -> Callable[[], None]:
    """Draw the banner that is shown while the service does not respond; return the function that updates it."""
    with ui.row().classes("w-full items-center bg-negative text-white rounded p-3").props('role="alert"') as row:
        ui.icon("cloud_off", size="md")
        text = ui.label()
    row.set_visibility(False)

    def update() -> None:
        error = None if needs_key(console.hub.error) else console.hub.error
        row.set_visibility(error is not None)
        if error is not None:
            state = " This page shows the last state, and continues by itself." if console.hub.has_responded else ""
            text.set_text(f"{console.settings.url}: {sentence_of(error)}{state}")

    update()
    return update


def _header(admitted: Admitted, title: str) -> None:
    """Draw the header with the link of the page marked; the page of a session belongs to the page Now."""
    console = admitted.console
    with ui.header().classes("items-center gap-1 px-3 py-1"), ui.row().classes("items-center gap-x-3 gap-y-0 w-full"):
        with ui.row().classes("items-center gap-1").props('role="navigation" aria-label="Pages"'):
            for name, path in LINKS.items():
                if path == "/new" and not console.may("scenario.create"):
                    continue
                link = ui.link(name, path).classes("voa-link")
                if name == title:
                    link.props('aria-current="page"')
                elif title not in LINKS and path == "/":
                    link.props('aria-current="true"')
        ui.space()
        _address(console.settings.url)
        draw_key(admitted)
        _dark_or_light()


def _address(url: str) -> None:
    address = ui.label(f"service: {url}").classes("text-sm opacity-80 max-md:hidden")
    address.tooltip("the service that this console watches")


def _dark_or_light() -> None:
    """Draw the switch between dark and light; the browser remembers it, and follows its system before that."""
    request = ui.context.client.request
    remembered = None if request is None else {"1": True, "0": False}.get(request.cookies.get(_COOKIE, ""))
    mode = ui.dark_mode(remembered)

    async def switch() -> None:
        is_dark = bool(await ui.run_javascript("return Quasar.Dark.isActive"))
        mode.value = not is_dark
        ui.run_javascript(
            f"document.cookie = '{_COOKIE}={int(not is_dark)}; path=/; max-age=31536000; SameSite=Strict'"
        )

    button = ui.button(icon="contrast", on_click=switch).props('flat round color=white aria-label="Dark or light"')
    button.tooltip("dark or light")
