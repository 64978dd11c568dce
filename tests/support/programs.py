"""Programs of others, written in Python, that tests run."""

import os


def unmeasured() -> dict[str, str]:
    """Return the environment for a program that runs no code of these packages, which measuring coverage would slow."""
    return {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_PROCESS_")}
