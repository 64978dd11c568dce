"""The end of `voa demo`: the way to see in the console what the demo left in its database."""

import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from shlex import quote

from rich.console import Console

from voa_client import Client, VoaClientError
from voa_client.local import local_service

DATABASE = "demo.db"
"""Name of the file in the folder of the demo that keeps its sessions."""


def offer_console(folder: Path, session_id: str, terminal: Console, *, interactive: bool) -> None:
    """Print the command that shows a session in the console, and at a terminal offer to do it at once.

    Args:
        folder: of the demo, with its database.
        session_id: session of the first episode.
        terminal: to print to.
        interactive: True if a person sits at the terminal; False: only the command is printed.
    """
    database = quote(f"sqlite:///{folder / DATABASE}")
    terminal.print(
        "\nThe session of the first drop is kept. To see in the lab's web page what happened, version by version, run\n"
        f"  [bold]voa serve --console --database-url {database}[/bold]\n"
        f"and open [bold]http://127.0.0.1:8080/sessions/{session_id}[/bold]",
        highlight=False,
        soft_wrap=True,
    )
    if not interactive or find_spec("nicegui") is None:
        return
    try:
        terminal.print("Or press [bold]Enter[/bold] to open it now; Ctrl-C ends the demo.", highlight=False)
        if sys.stdin.readline():
            _show(folder, session_id)
    except KeyboardInterrupt:
        terminal.print()


@contextmanager
def kept(client: Client, session_of: Callable[[], str | None]) -> Iterator[Callable[[], None]]:
    """Delete the sessions that are opened in the `with`, but for one; yield a function that does so before its end.

    They are deleted at the end of the `with` as well, also if it ends by an exception, but not after Ctrl-C.

    Args:
        client: of the demo's own service.
        session_of: returns the session to keep; None: none.
    """
    before = {summary.id for summary in client.list_sessions()}

    def sweep() -> None:
        opened = {summary.id for summary in client.list_sessions()} - before
        for session_id in opened - {session_of()}:
            client.delete_session(session_id)

    try:
        yield sweep
        sweep()
    except Exception:  # Ctrl-C is none: the service has received it as well, and nobody would answer
        with suppress(VoaClientError):
            sweep()
        raise


def _show(folder: Path, session_id: str) -> None:
    """Serve the demo's database with a console, and open a browser at a session, until Ctrl-C."""
    # Imported for those who press Enter alone: it takes a second.
    console = importlib.import_module("voa_cli.console")
    with local_service(folder, DATABASE) as url:
        console.main(["--url", url, "--port", "0", "--open", f"/sessions/{session_id}"])
