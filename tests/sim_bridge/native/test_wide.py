"""Compiled functions ask for wide vectors, and get them where there are any."""

import llvmlite.binding as llvm
import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.native.decorators import compiled

HAS_WIDE = dict(llvm.get_host_cpu_features()).get("avx512f", False)


@compiled
def doubled(values: npt.NDArray[np.float32]) -> None:
    """A loop that is a vector."""
    for k in range(len(values)):
        values[k] *= np.float32(2.0)


def compiled_doubled() -> None:
    values = np.ones(100, np.float32)
    doubled(values)
    assert values.sum() == 200.0


def test_functions_ask_for_wide_vectors() -> None:
    compiled_doubled()
    doubled.recompile()  # what comes from the cache has no listing
    [listing] = doubled.inspect_llvm().values()
    assert '"prefer-vector-width"="512"' in listing


@pytest.mark.skipif(not HAS_WIDE, reason="this processor has no vectors of 512 bits")
def test_loops_are_such_vectors() -> None:
    compiled_doubled()
    doubled.recompile()
    [listing] = doubled.inspect_asm().values()
    assert "zmm" in listing
