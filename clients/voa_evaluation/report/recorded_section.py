"""The section of the page about a recorded experiment: what looks were worth with scans that were measured."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from voa_client.formatting import signed, unsigned
from voa_evaluation.statistics import rank_correlation
from voa_fleet.show.page import Section, items, paragraph, picture, table
from voa_fleet.world.frames import Floats


def recorded_section(report: Mapping[str, Any], file: Path) -> Section:
    """A recorded experiment: VOA against AECD per rule."""
    rules: dict[str, dict[str, Any]] = report["rules"]
    rows = [
        [
            *(rule, sensor, signed(found["voa"], 4), _number(found["aecd"])),
            "-" if found["aecd"] is None else signed(found["aecd"] - found["voa"], 4),
            f"{len(found['beliefs'])}/{len(report['poses'])}",
        ]
        for rule, sensors in rules.items()
        for sensor, found in sensors.items()
    ]
    header = ("rule", "from", "VOA", "AECD", "AECD less VOA", "poses measured")
    before = report["before"]
    return Section(
        "recorded",
        "VOA against what the measured scans were worth",
        (
            paragraph(
                f"{len(report['poses'])} poses, all equally likely beforehand. The best grasp then is "
                f"{before['best_grasp'] or 'none'}, with an expected score of {before['expected_score']:.3f}. VOA is "
                "the rise of the expected score over predicted scans, AECD the rise over the scans that were really "
                "measured, one per pose. Where a pose was not measured from a place, AECD is not defined "
                "and stands as a dash."
            ),
            picture(file, "VOA against AECD; on the dashed line the prediction was right."),
            table("Per rule and sensor configuration", header, rows),
            items([_recorded_words(rule, sensors) for rule, sensors in rules.items()]),
        ),
    )


def _number(value: float | None) -> str:
    return "-" if value is None else signed(value, 4)


def _recorded_words(rule: str, sensors: Mapping[str, Mapping[str, float | None]]) -> str:
    both = [(found["voa"], found["aecd"]) for found in sensors.values()]
    pairs = [(voa, aecd) for voa, aecd in both if voa is not None and aecd is not None]
    if not pairs:
        return f"{rule}: no place was measured at every pose."
    apart = max(abs(voa - aecd) for voa, aecd in pairs)
    tau = rank_correlation(_column(pairs, 0), _column(pairs, 1))
    ranked = "the order of places is undefined" if tau is None else f"Kendall's tau {signed(tau, 2)}"
    measured = f"over {len(pairs)} of {len(sensors)} places"
    return f"{rule}: {measured} VOA and AECD differ by {unsigned(apart, 4)} at most; {ranked}."


def _column(pairs: Sequence[tuple[float, float]], index: int) -> Floats:
    # What differs by a rounding error is a tie.
    return np.array([round(pair[index], 12) for pair in pairs], dtype=np.float64)
