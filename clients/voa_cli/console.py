"""`voa console`: serve the laboratory's web page beside a service.

voa console                                         for the service at http://127.0.0.1:8000
voa console --url http://lab:8000                   for a service elsewhere
voa console --no-browser                            without opening a browser

The page is a client of the service: several may run, and one may start and stop at any time. Ctrl-C stops it.
"""

import argparse
import sys
import webbrowser
from collections.abc import Sequence

from voa_client import VoaClientError
from voa_console.serving import address_of, listen, serve
from voa_console.settings import PORT, ConsoleSettings, names_of


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve the console until Ctrl-C; return 0, 1 if the address cannot be used, or 2 for wrong arguments."""
    options = _parser().parse_args(arguments)
    settings = ConsoleSettings(options.url, options.host, options.port, names_of(options.hosts))
    if not settings.is_loopback and not options.insecure:
        print(
            f"voa console: {settings.host} can be reached from other machines, and anyone there could change beliefs.\n"
            "Serve 127.0.0.1 behind a proxy with authentication, or add --insecure if the network is trusted.",
            file=sys.stderr,
        )
        return 2
    try:
        listening = listen(settings)
    except OSError as error:
        print(
            f"voa console: cannot listen on {settings.host}:{settings.port}: {error.strerror}; choose another --port",
            file=sys.stderr,
        )
        return 1
    url = address_of(listening)

    def ready() -> None:
        page = url + options.open if options.open.startswith("/") else url
        print(f"The console is at {page} (for the service at {settings.url}); Ctrl-C stops it.", flush=True)
        if options.browser and sys.stdout.isatty():
            webbrowser.open(page)

    try:
        serve(settings, listening, ready)
    except VoaClientError as error:
        print(f"voa console: {error}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa console", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--url", default="http://127.0.0.1:8000", help="address of the service (default http://127.0.0.1:8000)"
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default 127.0.0.1)")
    parser.add_argument(
        "--port", type=int, default=PORT, help=f"port to listen on, 0 for any that is free (default {PORT})"
    )
    parser.add_argument(
        "--hosts",
        default="",
        metavar="NAMES",
        help="host names with commas under which the console may be opened too (default: on loopback no others)",
    )
    parser.add_argument(
        "--insecure",
        action="store_true",
        help="allow addresses that other machines can reach, without any authentication",
    )
    parser.add_argument(
        "--open", default="/", metavar="PATH", help="page to open, such as /sessions/ID (default /, the page Now)"
    )
    parser.add_argument(
        "--no-browser", dest="browser", action="store_false", help="do not open a browser (a pipe never does)"
    )
    return parser
