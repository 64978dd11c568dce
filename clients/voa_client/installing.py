"""How to install what is missing: from a clone, because no published package of this name is this project's."""


def install_hint(extra: str = "") -> str:
    """Name the command that installs this project from a clone, with an extra where one is needed."""
    return f"pip install 'PATH_TO_CLONE{f'[{extra}]' if extra else ''}'"
