"""Check that a host and port can be reached by TCP."""

import socket

from voa_doctor.findings import Budget, Finding, TookTooLong

_SECONDS = 2.0


def reach(check: str, host: str, port: int, budget: Budget) -> Finding:
    """Look up a host's name, and connect to its port by TCP."""
    where = f"{host}:{port}"
    try:
        budget.within(_SECONDS, lambda: socket.create_connection((host, port), _SECONDS).close())
    except socket.gaierror as error:
        return Finding(
            check,
            "wrong",
            f"no such host: {host} ({error.strerror})",
            "check the spelling of the name, or use the IP address",
        )
    except ConnectionRefusedError:
        return Finding(
            check,
            "wrong",
            f"nothing listens at {where}",
            "start the service or router there, or correct the port",
        )
    except (TimeoutError, TookTooLong):
        return Finding(
            check,
            "wrong",
            f"no answer from {where} within {_SECONDS:.0f} s",
            "check that the machine is on, and in this network",
        )
    except OSError as error:
        return Finding(check, "wrong", f"{where}: {error.strerror or error}", "check the network between the two")
    return Finding(check, "ok", f"{where} accepts connections")
