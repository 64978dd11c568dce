"""Whether a host and port can be reached at all."""

import socket

from voa_cli.doctor.findings import Budget, Finding, TookTooLong

_SECONDS = 2.0


def reach(check: str, host: str, port: int, budget: Budget) -> Finding:
    """Look up the name and connect by TCP."""
    where = f"{host}:{port}"
    try:
        budget.within(_SECONDS, lambda: socket.create_connection((host, port), _SECONDS).close())
    except socket.gaierror as error:
        return Finding(check, "wrong", f"no such host: {host} ({error.strerror})", "spell the name, or use the address")
    except ConnectionRefusedError:
        return Finding(
            check,
            "wrong",
            f"nothing listens at {where}",
            "start it there, or name the right port",
        )
    except (TimeoutError, TookTooLong):
        return Finding(
            check, "wrong", f"no answer from {where} within {_SECONDS:.0f} s", "is the machine on, in this network?"
        )
    except OSError as error:
        return Finding(check, "wrong", f"{where}: {error.strerror or error}", "check the network between the two")
    return Finding(check, "ok", f"{where} takes connections")
