"""Dialogs: an action is confirmed, carried out, and its failure shown as a sentence."""

from collections.abc import Awaitable, Callable

from nicegui import ui

from voa_client import VoaClientError
from voa_console.sentences import sentence_of

Act = Callable[[], Awaitable[str]]
"""Function that carries an action out, and returns a sentence about its effect."""


class ChangedMeanwhile(VoaClientError):
    """The session has another version than the person saw; raised for calls to which the service takes no version."""


def check_version(seen: int, newest: int | None) -> None:
    """Raise ChangedMeanwhile if the newest version is not the one that the person saw."""
    if newest is not None and newest != seen:
        raise ChangedMeanwhile(f"seen {seen}, now {newest}")


def refusal_sentence(error: VoaClientError, seen: int, newest: int | None) -> str:
    """Write why an action failed; if the session changed meanwhile, with both versions.

    Args:
        error: that the action raised.
        seen: version that the person saw.
        newest: version of the session as the console knows it; None: not known.
    """
    if isinstance(error, ChangedMeanwhile):
        return (
            f"Somebody else changed the session in the meantime: you saw version {seen}, and it has version {newest} "
            "now. Look at the new state, then try again."
        )
    return sentence_of(error)


class ActionDialog:
    """Dialog of one action: its content, a button that cancels, and one that carries the action out.

    A failed action leaves the dialog open with a sentence in it.

    Args:
        title: of the dialog.
        confirm: name of the button that carries the action out.
        act: carries the action out.
        refused: writes the sentence for an error.
        danger: True for an action that cannot be undone.
    """

    def __init__(
        self, title: str, confirm: str, act: Act, refused: Callable[[VoaClientError], str], *, danger: bool = False
    ) -> None:
        self._act = act
        self._refused = refused
        with (
            ui.dialog().props("persistent") as self._dialog,
            ui.card().classes("gap-3 w-96 max-w-full"),
        ):
            self._dialog.props["aria-label"] = title
            ui.label(title).classes("text-lg font-medium").props('role=heading aria-level="2"')
            self.content = ui.column().classes("w-full gap-2")
            self._error = ui.label().classes("text-negative font-medium").props("role=alert")
            self._error.set_visibility(False)
            with ui.row().classes("w-full justify-end"):
                ui.button("Cancel", on_click=self._dialog.close, color=None).props("flat no-caps")
                self._button = ui.button(confirm, on_click=self._carry_out, color="negative" if danger else "primary")
                self._button.props("no-caps")
        self._dialog.on("hide", self._dialog.delete)

    def forbid(self) -> None:
        """Disable the button that carries the action out, because it cannot be carried out now."""
        self._button.disable()

    def open(self) -> None:
        """Show the dialog."""
        self._dialog.open()

    async def _carry_out(self) -> None:
        self._error.set_visibility(False)
        self._button.disable()
        try:
            effect = await self._act()
        except VoaClientError as error:
            self._error.set_text(self._refused(error))
            self._error.set_visibility(True)
            return
        finally:
            self._button.enable()
        with self._dialog:
            ui.notify(effect, type="positive")
        self._dialog.close()
