"""`voa serve`: runs the service, and with `--console` the console beside it as a process of its own.

The service belongs to another package, which knows no client: it is given the function that starts a console.
"""

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec

from voa_service.serve import main as serve

_STOP_SECONDS = 5.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the service until a signal stops it, and return its exit code."""
    return serve(arguments, console_beside if find_spec("nicegui") else None)


@contextmanager
def console_beside(url: str, host: str, port: int, names: Sequence[str]) -> Iterator[Callable[[], int | None]]:
    """Run a console for the length of a `with`; gives a function that returns its port, or None once it has ended.

    Args:
        url: of the service.
        host: address to listen on.
        port: to listen on; 0: any that is free.
        names: host names under which the console may be opened, besides those of loopback.

    Raises:
        OSError: the address cannot be used.
    """
    from voa_client.local import end  # noqa: PLC0415 - most services run without a console, and without a client
    from voa_console.serving import listen  # noqa: PLC0415 - most services run without a console
    from voa_console.settings import ConsoleSettings  # noqa: PLC0415 - most services run without a console

    with listen(ConsoleSettings(url, host, port)) as listening:
        taken: int = listening.getsockname()[1]
        listening.listen()
        fd = listening.fileno()
        command = [sys.executable, "-m", "voa_console", "--url", url, "--fd", str(fd), "--hosts", ",".join(names)]
        # Its stdin is a pipe that nobody writes to: the console ends when this process does, however it ends.
        process = subprocess.Popen([*command, "--with-stdin"], stdin=subprocess.PIPE, pass_fds=[fd])  # noqa: S603 - our own module
    try:
        yield lambda: taken if process.poll() is None else None
    finally:
        end(process, _STOP_SECONDS)
        if process.stdin is not None:
            process.stdin.close()
