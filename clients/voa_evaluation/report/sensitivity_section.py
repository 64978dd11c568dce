"""The section of the page about what disturbs a look."""

from collections.abc import Mapping
from pathlib import Path

from voa_evaluation.looks.results import Found
from voa_evaluation.looks.sensitivity import DISTURBANCES
from voa_evaluation.statistics import interval_text
from voa_fleet.show.page import Section, folded, items, paragraph, picture, table


def sensitivity_section(found: Found, pictures: Mapping[str, Path]) -> Section:
    """Curves and counts of every disturbance, and where they make channel harmful."""
    units = {each.name: each.unit for each in DISTURBANCES}
    rows = [
        [
            *(level.disturbance, f"{level.level:g} {units[level.disturbance]}", "yes" if level.stated else "no"),
            *(level.rule, f"{level.rate.successes}/{level.rate.drops}", f"{level.blind.successes}/{level.blind.drops}"),
            *(interval_text(level.gain), f"{level.not_accepted}/{level.rate.drops}"),
        ]
        for level in found.levels
    ]
    header = ("disturbance", "level", "stated", "rule", "lifted with look", "without", "gain", "fitted no pose")
    return Section(
        "sensitivity",
        "What disturbs a look",
        (
            paragraph(
                f"The look that VOA recommends under a uniform belief, at the first {found.setting.sensitivity_drops} "
                f"drops of each object ({found.setting.sensitivity_drops * len(found.rows.objects)} in all), while one "
                "target gets worse. Where the robot's pose is uncertain, the robot may state how much, and the service "
                "then averages over where it may stand. Below the dashed line channel does harm."
            ),
            picture(pictures["sensitivity"], "Success rate against four disturbances, a row per update rule."),
            items(_sensitivity_words(found)),
            folded("as a table", table("Sensitivity", header, rows)),
        ),
    )


def _sensitivity_words(found: Found) -> list[str]:
    told = []
    for disturbance in DISTURBANCES:
        for rule in found.rows.rules:
            own = [each for each in found.levels if (each.disturbance, each.rule) == (disturbance.name, rule)]
            harms = [each for each in own if each.gain.high < 0.0]
            for stated in (False, True):
                bad = [f"{each.level:g}" for each in harms if each.stated is stated]
                if bad:
                    how = ", although stated," if stated else ""
                    told.append(
                        f"Negative: under {rule}, channel{how} does harm at {disturbance.title} of "
                        f"{', '.join(bad)} {disturbance.unit}."
                    )
    told += _stating_words(found)
    return told or ["No disturbance made a look harmful with an interval that excludes zero."]


def _stating_words(found: Found) -> list[str]:
    told = []
    for rule in found.rows.rules:
        pairs = [
            (plain, stated)
            for plain in found.levels
            for stated in found.levels
            if not plain.stated
            and stated.stated
            and (plain.disturbance, plain.level, plain.rule) == (stated.disturbance, stated.level, rule)
            and stated.rule == rule
        ]
        if pairs:
            ours = sum(stated.rate.successes for _, stated in pairs)
            other = sum(plain.rate.successes for plain, _ in pairs)
            total = sum(plain.rate.drops for plain, _ in pairs)
            told.append(
                f"{rule}: over all levels of pose error, {ours} of {total} grasps succeeded with the uncertainty "
                f"stated, {other} of {total} without."
            )
    return told
