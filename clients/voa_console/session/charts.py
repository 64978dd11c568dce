"""Options of the charts of a session, for ECharts: the belief as bars, and entropy and score over the versions."""

from collections.abc import Sequence
from typing import Any

from voa_client.formatting import share
from voa_msgs.sessions import HistoryEntry
from voa_scene.colours import BLUE, GREY, ORANGE, VERMILION

Options = dict[str, Any]
MOST_BARS = 12
"""Most poses of the chart of the belief: the likeliest; the others are summed up."""
MOST_POINTS = 500
"""Most versions of the chart of the history."""
_BAR_PX = 22
_TEXT = "#808080"
"""Colour of axes that is read on light and dark backgrounds."""
_FAINT = "rgba(128, 128, 128, 0.3)"


def belief_chart(poses: Sequence[str], belief: Sequence[float]) -> Options:
    """Make bars of the likeliest poses, the likeliest on top in orange, and the sum of the others.

    Args:
        poses: names.
        belief: probability of each pose, in the order of `poses`.
    """
    ordered = sorted(zip(poses, belief, strict=True), key=lambda pair: -pair[1])
    shown, others = ordered[:MOST_BARS], ordered[MOST_BARS:]
    rows = [
        (name, held, (ORANGE if index == 0 else GREY).hex, share(held, 3)) for index, (name, held) in enumerate(shown)
    ]
    if others:
        rest = sum(held for _, held in others)
        rows.append((f"{len(others)} others", rest, "#d0d0d0", share(rest, 3)))
    return {
        "animation": False,
        "grid": {"left": 8, "right": 56, "top": 4, "bottom": 4, "containLabel": True},
        "xAxis": {
            "type": "value",
            "min": 0,
            "max": 1,
            "show": False,
            "axisLabel": {"show": False},
        },
        "yAxis": {
            "type": "category",
            "inverse": True,
            "data": [row[0] for row in rows],
            "axisTick": {"show": False},
            "axisLine": {"show": False},
            "axisLabel": {"color": _TEXT, "width": 110, "overflow": "truncate"},
        },
        "series": [
            {
                "type": "bar",
                "barMaxWidth": 14,
                "data": [
                    {
                        "value": held,
                        "itemStyle": {"color": colour},
                        "label": {"show": True, "position": "right", "formatter": text, "color": _TEXT},
                    }
                    for _, held, colour, text in rows
                ],
            }
        ],
    }


def belief_chart_height(poses: int) -> int:
    """Height of the chart of the belief for a number of poses, pixels."""
    return 12 + _BAR_PX * min(poses, MOST_BARS + 1)


def thinned(history: Sequence[HistoryEntry], most: int = MOST_POINTS) -> list[HistoryEntry]:
    """Return at most so many versions of a history, evenly spread, with the first and the last."""
    if len(history) <= most:
        return list(history)
    return [history[index * (len(history) - 1) // (most - 1)] for index in range(most)]


def time_chart(history: Sequence[HistoryEntry], version: int) -> Options:
    """Make lines of the expected score and of the entropy over the versions, with a mark at the version shown.

    Args:
        history: with beliefs, in ascending order.
        version: that is shown.
    """
    points = thinned(history)
    return {
        "animation": False,
        "tooltip": {"trigger": "axis"},
        "legend": {"top": 0, "textStyle": {"color": _TEXT}},
        "grid": {"left": 8, "right": 8, "top": 34, "bottom": 4, "containLabel": True},
        "xAxis": {
            "type": "value",
            "min": history[0].version if history else 0,
            "max": max(history[-1].version, 1) if history else 1,
            "minInterval": 1,
            "axisLabel": {"color": _TEXT},
            "splitLine": {"show": False},
        },
        "yAxis": [
            {"type": "value", "min": 0, "max": 1, "name": "score", **_axis()},
            {"type": "value", "min": 0, "name": "nats", **_axis(), "splitLine": {"show": False}},
        ],
        "series": [
            _line("Expected score", [[each.version, each.expected_score] for each in points], BLUE.hex, 0)
            | {
                "markLine": {
                    "silent": True,
                    "symbol": "none",
                    "label": {"show": False},
                    "lineStyle": {"color": VERMILION.hex, "width": 2},
                    "data": [{"xAxis": version}],
                }
            },
            _line("Entropy", [[each.version, each.entropy_nats] for each in points], ORANGE.hex, 1)
            | {"lineStyle": {"type": "dashed"}, "symbol": "rect"},
        ],
    }


def _axis() -> Options:
    return {
        "axisLabel": {"color": _TEXT},
        "nameTextStyle": {"color": _TEXT},
        "splitLine": {"lineStyle": {"color": _FAINT}},
    }


def _line(name: str, data: list[list[Any]], colour: str, axis: int) -> Options:
    return {
        "type": "line",
        "name": name,
        "data": data,
        "yAxisIndex": axis,
        "symbolSize": 7,
        "itemStyle": {"color": colour},
    }
