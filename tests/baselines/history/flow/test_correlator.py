import math

import numpy as np
import pytest

from reflexarc_baselines.history.flow.correlator import Filters, leftward

DT_S, APART_RAD = 0.1, math.pi / 16


def mean_response(
    frequency_hz: float,
    *,
    tau_s: float = 0.3,
    wavelength_rad: float = 1.0,
    contrast: float = 0.4,
    brightness: float = 0.5,
) -> float:
    """Of two rays over whole periods of a grating that goes left, past its first 20 s."""
    filters = Filters(math.exp(-DT_S / tau_s), 1.0 - 1e-9)  # the mean is that of the first frame
    bearings, memory, found = np.array([0.5, -0.5]) * APART_RAD, np.zeros((1, 5), np.float32), []
    seen = np.full((1, 2), brightness, np.float32)
    _, _, memory = filters.followed(seen, memory)
    for step in range(200 + 1000):
        phase = 2 * math.pi * (bearings / wavelength_rad - frequency_hz * step * DT_S)
        seen = (brightness + contrast * np.sin(phase)).astype(np.float32)[np.newaxis]
        signals, delayed, memory = filters.followed(seen, memory)
        found.append(float(leftward(signals, delayed)[0, 0]))
    return float(np.mean(found[200:]))


def by_formula(frequency_hz: float, tau_s: float, wavelength_rad: float, contrast: float) -> float:
    beta, omega = math.exp(-DT_S / tau_s), 2 * math.pi * frequency_hz * DT_S
    tuned = (1 - beta) * beta * math.sin(omega) / (1 - 2 * beta * math.cos(omega) + beta**2)
    return contrast**2 * math.sin(2 * math.pi * APART_RAD / wavelength_rad) * tuned


@pytest.mark.parametrize("frequency_hz", [0.1, 0.5, 2.0, -0.7])
@pytest.mark.parametrize(("tau_s", "wavelength_rad"), [(0.3, 1.0), (0.1, 0.5), (0.3, 0.3)])
def test_the_mean_response_is_the_formula_s(
    frequency_hz: float, tau_s: float, wavelength_rad: float
) -> None:
    """Of wavelength 0.3, which is below 2Δφ = 0.39, the sign is wrong: so it shall be."""
    found = mean_response(frequency_hz, tau_s=tau_s, wavelength_rad=wavelength_rad)
    expected = by_formula(frequency_hz, tau_s, wavelength_rad, 0.4)
    assert found == pytest.approx(expected, rel=1e-3, abs=1e-6)


def test_it_sees_what_goes_left_as_positive() -> None:
    assert mean_response(0.5) > 0.0 > mean_response(-0.5)


def test_half_the_contrast_is_a_quarter_of_the_response() -> None:
    assert mean_response(0.5, contrast=0.2) == pytest.approx(mean_response(0.5) / 4, rel=1e-3)


@pytest.mark.parametrize("wavelength_rad", [0.6, 1.5])
def test_its_optimum_is_a_frequency_whatever_the_wavelength(wavelength_rad: float) -> None:
    """arccos(sech(Δt/τ)) / 2πΔt = 0.521 Hz for τ = 0.3 s."""
    best_hz = math.acos(1 / math.cosh(DT_S / 0.3)) / (2 * math.pi * DT_S)
    assert best_hz == pytest.approx(0.521, abs=1e-3)
    around = [mean_response(f * best_hz, wavelength_rad=wavelength_rad) for f in (0.8, 1.0, 1.25)]
    assert max(around) == around[1]


def test_brightness_alone_is_no_motion() -> None:
    assert mean_response(0.0, contrast=0.0, brightness=0.9) == 0.0
    assert mean_response(0.5, brightness=0.9) == pytest.approx(mean_response(0.5), rel=1e-3)


def test_a_ray_s_mean_follows_with_its_time_constant() -> None:
    """A step from 0 to 1: after τ the signal, 1 less the mean, is 1/e."""
    filters, memory = Filters.of(0.1, 1.0, DT_S), np.zeros((1, 3), np.float32)
    _, _, memory = filters.followed(np.zeros((1, 1), np.float32), memory)
    for _ in range(10):
        signals, _, memory = filters.followed(np.ones((1, 1), np.float32), memory)
    assert signals[0, 0] == pytest.approx(math.exp(-1.0), rel=1e-5)


def test_the_first_frame_is_its_own_mean() -> None:
    seen = np.array([[0.9, 0.2, 0.6]], np.float32)
    signals, delayed, memory = Filters.of(0.1, 1.0, DT_S).followed(
        seen, np.zeros((1, 7), np.float32)
    )
    assert not signals.any()
    assert not delayed.any()
    assert memory[0, 1:4].tolist() == seen[0].tolist()
