"""The HTML page that the demo leaves: its events, pictures and counts."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from voa_client.formatting import with_article
from voa_fleet.episodes.comparison import Comparison, Tally
from voa_fleet.episodes.episode import MOST_LOOKS, Episode
from voa_fleet.episodes.events import Event, LookChosen
from voa_fleet.show.episode_pictures import belief_by_look, comparison_bars, view_from_above
from voa_fleet.show.event_lines import event_line
from voa_fleet.show.page import Block, Lines, Paragraph, Picture, Section, Table, write_page
from voa_fleet.show.render import Frame, write_picture
from voa_fleet.world.objects import FleetObject
from voa_msgs.rankings import Ranking

PAGE = "demo.html"
_LABELS = {"none": "without a look", "voa": "with looks by VOA"}
_NEXT = (
    "voa demo --object goblet    # the look for most information is not the best",
    "voa demo --object coupling  # two looks are needed",
    "voa demo --object mug       # looks gain less",
    "voa fleet --pairs 4",
    "voa fleet --object block --policy random",
    "voa evaluate --help",
    "voa serve",
)


@dataclass
class Demo:
    """Course of a demo, from which its page is written.

    Attributes:
        target: the object.
        seed: of drops and noise.
        lines: events of the first episode as text.
        rankings: that the service gave in it.
        frames: pictures of the scene with their captions; empty without OpenGL.
        no_frames: reason why there are none.
        episode: result of the first episode; None: it was ended early.
        truth: true pose of the object in it.
        most_looks: in an episode.
        comparison: counts of the drops with looks and without.
        paper: picture of the paper's example; None: it was not drawn.
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

    def record(self, event: Event) -> None:
        """Keep an event of the first episode for the page."""
        self.lines.append(f"{event.at_s:6.1f} s  {event_line(event.step)}")
        if isinstance(event.step, LookChosen) and event.step.ranking is not None:
            self.rankings.append(event.step.ranking)

    @property
    def tallies(self) -> list[Tally]:
        """Counts per policy; empty if no drop was completed."""
        tallies = list(self.comparison.tallies.values())
        return tallies if all(tally.attempts for tally in tallies) else []


def story_of(target: FleetObject) -> str:
    """Return the first paragraph of the README.md in an object's folder, on one line; "" where there is none.

    For the project's own objects it says what about the object makes looks worth taking.
    """
    file = target.folder / "README.md"
    if not file.is_file():
        return ""
    paragraphs = file.read_text(encoding="utf-8", errors="replace").split("\n\n")
    texts = (" ".join(paragraph.split()) for paragraph in paragraphs if not paragraph.lstrip().startswith("#"))
    return next((text for text in texts if text), "")


def outcome_summary(demo: Demo, episode: Episode) -> str:
    """Describe in plain words how the object lay, and how the grasp ended."""
    rests = [name for name, rest in demo.target.physics.rests.items() if demo.truth in rest.poses]
    data = [grasp.data for grasp in demo.target.scenario.grasps if grasp.name == episode.grasp]
    words = data[0].get("description") if data and isinstance(data[0], dict) else None
    description = f" ({words})" if isinstance(words, str) else ""
    lay = f"The true pose of the {demo.target.name} was {demo.truth} ({', '.join(rests)})."
    if episode.outcome is None:
        return f"{lay} No grasp was attempted."
    if episode.success:
        return f"{lay} {episode.grasp}{description} succeeded."
    return f"{lay} {episode.grasp}{description} failed ({episode.outcome.detail}). The counts below show how often."


def comparison_rows(tallies: Sequence[Tally]) -> list[tuple[str, ...]]:
    """Make a row of figures per policy, to stand below `COMPARISON_COLUMNS`."""
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
    """Describe in two sentences the drops that were counted, and the result."""
    without, with_looks = demo.tallies
    drops = "Drop 1" if without.attempts == 1 else f"Drops 1 to {without.attempts}"
    return (
        f"{drops} of seed {demo.seed}, each grasped twice in simulation, once without a look and once after up to "
        f"{demo.most_looks} looks. Without a look {without.attempts - without.successes} of {without.attempts} grasps "
        f"failed, with looks {with_looks.attempts - with_looks.successes} of {with_looks.attempts}. Range noise and "
        "lost beams are those of an LDS-01; the object lies 5 mm and 0.05 rad (standard deviations) off its pose."
    )


def write_demo(demo: Demo, out: Path) -> Path:
    """Draw the pictures and write the page of all that the demo has recorded; return the page's path."""
    sections = [
        *([_first_episode(demo, out)] if demo.lines else []),
        *([_comparison(demo, out)] if demo.tallies else []),
        *([] if demo.paper is None else [_paper(demo.paper)]),
        Section("next", "Next steps", (Paragraph("Commands to try next:"), Lines(_NEXT))),
    ]
    file = out / PAGE
    write_page(file, "Value of Assistance: a look before the grasp", (), sections)
    return file


def _first_episode(demo: Demo, out: Path) -> Section:
    """The first episode with its pictures; of one that was ended early the events alone."""
    if demo.episode is None:
        return Section("happened", "What happened until the demo was ended", (Lines(demo.lines),))
    belief, above = out / "belief.png", out / "from-above.png"
    belief_by_look(belief, demo.episode, demo.rankings, demo.truth)
    view_from_above(above, demo.target, demo.truth, demo.episode)
    pictures = [
        Picture(belief, "Above: the belief, the true pose in orange. Below: the VOA of a look from each place."),
        Picture(above, "The lidar's returns, look by look, over the object as it lay."),
    ]
    for index, (frame, caption) in enumerate(demo.frames):
        scene = out / f"scene-{index}.png"
        write_picture(scene, frame)
        pictures.append(Picture(scene, caption))
    texts = [story_of(demo.target)] if story_of(demo.target) else []
    texts.append(
        f"{with_article(demo.target.name)} lay in one of {len(demo.episode.before.poses)} poses, and the robots did "
        f"not know in which. Drop 0 of seed {demo.seed}. {outcome_summary(demo, demo.episode)}"
    )
    missing: list[Block] = []
    if demo.no_frames is not None:
        missing.append(Paragraph(f"There are no pictures of the scene: {demo.no_frames}"))
    return Section("happened", "What happened", (*map(Paragraph, texts), *missing, Lines(demo.lines), *pictures))


def _comparison(demo: Demo, out: Path) -> Section:
    bars = out / "comparison.png"
    comparison_bars(bars, demo.tallies, [_LABELS[tally.policy] for tally in demo.tallies])
    counts = Table(
        "Wilson's intervals; expected: success probability of the attempted grasps, as the service expected it",
        COMPARISON_COLUMNS,
        comparison_rows(demo.tallies),
    )
    picture = Picture(bars, "Counts of drops in which the object was lifted.")
    return Section(
        "comparison",
        "The same drops without a look, and with looks",
        (Paragraph(comparison_summary(demo)), counts, picture),
    )


def _paper(file: Path) -> Section:
    text = "A mug, with the grasp scores measured in the paper: after one look another grasp is the best one."
    picture = Picture(file, "Weighted grasp scores before and after one look (Fig. 3).")
    return Section("paper", "The paper's example", (Paragraph(text), picture))
