"""`voa replay`: send recorded experiments, sessions and scans through a service again."""

from voa_cli.replay.command import main

__all__ = ["main"]
