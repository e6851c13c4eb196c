"""The detector's answer to sines against its closed form, which nobody had to simulate."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_baselines.correlators import kept_share, low_passed, motion, receptors
from reflexarc_runtime.contract.eye import RetinaSpec

TAU_S, PERIOD_S = 0.3, 0.1


def mean_response(
    frequency_hz: npt.NDArray[np.float64], wave: float, apart: float, contrast: float = 1.0
) -> npt.NDArray[np.float64]:
    """Over 400 steps, whole periods of every multiple of 0.025 Hz, long after the start."""
    beta = np.full(frequency_hz.shape, kept_share(PERIOD_S, TAU_S))
    late_a, late_b, total = (np.zeros(frequency_hz.shape) for _ in range(3))
    for n in range(800):
        phase = 2.0 * np.pi * frequency_hz * PERIOD_S * n
        a = contrast * np.sin(-phase)
        b = contrast * np.sin(2.0 * np.pi * apart / wave - phase)
        late_a, late_b = low_passed(late_a, a, beta), low_passed(late_b, b, beta)
        total += motion(a, late_a, b, late_b) if n >= 400 else 0.0
    return total / 400


def closed_form(
    frequency_hz: npt.NDArray[np.float64], wave: float, apart: float
) -> npt.NDArray[np.float64]:
    beta = math.exp(-PERIOD_S / TAU_S)
    omega = 2.0 * np.pi * frequency_hz * PERIOD_S
    spatial = math.sin(2.0 * math.pi * apart / wave)
    below = 1.0 - 2.0 * beta * np.cos(omega) + beta**2
    response: npt.NDArray[np.float64] = spatial * (1.0 - beta) * beta * np.sin(omega) / below
    return response


FREQUENCIES_HZ = np.arange(1, 160) * 0.025


@pytest.mark.parametrize(("wave", "apart"), [(40.0, 5.0), (25.0, 5.0), (8.0, 5.0)])
def test_the_mean_response_is_the_closed_form(wave: float, apart: float) -> None:
    measured = mean_response(FREQUENCIES_HZ, wave, apart)
    assert measured == pytest.approx(closed_form(FREQUENCIES_HZ, wave, apart), abs=1e-9)


@pytest.mark.parametrize("wave", [20.0, 40.0, 80.0])
def test_the_best_frequency_is_that_of_the_formula_at_every_wavelength(wave: float) -> None:
    best = math.acos(1.0 / math.cosh(PERIOD_S / TAU_S)) / (2.0 * math.pi * PERIOD_S)
    assert best == pytest.approx(0.521, abs=5e-4)
    found = FREQUENCIES_HZ[mean_response(FREQUENCIES_HZ, wave, apart=5.0).argmax()]
    assert abs(found - best) <= 0.0125


def test_half_the_contrast_gives_a_quarter_of_the_response() -> None:
    full, half = (mean_response(FREQUENCIES_HZ, 40.0, 5.0, contrast) for contrast in (1.0, 0.5))
    assert half == pytest.approx(full / 4.0, rel=1e-12)


def test_the_sign_flips_for_waves_between_one_and_two_separations() -> None:
    half_hz = np.array([0.5])
    assert mean_response(half_hz, wave=2.1, apart=1.0)[0] > 0.0
    assert mean_response(half_hz, wave=1.9, apart=1.0)[0] < 0.0
    assert mean_response(half_hz, wave=1.1, apart=1.0)[0] < 0.0
    assert mean_response(-half_hz, wave=4.0, apart=1.0)[0] < 0.0


def test_receptors_lie_between_the_two_nearest_rays() -> None:
    """Four rays over 80°: they look to 30°, 10°, −10° and −30°."""
    eye = RetinaSpec(rays=4, fov_rad=math.radians(80.0))
    looks_rad = np.radians([30.0, 5.0, -25.0, 60.0])
    expected = [[1, 0, 0, 0], [0, 0.75, 0.25, 0], [0, 0, 0.25, 0.75], [1, 0, 0, 0]]
    assert pytest.approx(np.array(expected), abs=1e-6) == receptors(eye, looks_rad).T
