"""What is done to rows of weights, against NumPy."""

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_trainer.sarsa.online import row_products
from support.compiled_calls import from_python

affine_of_two = from_python(row_products.affine_of_two)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("inputs", [1, 3, 4, 7, 8, 9])
def test_two_products_with_one_matrix(inputs: int, dtype: npt.DTypeLike) -> None:
    draws = np.random.default_rng(inputs)
    matrix, bias = (
        draws.normal(size=(inputs, 16)).astype(dtype),
        draws.normal(size=16).astype(dtype),
    )
    x, y = draws.normal(size=(2, inputs)).astype(dtype)
    of_x, of_y = np.empty(16, dtype), np.empty(16, dtype)
    affine_of_two(matrix, bias, x, y, of_x, of_y)
    for mine, exact in ((of_x, x @ matrix + bias), (of_y, y @ matrix + bias)):
        np.testing.assert_allclose(mine, exact, rtol=0, atol=30 * np.finfo(dtype).eps)
