"""Pictures of how costs grow with the sizes of a problem, beside the exponents that are derived: `--plots`.

Each panel times one step over some sizes and fits a straight line to the logarithms; its slope is the measured
exponent. Fixed costs make it smaller than the derived exponent, a cache that overflows makes it larger.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from rich.console import Console

from tests.benchmarks import scene
from tests.benchmarks.growth import ranking, scan_update
from tests.benchmarks.history import PICTURE
from tests.benchmarks.measure import Call, interleaved
from voa_core.displaced_scans import predict_copies
from voa_core.displacements import Spread, covariances, scaled, standard_normal_points
from voa_core.lidars import BeamGrid
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.weights import Weigher

PLOTS = PICTURE.with_name("speed-growth.svg")
_COLUMNS = 3
_INK, _MEASURED = "#444444", "#0072B2"


@dataclass(frozen=True)
class Law:
    """Growth of a step with one size of the problem.

    Attributes:
        step: that is timed.
        over: name of the size.
        sizes: at which it is timed, in ascending order.
        exponent: that is derived.
        work: makes the call to time for a size.
    """

    step: str
    over: str
    sizes: Sequence[int]
    exponent: float
    work: Callable[[int], Call]


def laws() -> list[Law]:
    """Return the laws, the costs of seldom steps first."""
    return [
        Law("prediction, 100 poses, 8 places", "faces", _faces(), 0.5, _prediction),
        Law("displaced copies, 100 poses", "displacements", (16, 32, 64, 128, 256), 1.0, _copies),
        Law("weights of a place", "poses", (125, 250, 500, 1000, 2000), 2.0, _weights_of_poses),
        Law("weights of a place, 500 poses", "beams", (90, 180, 360, 720, 1440), 1.0, _weights_of_beams),
        Law("scan update", "poses", (125, 250, 500, 1000, 2000), 1.0, scan_update),
        Law("ranking of 4 places", "poses", (125, 250, 500, 1000, 2000), 2.0, partial(ranking, k=4)),
        Law("ranking, 500 poses", "places", (8, 16, 32, 64), 1.0, partial(ranking, 500)),
        Law("ranking of 4 places, 500 poses", "grasps", (10, 20, 40, 80, 160), 1.0, lambda m: ranking(500, 4, m)),
    ]


def draw(console: Console, path: Path = PLOTS) -> None:
    """Time every law, print its exponents, and draw all as SVG."""
    chosen = laws()
    with rc_context({"svg.hashsalt": "voa", "font.size": 8}):
        figure = Figure(figsize=(9.0, 2.6 * -(-len(chosen) // _COLUMNS)), layout="constrained")
        FigureCanvasAgg(figure)
        for index, law in enumerate(chosen):
            with console.status(f"{law.step} over {law.over}"):
                seconds = interleaved([law.work(size) for size in law.sizes])
            slope = measured_exponent(law.sizes, seconds)
            console.print(
                f"{law.step} over {law.over}: exponent {slope:.2f}, derived {law.exponent:g}", highlight=False
            )
            _panel(figure.add_subplot(-(-len(chosen) // _COLUMNS), _COLUMNS, index + 1), law, seconds, slope)
        figure.savefig(path, format="svg", metadata={"Date": None})


def measured_exponent(sizes: Sequence[int], seconds: Sequence[float]) -> float:
    """Slope of the straight line that fits the logarithms of the times over those of the sizes best."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def _panel(axes: Axes, law: Law, seconds: Sequence[float], slope: float) -> None:
    sizes, milliseconds = np.array(law.sizes, dtype=np.float64), 1e3 * np.array(seconds)
    derived = milliseconds[-1] * (sizes / sizes[-1]) ** law.exponent
    axes.plot(sizes, derived, "--", color=_INK, linewidth=1.0, label=f"derived: {law.exponent:g}")
    axes.plot(sizes, milliseconds, "o-", color=_MEASURED, label=f"measured: {slope:.2f}")
    axes.set(title=law.step, xlabel=law.over, ylabel="ms CPU", xscale="log", yscale="log")
    axes.set_xticks(sizes, [f"{size:g}" if size < 1000 else f"{size / 1000:.3g}k" for size in law.sizes], minor=False)
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)


def _faces() -> list[int]:
    return [len(scene.cup(size).faces) for size in scene.SIZES]


def _prediction(faces: int) -> Call:
    size = scene.SIZES[_faces().index(faces)]
    object_ = scene.cup(size)
    _ = object_.edges  # made once per mesh
    poses, sensors = scene.poses(object_, 100, planar=False), scene.sensors(8)

    def predict() -> None:
        predictor = predictor_of_mesh(object_, poses, scene.LIDAR)
        for sensor in sensors:
            predictor.predict(sensor)

    return predict


def _copies(count: int) -> Call:
    object_ = scene.cup("10k")
    poses, [sensor] = scene.poses(object_, 100, planar=True), scene.sensors(1)
    predictor = predictor_of_mesh(object_, poses, scene.LIDAR)
    covariance = covariances(poses, sensor, Spread(0.005, np.radians(3.0)), None)
    displacements = scaled(standard_normal_points(count, "plots"), covariance)
    return lambda: predict_copies(predictor, sensor, displacements)


def _weights_of_poses(n: int) -> Call:
    [prediction] = scene.predictions(n, 1)
    rule = rule_of("exponential", scene.LIDAR)
    return lambda: Weigher.of(rule, prediction, np.float64, keep=True)


def _weights_of_beams(beams: int) -> Call:
    lidar = replace(scene.LIDAR, grid=BeamGrid(beams, 0.0, 2.0 * np.pi / beams))
    object_ = scene.cup("10k")
    predictor = predictor_of_mesh(object_, scene.poses(object_, 500, planar=True), lidar)
    prediction, rule = predictor.predict(scene.sensors(1)[0]), rule_of("exponential", lidar)
    return lambda: Weigher.of(rule, prediction, np.float64, keep=True)
