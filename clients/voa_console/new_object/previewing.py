"""Previews of a draft that are kept up to date: rests, then the plan, then the outlines in the scan plane."""

from dataclasses import dataclass, field

from voa_console.new_object.draft import Draft, problems_of
from voa_console.new_object.messages import Step
from voa_setup.previews.messages import MeshMeasure, Outlines, Plan, RestsPreview

Key = tuple[object, ...]
_ORDER: tuple[Step, ...] = ("rests", "plan", "outlines")
WORDS: dict[Step, str] = {
    "measure": "reading the mesh",
    "rests": "computing how the object can rest",
    "plan": "placing the lidar",
    "outlines": "cutting the object by the scan plane",
}
"""Words for each task while it is under way."""
SECONDS: dict[Step, float] = {"measure": 60.0, "rests": 180.0, "plan": 300.0, "outlines": 180.0}
"""Most time for each task: the first of a kind also compiles functions, once for each machine."""


@dataclass
class Previews:
    """Results for a draft so far, each with the choices that it depends on.

    Attributes:
        measure: of the mesh file.
        rests: of the mesh; None: not known yet.
        plan: poses and places; None: not known yet.
        outlines: in the scan plane; None: not known yet.
        problems: sentences by task, for those that could not be done.
    """

    measure: MeshMeasure | None = None
    rests: RestsPreview | None = None
    plan: Plan | None = None
    outlines: Outlines | None = None
    problems: dict[Step, str] = field(default_factory=dict)
    _keys: dict[Step, Key] = field(default_factory=dict)

    def next_step(self, draft: Draft) -> Step | None:
        """Return the first task whose result does not belong to the draft; None: all do, or cannot be computed."""
        if not draft.confirmed or problems_of(draft):
            return None
        for step in _ORDER:
            if self._keys.get(step) != self.key(step, draft):
                return step
            if step in self.problems or (step == "plan" and self.height_of(draft) is None):
                return None
        return None

    def key(self, step: Step, draft: Draft) -> Key:
        """Return the choices on which the result of a task depends."""
        rests: Key = (draft.mesh, draft.scale, draft.up)
        if step == "rests":
            return rests
        poses = (*rests, draft.rests, draft.yaws)
        if step == "outlines":
            return (*rests, draft.rests, self.height_of(draft))
        return (
            *poses,
            draft.places,
            draft.radius_m,
            draft.bearings_deg,
            draft.height_m,
            draft.lidar,
            draft.xy_m,
        )

    def height_of(self, draft: Draft) -> float | None:
        """Return the height of the scan plane, metres: the chosen height or the suggestion; None: not known."""
        if draft.height_m is not None:
            return draft.height_m
        plan = self.plan
        return None if plan is None or plan.suggested is None else plan.suggested.height_m

    def keep(self, step: Step, draft: Draft, result: str) -> None:
        """Keep the result of a task, as JSON, for the draft that it was computed for."""
        self.problems.pop(step, None)
        self._keys[step] = self.key(step, draft)
        match step:
            case "measure":
                self.measure = MeshMeasure.model_validate_json(result)
            case "rests":
                self.rests, self.plan, self.outlines = RestsPreview.model_validate_json(result), None, None
            case "plan":
                self.plan = Plan.model_validate_json(result)
            case "outlines":
                self.outlines = Outlines.model_validate_json(result)
            case "make":
                raise ValueError("expected the result of a preview")

    def fail(self, step: Step, draft: Draft, sentence: str) -> None:
        """Keep the reason why a task cannot be done for a draft, which is not tried again until it changes."""
        self.problems[step] = sentence
        self._keys[step] = self.key(step, draft)

    def is_current(self, step: Step, draft: Draft) -> bool:
        """True if the kept result of a task belongs to the draft."""
        return self._keys.get(step) == self.key(step, draft) and step not in self.problems
