"""Sections of the page about measurements: grasp scores, and errors of predicted scans."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.observation import Errors, ObservationErrors
from voa_fleet.show.page import Block, Folded, Heading, Paragraph, Picture, Section, Table


def grasp_section(scores: Sequence[GraspScores], pictures: Mapping[str, Path]) -> Section:
    """Write the section about grasp scores: a table and a picture per object."""
    blocks: list[Block] = [
        Paragraph(
            "A grasp score is the share of attempts in which a grasp, fixed on the table, lifts the object from a "
            "pose. Every cell below names its successes of its attempts. The object lies a little off its pose each "
            "time, so a good grasp may fail. High scores in different columns for different poses are what make a look "
            "valuable."
        )
    ]
    for each in scores:
        total = sum(cell.successes for row in each.cells for cell in row)
        made = sum(cell.attempts for row in each.cells for cell in row)
        blocks.append(Heading(f"{each.object}: {total} of {made} attempts succeeded"))
        blocks.append(
            Picture(pictures[each.object], f"Grasp scores of the {each.object}: poses in rows, grasps in columns.")
        )
        rows = [[row[0].pose, *(f"{cell.successes}/{cell.attempts}" for cell in row)] for row in each.cells]
        blocks.append(
            Folded("as a table", [Table(f"{each.object}: successes of attempts", ["pose", *each.grasps], rows)])
        )
    return Section("grasp-score", "Grasp scores", tuple(blocks))


def observation_section(errors: Sequence[ObservationErrors], pictures: Mapping[str, Sequence[Path]]) -> Section:
    """Write the section about prediction errors, per object or recorded experiment."""
    blocks: list[Block] = [
        Paragraph(
            "VOA is computed from predicted scans. This section compares measured ranges with predicted ones, beam by "
            "beam: measured minus predicted, in millimetres, over the beams that return in both. Beams that return in "
            "one only are counted separately: at the outline of an object a millimetre decides whether a beam meets it."
        )
    ]
    for compared in errors:
        overall = compared.overall
        title = f"{compared.name}: {overall.beams} beams of {compared.scans} scans return in both"
        blocks.append(Heading(title))
        if overall.median_abs is not None and overall.p95_abs is not None:
            source = "the recorded experiment" if compared.source == "recorded" else "the mesh"
            blocks.append(
                Paragraph(
                    f"Predictions are from {source}. Half of the {overall.beams} beams differ by less than "
                    f"{overall.median_abs:.1f} mm, 95 % by less than {overall.p95_abs:.1f} mm."
                )
            )
        named = [*compared.by_sensor().items(), ("all", overall)]
        header = (
            "from",
            "beams",
            "mean",
            "median",
            "std",
            "min",
            "max",
            "median size",
            "measured only",
            "predicted only",
        )
        blocks.append(Table("Measured minus predicted, mm", header, [[name, *_errors(each)] for name, each in named]))
        captions = ("The differences, a panel per place.", "Measured over predicted points, in the lidar's frame.")
        blocks += [
            Picture(file, f"{compared.name}: {caption}")
            for file, caption in zip(pictures[compared.name], captions, strict=True)
        ]
    return Section("observation", "Observation prediction", tuple(blocks))


def _errors(errors: Errors) -> list[str]:
    figures = (errors.mean, errors.median, errors.std, errors.lowest, errors.highest, errors.median_abs)
    cells = ["-" if figure is None else f"{figure:z.1f}" for figure in figures]
    return [str(errors.beams), *cells, str(errors.only_measured), str(errors.only_predicted)]
