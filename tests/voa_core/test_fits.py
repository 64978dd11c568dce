"""Fits of a scan by predictions, against sums over the beams, one by one."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from voa_core.checks import Floats
from voa_core.displaced_scans import DisplacedScans
from voa_core.fits import Fits, fits_of_copies, fits_of_poses
from voa_core.lidars import BeamGrid
from voa_core.prediction import Prediction

INF, NAN = math.inf, math.nan
GRID = BeamGrid(6, 0.0, 0.1)
SCANS = st.lists(st.sampled_from([0.2, 0.45, 0.6, 1.7, INF, NAN]), min_size=6, max_size=6)
RANGES = st.sampled_from([0.3, 0.5, 1.0, 1.8, INF])


def by_hand(beams: Floats, dense: Floats, no_return_m: float) -> list[tuple[float, float]]:
    """d^2 and the RMSD over the beams on which both return, of each predicted scan (m, r)."""
    fits = []
    for own in dense.tolist():
        pairs = [(z, p) for z, p in zip(beams.tolist(), own, strict=True) if not math.isnan(z)]
        offs = [min(z, no_return_m) - min(p, no_return_m) for z, p in pairs]
        hits = [off**2 for off, (z, p) in zip(offs, pairs, strict=True) if z < INF and p < INF]
        square = math.fsum(off**2 for off in offs)
        fits.append((square, math.sqrt(math.fsum(hits) / len(hits)) if hits else NAN))
    return fits


@given(
    beams=SCANS,
    dense=st.lists(st.lists(RANGES, min_size=6, max_size=6), min_size=4, max_size=4),
    empty=st.sets(st.integers(0, 5)),
    no_return_m=st.sampled_from([0.55, 2.0]),
    copies=st.sampled_from([1, 2, 4]),
)
def test_fits_are_sums_over_the_beams(
    beams: list[float], dense: list[list[float]], empty: set[int], no_return_m: float, copies: int
) -> None:
    scan, predicted = np.array(beams), np.array(dense)
    predicted[:, list(empty)] = INF  # beams that meet no pose are kept by neither form of a prediction
    prediction = Prediction.of_dense(GRID, predicted)
    expected = by_hand(scan, predicted, no_return_m)
    squares = np.array([square for square, _ in expected]).reshape(-1, copies)
    best = squares.argmin(axis=1)
    rmsds = np.array([rmsd for _, rmsd in expected]).reshape(-1, copies)[np.arange(len(best)), best]
    results: list[Fits] = [fits_of_copies(scan, DisplacedScans.of(prediction, copies), no_return_m)]
    if copies == 1:
        results.append(fits_of_poses(scan, prediction, no_return_m))
    for fits in results:
        np.testing.assert_allclose(fits.squares, squares, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(fits.distances, np.sqrt(squares.min(axis=1)), rtol=1e-12, atol=1e-15)
        ties = np.count_nonzero(np.isclose(squares, squares.min(axis=1, keepdims=True)), axis=1) > 1
        np.testing.assert_allclose(fits.hit_rmsds[~ties], rmsds[~ties], rtol=1e-12, atol=1e-15)


def test_the_first_of_equal_copies_is_the_best() -> None:
    # Each copy is 0.25 m off: the first where both return, the second where it predicts nothing.
    dense = np.full((2, 6), INF)
    dense[0, 0] = 0.5
    scan = np.array([0.75, NAN, INF, INF, INF, INF])
    for rows, rmsd in (([0, 1], 0.25), ([1, 0], NAN)):
        copies = DisplacedScans.of(Prediction.of_dense(GRID, dense[rows]), 2)
        fits = fits_of_copies(scan, copies, 1.0)
        assert fits.squares.tolist() == [[0.0625, 0.0625]]
        assert fits.distances.tolist() == [0.25]
        np.testing.assert_array_equal(fits.hit_rmsds, [rmsd])
