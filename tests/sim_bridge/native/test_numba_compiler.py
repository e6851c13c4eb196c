"""Our changes to Numba's compiler: wide vectors, arrays that share no memory, calls from Python."""

import gc
from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np
import numpy.typing as npt
import pytest
from numba.core import types
from numba.core.compiler import Compiler

from reflexarc_sim_bridge.native.decorators import compiled, compiled_disjoint, compiled_inner
from reflexarc_sim_bridge.native.numba_compiler import (
    DisjointCompiler,
    InnerCompiler,
    WideCompiler,
    without_garbage_collection,
)

HAS_WIDE = dict(llvm.get_host_cpu_features()).get("avx512f", False)
FLOATS = types.float32[::1]

_njit: Any = numba.njit  # its stub does not know `pipeline_class`


@compiled
def doubled(values: npt.NDArray[np.float32]) -> None:
    """A loop that is a vector."""
    for k in range(len(values)):
        values[k] *= np.float32(2.0)


@compiled_inner
def inner(x: float) -> float:
    return x + 1.0


@compiled_disjoint
def copied(from_: npt.NDArray[np.float32], to: npt.NDArray[np.float32]) -> None:
    for k in range(len(from_)):
        to[k] = from_[k]


def listing_of(function: Any, *arguments: Any) -> str:
    function.compile(arguments)
    function.recompile()  # what comes from the disk has no listing
    [listing] = function.inspect_llvm().values()
    return str(listing)


def test_functions_ask_for_wide_vectors() -> None:
    assert '"prefer-vector-width"="512"' in listing_of(doubled, FLOATS)


@pytest.mark.skipif(not HAS_WIDE, reason="this processor has no vectors of 512 bits")
def test_loops_are_such_vectors() -> None:
    listing_of(doubled, FLOATS)
    [listing] = doubled.inspect_asm().values()  # type: ignore[attr-defined]  # numba's
    assert "zmm" in listing


def test_only_loops_over_arrays_that_share_no_memory_say_so() -> None:
    assert "noalias" in listing_of(copied, FLOATS, FLOATS).split("define")[1]
    plain = _njit(pipeline_class=InnerCompiler)(copied.py_func)  # type: ignore[attr-defined]
    data = listing_of(plain, FLOATS, FLOATS).split("define")[1].split(",")
    assert sum("noalias" in word and ".data" in word for word in data) == 0


def passes_of(compiler: Any) -> list[type]:
    """The passes of a compilation that ends where it would begin."""

    class Asked(compiler):  # type: ignore[misc]
        def define_pipelines(self) -> Any:
            rows = super().define_pipelines()
            raise LookupError([each for row in rows for each, _ in row.passes])

    with pytest.raises(LookupError) as found:
        _njit(pipeline_class=Asked)(lambda x: x).compile((types.int64,))
    passes: list[type] = found.value.args[0]
    return passes


@pytest.mark.parametrize("compiler", [WideCompiler, InnerCompiler, DisjointCompiler])
def test_the_passes_are_numba_s_own_but_for_one(compiler: Any) -> None:
    pairs = list(zip(passes_of(Compiler), passes_of(compiler), strict=True))
    [(numba_s, ours)] = [(a, b) for a, b in pairs if a is not b]
    assert issubclass(ours, numba_s)
    assert ours is compiler.lowering


def test_what_only_compiled_code_can_call_refuses_python() -> None:
    for _ in range(2):  # when it is compiled, and after
        with pytest.raises(TypeError, match="inner: only compiled functions can call it"):
            inner(1.0)
    called = _njit(lambda x: inner(x))
    assert called(1.0) == 2.0


@pytest.mark.parametrize("was_on", [True, False])
def test_garbage_is_collected_again_if_it_was_before(was_on: bool) -> None:
    before = gc.isenabled()
    try:
        (gc.enable if was_on else gc.disable)()
        with without_garbage_collection():
            assert not gc.isenabled()
        assert gc.isenabled() == was_on
    finally:
        (gc.enable if before else gc.disable)()
