"""Documents that `voa evaluate --json` prints, from typed results."""

from collections.abc import Sequence
from dataclasses import asdict
from math import degrees
from typing import Any

from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.looks.results import Results
from voa_evaluation.observation import ObservationErrors
from voa_evaluation.resting import STABLE_RAD, RestCounts, prior_from
from voa_fleet.world.objects import FleetObject


def grasp_score_document(scores: GraspScores) -> dict[str, Any]:
    """Make the document of measured grasp scores; `noise` in metres and radians."""
    return {
        "object": scores.object,
        "attempts": scores.attempts,
        "seed": scores.seed,
        "opening_m": scores.opening_m,
        "noise": {key: asdict(scores.imperfections)[key] for key in ("object_xy_m", "object_yaw_rad")},
        "poses": list(scores.poses),
        "grasps": list(scores.grasps),
        "successes": scores.successes,
        "cells": [
            {
                "pose": cell.pose,
                "grasp": cell.grasp,
                "successes": cell.successes,
                "attempts": cell.attempts,
                "interval": list(cell.interval),
                "results": dict(cell.results),
            }
            for row in scores.cells
            for cell in row
        ],
    }


def observation_document(errors: ObservationErrors) -> dict[str, Any]:
    """Make the document of prediction errors, millimetres and degrees."""
    return {
        "name": errors.name,
        "source": errors.source,
        "scans": errors.scans,
        "overall": asdict(errors.overall),
        "sensors": {sensor: asdict(own) for sensor, own in errors.by_sensor().items()},
        "beams": [
            {"sensor": sensor, "angle_deg": angle} | asdict(own) for (sensor, angle), own in errors.by_beam().items()
        ],
    }


def looks_document(results: Results) -> dict[str, Any]:
    """Make the document of an evaluation of looks."""
    return {
        "drops": results.setting.drops,
        "attempts_per_score": results.setting.attempts,
        "sensitivity_drops": results.setting.sensitivity_drops,
        "seed": results.setting.seed,
        "attempts": results.attempts,
        "looks": [asdict(worth) for worth in results.worths],
        "gains": [asdict(gain) for gain in results.gains],
        "policies": [asdict(outcome) for outcome in results.outcomes],
        "calibration": [asdict(each) for each in results.bins],
        "sensitivity": [asdict(level) for level in results.levels],
    }


def rest_document(target: FleetObject, rests: RestCounts, tilts: Sequence[float]) -> dict[str, Any]:
    """Make the document of drops: counts, prior and stability.

    Args:
        target: the object.
        rests: counts of the ways to rest.
        tilts: of each pose after release, radians, (poses,).
    """
    return {
        "object": target.name,
        "drops": rests.total,
        "seed": rests.seed,
        "rests": [{"name": name, "count": count} for name, count in rests.counts.items()],
        "poses": [
            {"name": pose, "prior": share, "tilt_deg": degrees(tilt), "stable": tilt < STABLE_RAD}
            for pose, share, tilt in zip(target.poses, prior_from(target, rests), tilts, strict=True)
        ],
    }


def one_or_all(documents: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the document of the only object, or one with all of them as `objects`."""
    return documents[0] if len(documents) == 1 else {"objects": documents}
