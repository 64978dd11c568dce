"""`voa doctor`: find out what is wrong between this machine, the service, and the robots."""

from voa_cli.doctor.command import main

__all__ = ["main"]
