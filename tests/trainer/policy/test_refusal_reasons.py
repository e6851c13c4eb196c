import numpy as np
import pytest

from reflexarc_trainer.policy.refusal_reasons import Refusing

USUAL = np.array([[0.1, 0.2]], np.float32)


@pytest.mark.parametrize(
    ("bound", "apart", "q_values", "said"),
    [
        (1e-3, 2e-3, USUAL, "off by 0.001 at most, so an operator is at fault"),
        (0.5, 2e-2, USUAL, "large numbers leave when they cancel out, or jump"),
        (0.5, 2e-2, 3000 * USUAL, "divide them by 4e+02"),
        (np.inf, 2e-2, USUAL, "cancel out, or jump"),
        (0.5, np.nan, np.array([[np.nan, 1.0]], np.float32), "not finite (NaN)"),
        (np.inf, np.inf, np.array([[np.inf, 1.0]], np.float32), "not finite (infinite)"),
    ],
)
def test_the_reason_follows_from_the_bound(
    bound: float, apart: float, q_values: np.ndarray, said: str
) -> None:
    assert said in Refusing(bound).rounded(apart, q_values)


def test_small_q_values_are_not_to_be_divided() -> None:
    assert "divide" not in Refusing(0.5).rounded(2e-2, USUAL)
