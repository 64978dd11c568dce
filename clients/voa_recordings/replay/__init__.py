"""Replays: recordings sent through a service once more."""
