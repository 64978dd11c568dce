"""Section of the page about the sensitivity of looks to disturbances."""

from collections.abc import Mapping
from pathlib import Path

from voa_evaluation.looks.results import Results
from voa_evaluation.looks.sensitivity import DISTURBANCES
from voa_evaluation.statistics import interval_text
from voa_fleet.show.page import Folded, Items, Paragraph, Picture, Section, Table


def sensitivity_section(results: Results, pictures: Mapping[str, Path]) -> Section:
    """Write the section: curves and counts of every disturbance, and the levels at which looks do harm."""
    drops = results.setting.sensitivity_drops
    units = {each.name: each.unit for each in DISTURBANCES}
    rows = [
        [
            *(level.disturbance, f"{level.level:g} {units[level.disturbance]}", "yes" if level.stated else "no"),
            *(level.rule, f"{level.rate.successes}/{level.rate.drops}", f"{level.blind.successes}/{level.blind.drops}"),
            *(interval_text(level.gain), f"{level.not_accepted}/{level.rate.drops}"),
        ]
        for level in results.levels
    ]
    header = ("disturbance", "level", "stated", "rule", "lifted with look", "without", "gain", "fitted no pose")
    return Section(
        "sensitivity",
        "Sensitivity to disturbances",
        (
            Paragraph(
                f"The look that VOA recommends under a uniform belief, at the first {drops} drops of each object "
                f"({drops * len(results.rows.objects)} in all), while one imperfection grows. Where "
                "the robot's pose is uncertain, the robot may state how much, and the service "
                "then averages over the poses at which it may be. Below the dashed line a look does harm."
            ),
            Picture(pictures["sensitivity"], "Success rate against four disturbances, a row per update rule."),
            Items(_sensitivity_words(results)),
            Folded("as a table", [Table("Sensitivity", header, rows)]),
        ),
    )


def _sensitivity_words(results: Results) -> list[str]:
    sentences = []
    for disturbance in DISTURBANCES:
        for rule in results.rows.rules:
            own = [each for each in results.levels if (each.disturbance, each.rule) == (disturbance.name, rule)]
            harms = [each for each in own if each.gain.high < 0.0]
            for stated in (False, True):
                bad = [f"{each.level:g}" for each in harms if each.stated is stated]
                if bad:
                    how = " whose uncertainty is stated" if stated else ""
                    sentences.append(
                        f"Negative: under {rule}, a look{how} does harm at {disturbance.title} of "
                        f"{', '.join(bad)} {disturbance.unit}."
                    )
    sentences += _stating_words(results)
    return sentences or ["No disturbance made a look harmful with an interval that excludes zero."]


def _stating_words(results: Results) -> list[str]:
    sentences = []
    for rule in results.rows.rules:
        pairs = [
            (plain, stated)
            for plain in results.levels
            for stated in results.levels
            if not plain.stated
            and stated.stated
            and (plain.disturbance, plain.level, plain.rule) == (stated.disturbance, stated.level, rule)
            and stated.rule == rule
        ]
        if pairs:
            ours = sum(stated.rate.successes for _, stated in pairs)
            other = sum(plain.rate.successes for plain, _ in pairs)
            total = sum(plain.rate.drops for plain, _ in pairs)
            sentences.append(
                f"{rule}: over all levels of pose error, {ours} of {total} grasps succeeded with the uncertainty "
                f"stated, {other} of {total} without."
            )
    return sentences
