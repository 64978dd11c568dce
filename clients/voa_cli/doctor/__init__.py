"""`voa doctor`: what is wrong between this machine and the service."""

from voa_cli.doctor.command import main

__all__ = ["main"]
