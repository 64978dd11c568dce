"""Text that a person copies: a command, or lines of a file."""

from nicegui import ui


def snippet(text: str, language: str) -> None:
    """Draw text that can be copied, with its lines wrapped.

    Args:
        text: to copy.
        language: in which it is written, for its colours.
    """
    code = ui.code(text, language=language).classes("w-full")
    code.copy_button.props('aria-label="Copy"').tooltip("copy")
