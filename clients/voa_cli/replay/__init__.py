"""`voa replay`: what was recorded, through a service once more."""

from voa_cli.replay.command import main

__all__ = ["main"]
