"""Panels beside the scene: advice, grasps, belief, last update and absence, each updated from the facts."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from nicegui import ui

from voa_client.formatting import share
from voa_console.sentences import REASONS
from voa_console.session.charts import belief_chart, belief_chart_height
from voa_console.session.facts import Facts
from voa_console.session.words import advice, after_success, cause_of, step_of
from voa_msgs.robots import RobotReport

Update = Callable[[Facts], None]
"""Function that shows facts in a panel."""
_MOST_GRASPS = 8
_LATEST_STEPS = 6
_WAITING = "The service is ranking the places."


@dataclass(frozen=True)
class GraspRow:
    """Row of the table of grasps: name, score in words, and length of its bar, 0 to 1."""

    name: str
    score: str
    share: float


def panel(title: str) -> ui.card:
    """Draw an empty panel with its title."""
    card = ui.card().classes("w-full gap-1 p-3").props("role=region")
    card.props["aria-label"] = title
    with card:
        ui.label(title).classes("text-xs uppercase tracking-wide opacity-70").props('role="heading" aria-level="2"')
    return card


def past_bar(back: Callable[[], None]) -> Update:
    """Draw the bar that marks a past version, with the way back.

    Args:
        back: shows the newest version again.
    """
    bar = ui.row().classes("w-full items-center rounded px-3 py-2 text-black sticky top-14 z-10")
    with bar.style("background: #e69f00").props('role="status"'):
        ui.icon("history", size="sm")
        text = ui.label().classes("font-medium")
        ui.space()
        ui.button("Back to now", icon="update", on_click=back, color="primary").props("dense no-caps").classes("px-2")
    bar.set_visibility(False)

    def update(facts: Facts) -> None:
        bar.set_visibility(facts.moment.is_past)
        text.set_text(f"You see {facts.moment.title}.")

    return update


def problem_bar() -> Callable[[str], None]:
    """Draw the bar that says why the session is not followed; return the function that shows a sentence; "": none."""
    with (
        ui.row().classes("w-full items-center no-wrap bg-negative text-white rounded p-3").props('role="alert"') as bar
    ):
        ui.icon("sync_problem", size="md")
        text = ui.label().classes("min-w-0 break-words")
    bar.set_visibility(False)

    def show(sentence: str) -> None:
        bar.set_visibility(bool(sentence))
        text.set_text(sentence)

    return show


def advice_panel() -> tuple[Update, Callable[[str], None]]:
    """Draw the panel of the advice; return the functions that update it, and that show why there is none."""
    with panel("Advice"):
        headline = ui.label(_WAITING).classes("text-lg font-medium leading-snug").props("aria-live=polite")
        details = ui.column().classes("gap-1 text-sm")
    shown: list[str] = []

    def show(first: str, sentences: Sequence[str]) -> None:
        headline.set_text(first)
        if shown != list(sentences):
            shown[:] = sentences
            details.clear()
            with details:
                for sentence in sentences:
                    ui.label(sentence)

    def update(facts: Facts) -> None:
        if facts.moment.is_past:
            show(f"Version {facts.moment.version} of {facts.moment.newest}, the past.", past_details(facts))
        elif facts.ranking_at_moment is not None:
            written = after_success(advice(facts.ranking_at_moment, facts.scenario, facts.outcomes), facts.entry)
            show(written.headline, written.details)
        elif not headline.text or headline.text.endswith("the past."):
            show(_WAITING, ())

    return update, lambda sentence: show(sentence, ())


def past_details(facts: Facts) -> tuple[str, ...]:
    """Write what was best at a past version, and what came next."""
    grasp = facts.moment.best_grasp
    best = (
        "No grasp could succeed."
        if grasp is None
        else f"Best grasp then: {grasp}, {share(facts.moment.expected_score)}."
    )
    next_ = next((entry for entry in facts.history if entry.version == facts.moment.version + 1), None)
    return (best,) if next_ is None else (best, f"Then came: {_lowered(step_of(next_))}.")


def _lowered(text: str) -> str:
    return text[:1].lower() + text[1:]


def steps_panel(choose: Callable[[int | None], None]) -> Update:
    """Draw the list of what happened, one row for each version, the newest last.

    Args:
        choose: receives the version that a person wants to see; None: the newest one.
    """
    with panel("What happened"):
        earlier = ui.label().classes("text-xs opacity-70")
        rows = ui.column().classes("w-full gap-0").props('role="list" aria-label="Versions of the session"')
    shown: list[tuple[int, str, bool]] = []

    def update(facts: Facts) -> None:
        made = step_rows(facts)
        if made == shown:
            return
        shown[:] = made
        hidden = len(facts.history) - len(made)
        earlier.set_text(f"{hidden} earlier: drag the time line to see them" if hidden > 0 else "")
        rows.clear()
        with rows:
            for version, text, is_shown in made:
                chosen = None if version >= facts.moment.newest else version
                button = ui.button(text, on_click=lambda _, own=chosen: choose(own), color=None)
                button.props("flat dense no-caps align=left")
                if is_shown:
                    button.props("aria-current=step")
                button.classes("w-full px-2 text-sm font-normal" + (" font-bold bg-primary/10" if is_shown else ""))

    return update


def step_rows(facts: Facts) -> list[tuple[int, str, bool]]:
    """Return the newest versions, each with what made it and its best score, and True for the one that is shown."""
    rows = []
    for entry in facts.history[-_LATEST_STEPS:]:
        score = "" if entry.expected_score is None else f", best score {share(entry.expected_score)}"
        rows.append((entry.version, f"{entry.version}  {step_of(entry)}{score}", entry.version == facts.moment.version))
    return rows


def grasp_panel() -> Update:
    """Draw the panel of the grasps, best first."""
    with panel("Grasps"):
        rows = ui.column().classes("w-full gap-1").props('role="list" aria-label="Grasps, best first"')
        more = ui.label().classes("text-xs opacity-70")
    shown: list[GraspRow] = []

    def update(facts: Facts) -> None:
        made = grasp_rows(facts.grasps)
        if made != shown:
            shown[:] = made
            rows.clear()
            with rows:
                for row in made:
                    _draw_grasp(row, is_best=row.score == made[0].score)
            others = len(facts.grasps) - len(made)
            more.set_text(f"and {others} more with lower scores" if others > 0 else "")

    return update


def grasp_rows(grasps: Sequence[tuple[str, float]]) -> list[GraspRow]:
    """Return the rows of the best grasps."""
    return [GraspRow(name, share(score, 3), min(max(score, 0.0), 1.0)) for name, score in grasps[:_MOST_GRASPS]]


def _draw_grasp(row: GraspRow, *, is_best: bool) -> None:
    line = ui.row().classes("w-full items-center gap-2 no-wrap").props("role=listitem")
    line.props["aria-label"] = f"{row.name} {row.score}"
    with line:
        ui.label(row.name).classes("w-28 truncate text-sm" + (" font-bold" if is_best else ""))
        with ui.element("div").classes("grow rounded").style("height: 0.6rem; background: rgba(128, 128, 128, 0.25)"):
            ui.element("div").classes("rounded h-full").style(
                f"width: {100.0 * row.share:.1f}%; background: {'#0072b2' if is_best else '#8c8c8c'}"
            )
        ui.label(row.score).classes("w-14 text-sm text-right")


def belief_panel() -> Update:
    """Draw the panel of the belief, and of whether the object is there at all where the scenario considers it."""
    with panel("Where the object lies"):
        absent = ui.label().classes("text-sm font-medium")
        absent.set_visibility(False)
        chart = ui.echart({}).classes("w-full").props('role="img" aria-label="Probability of each pose"')

    def update(facts: Facts) -> None:
        options = belief_chart(facts.session.poses, facts.moment.belief)
        if chart.options != options:
            chart.style(f"height: {belief_chart_height(len(facts.session.poses))}px")
            chart.options.clear()
            chart.options.update(options)
        absent.set_visibility(facts.moment.absent is not None)
        absent.set_text("" if facts.moment.absent is None else absence_sentence(facts.moment.absent))

    return update


def absence_sentence(absent: float) -> str:
    """Write whether the object is there at all."""
    if absent < 0.5:
        return f"Probability that it is not there at all: {share(absent, 3)}. The bars hold if it is."
    return f"It is probably not there at all: probability {share(absent, 3)}. The bars hold if it is."


def update_panel() -> Update:
    """Draw the panel of the last update and of its reason."""
    with panel("Last update"):
        cause = ui.label().classes("text-sm").props("aria-live=polite")
        when = ui.label().classes("text-xs opacity-70")
        refusals = ui.label().classes("text-sm text-negative")

    def update(facts: Facts) -> None:
        entry = facts.entry
        cause.set_text("" if entry is None else cause_of(entry))
        when.set_text("" if entry is None else f"version {entry.version}, {entry.at:%Y-%m-%d %H:%M:%S} UTC")
        refused = "" if facts.moment.is_past else " ".join(filter(None, map(look_refusal, facts.robots)))
        refusals.set_text(refused)
        refusals.set_visibility(bool(refused))

    return update


def look_refusal(robot: RobotReport) -> str:
    """Write that a robot's newest look was not accepted, and why; empty if it was, or there is none."""
    look = robot.last_look
    if look is None or look.accepted:
        return ""
    reason = REASONS.get(look.reason or "", look.reason or "the service did not state why")
    return f"The newest look of {robot.robot} was not accepted: {reason}."
