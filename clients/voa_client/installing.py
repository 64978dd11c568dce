"""The command that installs missing parts of the project: from a clone, since it is not in a package index."""


def install_hint(extra: str = "") -> str:
    """Return the command that installs this project from a clone, with an extra such as "zenoh" if one is needed."""
    return f"pip install 'PATH_TO_CLONE{f'[{extra}]' if extra else ''}'"
