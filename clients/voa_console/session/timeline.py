"""Time line of versions: a slider to drag, and the lines of entropy and score."""

from collections.abc import Callable

from nicegui import ui
from nicegui.events import GenericEventArguments, ValueChangeEventArguments

from voa_console.session.charts import time_chart
from voa_console.session.facts import Facts
from voa_console.session.panels import Update, panel

Choose = Callable[[int | None], None]
"""Function that receives the version to show; None: the newest one."""


def time_line(choose: Choose) -> Update:
    """Draw the time line; return the function that updates it.

    Args:
        choose: receives the version that a person drags to.
    """
    shown_newest = 0
    is_updating = False

    def slid(event: ValueChangeEventArguments[float | None]) -> None:
        if not is_updating and event.value is not None:
            version = int(event.value)
            choose(None if version >= shown_newest else version)

    def clicked(event: GenericEventArguments) -> None:
        value = event.args.get("value") if isinstance(event.args, dict) else None
        if isinstance(value, list) and value:
            slider.set_value(int(value[0]))

    with panel("Time line"):
        with ui.row().classes("w-full items-center gap-4 no-wrap max-sm:flex-wrap"):
            title = ui.label().classes("font-medium whitespace-nowrap").props("aria-live=polite")
            slider = ui.slider(min=0, max=1, step=1, value=1, on_change=slid).classes("grow min-w-32")
            slider.props('label snap markers aria-label="Version that is shown"')
        slider.disable()  # until the versions are known
        chart = ui.echart({}).classes("w-full").style("height: 190px")
        chart.props('role="img" aria-label="Expected score and entropy by version"')
        chart.on("chart:click", clicked)
        nothing = ui.label("The session has one version so far; scans and outcomes make further ones.").classes(
            "text-sm"
        )

    def update(facts: Facts) -> None:
        nonlocal shown_newest, is_updating
        moment = facts.moment
        shown_newest = moment.newest
        is_updating = True
        slider.props(f"max={max(moment.newest, 1)}")
        slider.set_value(moment.version)
        is_updating = False
        slider.set_enabled(moment.newest > 0)
        title.set_text(moment.title.capitalize())
        title.classes(replace="font-medium whitespace-nowrap" + (" text-negative" if moment.is_past else ""))
        has_history = len(facts.history) > 1
        chart.set_visibility(has_history)
        nothing.set_visibility(moment.newest == 0)
        if has_history:
            options = time_chart(facts.history, moment.version)
            if chart.options != options:
                chart.options.clear()
                chart.options.update(options)

    return update
