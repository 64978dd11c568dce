"""Lists of findings: a sign, the observation, and below it the advice."""

from collections.abc import Sequence

from nicegui import ui

from voa_doctor.findings import Finding, State
from voa_scene.colours import GREEN, ORANGE, VERMILION

_ICONS: dict[State, tuple[str, str, str]] = {
    "ok": ("check_circle", GREEN.hex, "passed"),
    "warning": ("warning", ORANGE.hex, "warning"),
    "wrong": ("cancel", VERMILION.hex, "wrong"),
}


class Checklist:
    """List of findings that is drawn again where a check or a state changed, and else gets new texts.

    Args:
        name: of the list, for screen readers.
    """

    def __init__(self, name: str) -> None:
        self._element = ui.column().classes("w-full gap-2").props('role="list"')
        self._element.props["aria-label"] = name
        self._drawn: list[tuple[str, State, bool]] = []
        self._labels: list[tuple[ui.label, ui.label | None]] = []

    def update(self, findings: Sequence[Finding]) -> None:
        """Show other findings."""
        shape = [(finding.check, finding.state, bool(finding.advice)) for finding in findings]
        if shape != self._drawn:
            self._drawn = shape
            self._element.clear()
            with self._element:
                self._labels = [_draw(finding) for finding in findings]
        for finding, (seen, advice) in zip(findings, self._labels, strict=True):
            seen.set_text(f"{finding.check}: {finding.seen}")
            if advice is not None:
                advice.set_text(_sentence(finding.advice))


def draw_sign(state: State) -> None:
    """Draw the sign of a state, with its meaning for screen readers."""
    icon, colour, meaning = _ICONS[state]
    with ui.element("span").props(f'role="img" aria-label="{meaning}"'):
        ui.icon(icon, size="sm").style(f"color: {colour}")


def _draw(finding: Finding) -> tuple[ui.label, ui.label | None]:
    with ui.row().classes("w-full items-start gap-2 no-wrap").props('role="listitem"'):
        draw_sign(finding.state)
        with ui.column().classes("gap-0 min-w-0"):
            seen = ui.label().classes("text-sm min-w-0").style("overflow-wrap: anywhere")
            advice = None
            if finding.advice:
                advice = ui.label().classes("text-sm font-medium min-w-0").style("overflow-wrap: anywhere")
    return seen, advice


def _sentence(advice: str) -> str:
    """Write advice as a sentence of its own."""
    return f"→ {advice[:1].upper()}{advice[1:]}"
