"""Tables of a replayed experiment, for a person at a terminal."""

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from voa_client.formatting import share, signed
from voa_recordings.replay.experiment_report import ExperimentReport
from voa_recordings.replay.prediction_errors import PredictionErrors
from voa_recordings.selection import describe_selection


def show(console: Console, report: ExperimentReport) -> None:
    """Print the values of looks as a table, the prediction errors, and how the experiment's rows were chosen."""
    before = report.before
    console.print(f"{report.experiment}: {len(report.poses)} poses, uniform belief", style="bold", markup=False)
    console.print(
        f"best grasp before any look: {before.best_grasp or 'none'}, expected score "
        f"{share(before.expected_score, 3)}\n",
        markup=False,
    )
    console.print(_table(report))
    _show_errors(console, report.prediction)
    console.print(describe_selection(report.selection), markup=False, highlight=False)


def _table(report: ExperimentReport) -> Table:
    table = Table(title="Value of a look, in success probability", title_justify="left")
    for heading in ("rule", "sensor", "VOA (predicted)", "AECD (measured)", "difference"):
        table.add_column(heading, justify="left" if heading in ("rule", "sensor") else "right")
    for rule, sensors in report.rules.items():
        for index, (sensor, value) in enumerate(sensors.items()):
            table.add_row(
                rule if index == 0 else "",
                escape(sensor),
                signed(value.voa, 4),
                "-" if value.aecd is None else signed(value.aecd, 4),
                "-" if value.aecd is None else signed(value.aecd - value.voa, 4),
                end_section=index == len(sensors) - 1,
            )
    return table


def _show_errors(console: Console, errors: PredictionErrors) -> None:
    if errors.beams == 0:
        console.print("no beam has both a measured and a predicted range")
        return
    console.print(
        f"measured against predicted ({errors.source}) over {errors.beams} beams: median "
        f"{errors.median_abs_mm:.1f} mm, 95 % below {errors.p95_abs_mm:.1f} mm, largest {errors.max_abs_mm:.1f} mm"
    )
    against = errors.against_recorded
    if against is not None:
        console.print(
            f"mesh against recorded predictions over {against.beams} beams: largest {against.max_abs_m:.1e} m"
        )
