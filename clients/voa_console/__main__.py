"""`python -m voa_console`: a console on a socket that the parent process has opened."""

import argparse
import os
import signal
import socket
import sys
import threading
from contextlib import suppress

from voa_console.serving import serve
from voa_console.settings import ConsoleSettings, names_of


def main() -> None:
    """Serve the console until a signal stops the process."""
    parser = argparse.ArgumentParser(prog="python -m voa_console", description="Serve the console on an open socket.")
    parser.add_argument("--url", required=True, help="address of the service")
    parser.add_argument("--fd", type=int, required=True, help="file descriptor of the socket to listen on")
    parser.add_argument("--hosts", default="", help="host names with commas under which the console may be opened too")
    parser.add_argument("--with-stdin", action="store_true", help="stop when stdin is closed, as the parent's end does")
    options = parser.parse_args()
    listening = socket.socket(fileno=options.fd)
    host, port = listening.getsockname()[:2]
    if options.with_stdin:
        threading.Thread(target=_stop_with_stdin, daemon=True).start()
    with suppress(KeyboardInterrupt):  # uvicorn raises the signal again when it has stopped
        serve(ConsoleSettings(options.url, host, port, names_of(options.hosts)), listening, lambda: None)


def _stop_with_stdin() -> None:
    """Wait for the end of stdin, and then stop this process in order."""
    sys.stdin.buffer.read()
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    main()
