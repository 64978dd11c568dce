"""Replay of experiments, sessions and robots' scans through a service, with typed reports."""
