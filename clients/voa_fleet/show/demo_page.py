"""The page that the demo leaves: what happened, with pictures, in one HTML file."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from voa_fleet.episodes.comparison import Comparison, Tally
from voa_fleet.episodes.episode import MOST_LOOKS, LookChosen, Event, Episode
from voa_fleet.show.page import Section, lines, page, paragraph, picture, table
from voa_fleet.show.render import Frame, write_picture
from voa_fleet.show.episode_pictures import belief_by_look, comparison_bars, view_from_above
from voa_fleet.show.live_report import event_line
from voa_fleet.world.objects import FleetObject
from voa_msgs.rankings import Ranking

PAGE = "demo.html"
_LABELS = {"none": "without a look", "voa": "with looks by VOA"}
_NEXT = (
    "voa demo --object mug      # whose looks gain less",
    "voa fleet --pairs 4",
    "voa fleet --object block --policy random",
    "voa evaluate --help",
    "voa serve",
)


@dataclass
class Demo:
    """The course of a demo so far, which becomes its page.

    Attributes:
        lines: as they were told.
        rankings: that the service gave on the way.
        frames: of the scene, with what they show; none without OpenGL.
        no_frames: why there are none.
        paper: the picture of the paper's scene.
    """

    target: FleetObject
    seed: int
    lines: list[str] = field(default_factory=list)
    rankings: list[Ranking] = field(default_factory=list)
    frames: list[tuple[Frame, str]] = field(default_factory=list)
    no_frames: str | None = None
    episode: Episode | None = None
    truth: str = ""
    most_looks: int = MOST_LOOKS
    comparison: Comparison = field(default_factory=Comparison)
    paper: Path | None = None

    def hear(self, event: Event) -> None:
        """Keep what the page needs."""
        self.lines.append(f"{event.at_s:6.1f} s  {event_line(event.what)}")
        if isinstance(event.what, LookChosen) and event.what.ranking is not None:
            self.rankings.append(event.what.ranking)

    @property
    def tallies(self) -> list[Tally]:
        """Of the comparison; empty if no drop was played."""
        tallies = list(self.comparison.tallies.values())
        return tallies if all(tally.attempts for tally in tallies) else []


def outcome_summary(demo: Demo, episode: Episode) -> str:
    """Say how the object lay, and what became of the grasp."""
    rests = [name for name, rest in demo.target.physics.rests.items() if demo.truth in rest.poses]
    about = [grasp.data for grasp in demo.target.scenario.grasps if grasp.name == episode.grasp]
    approach = about[0].get("approach") if about and isinstance(about[0], dict) else None
    how = "" if approach is None else f" ({approach})"
    lay = f"In truth the {demo.target.name} was at {demo.truth} ({', '.join(rests)})."
    if episode.outcome is None:
        return f"{lay} No grasp was tried."
    ended = "succeeded" if episode.success else f"failed ({episode.outcome.detail}): such targets happen, see below"
    return f"{lay} {episode.grasp}{how} {ended}."


def comparison_rows(tallies: Sequence[Tally]) -> list[tuple[str, ...]]:
    """Count the same drops, a row per policy, below `COMPARISON_COLUMNS`."""
    return [
        (
            _LABELS[tally.policy],
            f"{tally.successes} of {tally.attempts}",
            "{:.0%} to {:.0%}".format(*tally.interval),
            f"{tally.looks / tally.attempts:.1f}",
            f"{tally.expected / tally.attempts:.0%}",
        )
        for tally in tallies
    ]


COMPARISON_COLUMNS = ("", "lifted", "95 % interval", "looks per drop", "expected")


def comparison_summary(demo: Demo) -> str:
    """Say what the counts are of, in a sentence or two."""
    without, with_looks = demo.tallies
    drops = "Drop 1" if without.attempts == 1 else f"Drops 1 to {without.attempts}"
    return (
        f"{drops} of seed {demo.seed}, the same for both, grasped in physics: without a look "
        f"{without.attempts - without.successes} of {without.attempts} grasps failed, with up to {demo.most_looks} "
        f"looks {with_looks.attempts - with_looks.successes} of {with_looks.attempts}. Noise and lost "
        "beams as those of an LDS-01; the object lies 5 mm and 0.05 rad (std) beside its pose."
    )


def write_demo(demo: Demo, out: Path) -> Path:
    """Draw the pictures and write the page of what there is; returns the page."""
    sections = [
        *([] if not demo.lines else [_happened(demo, out)]),
        *([_contrast(demo, out)] if demo.tallies else []),
        *([] if demo.paper is None else [_paper(demo.paper)]),
        Section("next", "Go on", (paragraph("Commands to try next:"), lines(_NEXT))),
    ]
    file = out / PAGE
    file.write_text(page("Value of Assistance: a look before the grasp", (), sections), encoding="utf-8")
    return file


def _happened(demo: Demo, out: Path) -> Section:
    """The episode as it was told, with its pictures; only what was told of one that was ended early."""
    if demo.episode is None:
        return Section("happened", "What happened until it was ended", (lines(demo.lines),))
    belief, above = out / "belief.png", out / "from-above.png"
    belief_by_look(belief, demo.episode, demo.rankings, demo.truth)
    view_from_above(above, demo.target, demo.truth, demo.episode)
    pictures = [
        picture(belief, "Above: the belief, the true pose in orange. Below: what a look from each place was worth."),
        picture(above, "What the lidar saw, look by look, over the object as it lay."),
    ]
    for index, (frame, caption) in enumerate(demo.frames):
        scene = out / f"scene-{index}.png"
        write_picture(scene, frame)
        pictures.append(picture(scene, caption))
    text = paragraph(
        f"A {demo.target.name} lay in one of {len(demo.episode.before.poses)} poses, and nobody knew in which. "
        f"Drop 0 of seed {demo.seed}. {outcome_summary(demo, demo.episode)}"
    )
    missing = [] if demo.no_frames is None else [paragraph(f"No pictures of the scene: {demo.no_frames}")]
    return Section("happened", "What happened", (text, *missing, lines(demo.lines), *pictures))


def _contrast(demo: Demo, out: Path) -> Section:
    bars = out / "comparison.png"
    comparison_bars(bars, demo.tallies, [_LABELS[tally.policy] for tally in demo.tallies])
    counts = table(
        "Wilson's intervals; expected: by the service, of the grasps that were tried",
        COMPARISON_COLUMNS,
        comparison_rows(demo.tallies),
    )
    shown = picture(bars, "Counts of drops in which the object was lifted.")
    return Section(
        "comparison", "The same drops without a look, and with", (paragraph(comparison_summary(demo)), counts, shown)
    )


def _paper(file: Path) -> Section:
    about = "A mug, with the grasp scores measured in the paper: one look makes another grasp the best one."
    shown = picture(file, "Weighted grasp scores before and after one look (Fig. 3).")
    return Section("paper", "The paper's example", (paragraph(about), shown))
