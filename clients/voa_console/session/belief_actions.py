"""Actions that change the belief: reporting the outcome of a grasp, and resetting the belief to the prior."""

from nicegui import ui

from voa_console.session.action_context import ActionContext
from voa_console.session.words import cause_of
from voa_msgs.sessions import BeliefRequest, HistoryEntry, OutcomeRequest


def report_outcome(context: ActionContext) -> None:
    """Open the dialog that reports the outcome of a grasp."""
    facts = context.facts()

    async def act(seen: int) -> str:
        request = OutcomeRequest(
            grasp=str(grasp.value), success=result.value == "succeeded", object_moved=float(moved.value or 0.0)
        )
        session = await context.console.client.report_outcome(context.session_id, request, if_match=seen)
        entry = HistoryEntry(
            version=session.version or 0,
            kind="outcome",
            at=session.updated_at,
            request=request.model_dump(mode="json"),
            update=session.update,
        )
        return cause_of(entry)

    dialog = context.dialog("Report the outcome of a grasp", "Report outcome", act)
    if dialog is None or facts is None:
        return
    names = [each.name for each in facts.scenario.grasps]
    with dialog.content:
        grasp = ui.select(names, value=facts.moment.best_grasp or names[0], label="Grasp").classes("w-full")
        result = ui.radio(["succeeded", "failed"], value="succeeded").props('inline aria-label="Result"')
        moved = ui.number("Probability that the object was moved", value=0.0, min=0.0, max=1.0, step=0.1)
        moved.classes("w-full")
        ui.label("Above 0, the prior is mixed into the belief, and earlier looks no longer count.").classes("text-sm")
    dialog.open()


def reset_belief(context: ActionContext) -> None:
    """Open the dialog that resets the belief to the prior."""

    async def act(seen: int) -> str:
        session = await context.console.client.put_belief(context.session_id, BeliefRequest(belief=None), if_match=seen)
        return f"The belief is the prior again (version {session.version})."

    dialog = context.dialog("Reset the belief", "Reset belief", act, danger=True)
    if dialog is None:
        return
    with dialog.content:
        ui.label(
            "The belief becomes the prior again, and earlier looks and outcomes "
            "no longer count. The history keeps them."
        )
    dialog.open()
