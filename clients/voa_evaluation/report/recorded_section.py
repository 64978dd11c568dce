"""Section of the page about a recorded experiment: VOA against the value of the measured scans."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from voa_client.formatting import signed, unsigned
from voa_evaluation.statistics import rank_correlation
from voa_fleet.show.page import Items, Paragraph, Picture, Section, Table
from voa_fleet.world.frames import Floats
from voa_recordings.replay.experiment_report import ExperimentReport, LookValue


def recorded_section(report: ExperimentReport, file: Path) -> Section:
    """Write the section: VOA and AECD per update rule and sensor configuration, and the picture `file` of them."""
    rows = [
        [
            *(rule, sensor, signed(look.voa, 4), _number(look.aecd)),
            "-" if look.aecd is None else signed(look.aecd - look.voa, 4),
            f"{len(look.beliefs)}/{len(report.poses)}",
        ]
        for rule, sensors in report.rules.items()
        for sensor, look in sensors.items()
    ]
    header = ("rule", "from", "VOA", "AECD", "AECD less VOA", "poses measured")
    before = report.before
    return Section(
        "recorded",
        "VOA against the value of the measured scans",
        (
            Paragraph(
                f"{len(report.poses)} poses, all equally likely beforehand. The best grasp then is "
                f"{before.best_grasp or 'none'}, with an expected score of {before.expected_score:.3f}. VOA is "
                "the rise of the expected score over predicted scans, AECD the rise over the scans that were "
                "measured, one per pose. A dash marks an undefined AECD: not every pose was measured from that "
                "place."
            ),
            Picture(file, "VOA against AECD; on the dashed line both are equal."),
            Table("Per rule and sensor configuration", header, rows),
            Items([_recorded_words(rule, sensors) for rule, sensors in report.rules.items()]),
        ),
    )


def _number(value: float | None) -> str:
    return "-" if value is None else signed(value, 4)


def _recorded_words(rule: str, sensors: Mapping[str, LookValue]) -> str:
    pairs = [(look.voa, look.aecd) for look in sensors.values() if look.aecd is not None]
    if not pairs:
        return f"{rule}: no place was measured at every pose."
    apart = max(abs(voa - aecd) for voa, aecd in pairs)
    tau = rank_correlation(_column(pairs, 0), _column(pairs, 1))
    ranked = "the order of places is undefined" if tau is None else f"Kendall's tau {signed(tau, 2)}"
    measured = f"over {len(pairs)} of {len(sensors)} places"
    return f"{rule}: {measured} VOA and AECD differ by {unsigned(apart, 4)} at most; {ranked}."


def _column(pairs: Sequence[tuple[float, float]], index: int) -> Floats:
    # Values that differ by a rounding error tie.
    return np.array([round(pair[index], 12) for pair in pairs], dtype=np.float64)
