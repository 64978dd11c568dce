"""Fields of the page that show a choice of the draft, and change it."""

from collections.abc import Callable

from nicegui import ui

NUMBER_PROPS = "dense outlined debounce=350"


class NumberField:
    """Field for a number; where two pages show the draft, both follow it.

    Args:
        label: name of the field, with its unit.
        read: returns the value; None: nothing is stated.
        write: receives a value that a person typed.
        low, high: limits.
        step: of the arrows.
        hint: text below the field.
        empty: True if the field may be empty, which `write` receives as None.
    """

    def __init__(
        self,
        label: str,
        read: Callable[[], float | None],
        write: Callable[[float | None], None],
        *,
        low: float,
        high: float,
        step: float = 1.0,
        hint: str = "",
        empty: bool = False,
    ) -> None:
        self._read, self._write, self._empty = read, write, empty
        self._limits = low, high
        self.element = ui.number(label, value=read(), min=low, max=high, step=step, on_change=self._typed)
        self.element.props(NUMBER_PROPS).props("hide-bottom-space").classes("w-40").props["aria-label"] = label
        if hint:
            self.element.props["hint"] = hint

    def update(self) -> None:
        """Show the value of the draft."""
        value = self._read()
        if self.element.value != value:
            self.element.set_value(value)

    def _typed(self) -> None:
        value = self.element.value
        low, high = self._limits
        if (value is None and not self._empty) or value == self._read():
            return
        if value is not None and not low <= value <= high:
            self.element.props(f'error error-message="from {low:g} to {high:g}"')
            return
        self.element.props(remove="error error-message")
        self._write(value)


def heading(text: str) -> None:
    """Draw the heading of a section."""
    ui.label(text).classes("text-lg font-medium").props('role=heading aria-level="2"')


def notice(text: str, *, grave: bool = False) -> None:
    """Draw a warning, or a grave mistake, with a sign beside it."""
    with ui.row().classes("w-full items-start gap-2 no-wrap").props('role="alert"' if grave else 'role="note"'):
        ui.icon("error" if grave else "warning", size="sm", color="negative" if grave else "warning")
        ui.label(text).classes("text-sm min-w-0 break-words")
