"""Forecasts of looks for policies other than VOA: how much each look is expected to see, and to leave uncertain."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_client import Client
from voa_fleet.world.frames import Floats
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Scan, UpdateRequest


@dataclass(frozen=True, eq=False)
class Forecast:
    """The service's predicted scans, and its updates by them.

    Attributes:
        visible: number of beams that are predicted to meet the object, (sensors, poses).
        likelihoods: (sensors, poses, poses): `[s, p]` is the belief that the service computes from a uniform one after
            the scan that is predicted at sensor configuration s and pose p.
    """

    visible: Floats
    likelihoods: Floats

    def expected_beams(self, belief: Sequence[float]) -> Floats:
        """Return the number of beams expected to meet the object from each sensor configuration, (sensors,)."""
        return np.asarray(self.visible @ np.asarray(belief, dtype=np.float64))

    def expected_entropies(self, belief: Sequence[float]) -> Floats:
        """Return the entropy expected after a look from each sensor configuration, (sensors,), nats.

        The expectation is over the scans that are predicted at each pose, weighted by the belief (poses,).
        """
        prior = np.asarray(belief, dtype=np.float64)
        joint = self.likelihoods * prior
        total = joint.sum(axis=2, keepdims=True)
        after = np.divide(joint, total, out=np.broadcast_to(prior, joint.shape).copy(), where=total > 0.0)
        logs = np.log(np.where(after > 0.0, after, 1.0))
        entropies: Floats = -(after * logs).sum(axis=2) @ prior
        return entropies


def forecast_of(client: Client, scenario: Scenario) -> Forecast:
    """Request the predicted scan of every sensor configuration and pose, and the update by each.

    This takes (sensors x poses) requests.

    Raises:
        VoaClientError: the service refuses a request, or does not answer.
    """
    predicted = client.predict(scenario.id).ranges
    visible = np.array([[sum(value is not None for value in scan) for scan in row] for row in predicted], dtype=float)
    uniform = [1.0 / len(scenario.poses)] * len(scenario.poses)
    likelihoods = np.array(
        [
            [
                client.update_once(
                    UpdateRequest(scenario=scenario.id, belief=uniform, sensor=sensor.name, scan=_scan_of(ranges))
                ).belief
                for ranges in row
            ]
            for sensor, row in zip(scenario.sensors, predicted, strict=True)
        ]
    )
    return Forecast(visible, likelihoods)


def _scan_of(ranges: Sequence[float | None]) -> Scan:
    """The message of a predicted scan, in which None is a no-return."""
    no_return = [index for index, value in enumerate(ranges) if value is None]
    return Scan(ranges=[0.0 if value is None else value for value in ranges], no_return=no_return)
