"""Bayes' rule over a finite set of poses, in logarithms; the only module that uses filterpy.

`filterpy.discrete_bayes.update` multiplies a prior by a likelihood and divides by the sum. It does so without
guards (an impossible observation gives NaN), so this module checks before it calls it.
"""

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, finite_array, frozen
from voa_core.errors import InvalidInput

SUM_TOLERANCE = 1e-6
_NO_SHARE = 1e9


def _filterpys_update() -> Callable[[Floats, Floats], Floats]:
    """Load `filterpy.discrete_bayes.update` and the function that it calls, and nothing else of filterpy.

    `import filterpy` imports all of its filters, with scipy.stats, and the module of `update` imports scipy.ndimage for
    another function: half a second, and a quarter, of each start of a process.
    """
    package = find_spec("filterpy")
    if package is None or package.origin is None:
        raise ModuleNotFoundError("No module named 'filterpy'", name="filterpy")
    file = Path(package.origin).parent / "discrete_bayes" / "discrete_bayes.py"
    module = ast.parse(file.read_text(encoding="utf-8"), str(file))
    module.body = [each for each in module.body if getattr(each, "name", None) in ("normalize", "update")]
    names: dict[str, Any] = {"np": np, "sum": np.sum}  # Python's own sum takes thirteen times as long over an array
    exec(compile(module, str(file), "exec"), names)  # noqa: S102 - the source of an installed package, as an import runs it
    return cast(Callable[[Floats, Floats], Floats], names["update"])


_normalised = _filterpys_update()


@dataclass(frozen=True, eq=False)
class Belief:
    """Probabilities over the poses, and their logarithms.

    The logarithms are the state: a pose whose probability is too small for a float64 is improbable, not
    impossible, and later scans can bring it back. So observations commute.

    Attributes:
        p: (n,) finite, at least 0, sums to 1.
        log_p: (n,) natural logarithms, -inf where a pose is impossible.
    """

    p: Floats
    log_p: Floats

    @classmethod
    def of(cls, probabilities: object, field: str = "belief", length: int | None = None) -> "Belief":
        """Make a belief from probabilities (n,) that sum to 1 within 1e-6; they are then scaled to sum to 1.

        Args:
            probabilities: one number for each pose, at least 0.
            field: name of the values in error messages.
            length: number of poses; None: any.

        Raises:
            InvalidInput: the length is not `length`, the sum is not 1, or a number is negative or not finite.
        """
        p = finite_array(field, probabilities, (length,))  # type: ignore[arg-type] # None: any length
        if (p < 0.0).any():
            raise InvalidInput(
                field, "numbers of at least 0", f"{p.min():g} for pose {int(p.argmin())} (counted from 0)"
            )
        total = math.fsum(np.minimum(p, _NO_SHARE))  # the sum of the largest floats is none
        if abs(total - 1.0) > SUM_TOLERANCE:
            raise InvalidInput(field, "a sum within 1e-6 of 1", f"a sum of {total:.9g}")
        p = p / total
        with np.errstate(divide="ignore"):
            return cls(frozen(p), frozen(np.log(p)))

    @classmethod
    def uniform(cls, n: int) -> "Belief":
        """Belief in which each of `n` poses has the same probability."""
        return cls.of(np.full(n, 1.0 / n))

    @property
    def entropy_nats(self) -> float:
        """Shannon entropy, in nats."""
        held = self.p > 0.0
        return max(0.0, -float(self.p[held] @ self.log_p[held]))


@dataclass(frozen=True, eq=False)
class Posterior:
    """A belief after an observation, and the logarithm of the observation's probability under the prior."""

    belief: Belief
    log_evidence: float


def condition(prior: Belief, log_weights: Floats) -> Posterior | None:
    """Condition a belief by weights (Definition 4): b'[p] is proportional to b[p] w[p].

    The product is formed in logarithms and shifted by its maximum before filterpy normalises it: unlike either
    factor, the shifted product always fits a float64.

    Args:
        prior: (n,).
        log_weights: (n,) log w, -inf for a weight of 0; never NaN or +inf.

    Returns:
        The posterior, and ln sum_p b[p] w[p]; None if every pose that was possible has weight 0.
    """
    joint = prior.log_p + log_weights
    highest = float(joint.max())
    if highest == -np.inf:
        return None
    shifted = np.exp(joint - highest)
    posterior = np.asarray(_normalised(shifted, np.ones_like(shifted)))
    log_evidence = highest + float(np.log(shifted.sum()))
    return Posterior(Belief(frozen(posterior), frozen(joint - log_evidence)), log_evidence)


def share_equally(chosen: NDArray[np.bool_]) -> Belief:
    """Belief with equal probabilities for the poses at which `chosen` (n,) is true."""
    return Belief.of(chosen / np.count_nonzero(chosen))


def log_means(log_weights: Floats) -> Floats:
    """Logarithms of the means of weights over each row of (n, J): (n,), -inf where every weight of a row is 0."""
    if log_weights.shape[1] == 1:
        return log_weights[:, 0]
    highest = log_weights.max(axis=1)
    shift = np.where(highest > -np.inf, highest, 0.0)
    with np.errstate(divide="ignore"):
        means: Floats = shift + np.log(np.exp(log_weights - shift[:, None]).mean(axis=1))
    return means


def mixture(belief: Belief, other: Belief, share: float) -> Belief:
    """Mix two beliefs over the same poses: (1 - share) times the first plus `share`, in [0, 1], times the other."""
    with np.errstate(divide="ignore"):
        log_p = np.logaddexp(belief.log_p + np.log1p(-share), other.log_p + np.log(share))
    return Belief(frozen((1.0 - share) * belief.p + share * other.p), frozen(log_p))
