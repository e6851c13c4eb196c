"""The compiler without the passes that nothing here needs, and with a memory for rules of types."""

import gc
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import numpy.typing as npt
import pytest
from numba.core import types
from numba.core.compiler import Compiler

from reflexarc_sim_bridge.native.lean import LeanCompiler, uncollected

_njit: Any = numba.njit  # its stub does not know `pipeline_class`

NEEDLESS = {
    "WithLifting": "no `with`",
    "InlineClosureLikes": "no function within a function",
    "MakeFunctionToJitFunction": "none either",
    "RewriteSemanticConstants": "no branch on the number of dimensions",
    "DeadBranchPrune": "no branch on None",
    "RewriteDynamicRaises": "no exception",
    "FindLiterallyCalls": "no `literally`",
    "LiteralUnroll": "no `literal_unroll`",
    "LiteralPropagationSubPipelinePass": "none either",
    "InlineOverloads": "no `overload` that is to be put in its place",
    "NoPythonSupportedFeatureValidation": "no generator",
    "AnnotateTypes": "a listing for people",
    "NativeLowering": "there is one of ours",
    "DumpParforDiagnostics": "no `prange`",
}


class _PassesError(Exception):
    """Raised in place of compiling."""


def passes_of(compiler: type, allocates: bool) -> list[str]:
    class Asked(compiler):  # type: ignore[misc]
        def define_pipelines(self) -> Any:
            rows = super().define_pipelines()
            raise _PassesError([each.__name__ for row in rows for each, _ in row.passes])

    try:
        _njit(pipeline_class=Asked, _nrt=allocates)(lambda x: x).compile((types.int64,))
    except _PassesError as passes:
        return list(passes.args[0])
    raise AssertionError("it compiled")


def test_of_numba_s_passes_only_those_are_left_out_that_are_known_to_do_nothing_here() -> None:
    usual = [each for each in passes_of(Compiler, allocates=True) if each not in NEEDLESS]
    ours = passes_of(LeanCompiler, allocates=True)
    assert [each for each in ours if each != "WideLowering"] == usual


def test_only_what_allocates_is_searched_for_expressions_over_whole_arrays() -> None:
    left_out = set(passes_of(LeanCompiler, True)) - set(passes_of(LeanCompiler, False))
    assert left_out == {"NopythonRewrites"}


def mixed_sum(values: npt.NDArray[Any], factor: float) -> Any:
    """Integers, floats and an index, and a rule of each."""
    total = 0
    for k in range(len(values)):
        total += values[k] * factor if k % 3 else min(values[k], k) // 2
    return total


def compiled_by(compiler: type, allocates: bool = False) -> Callable[..., Any]:
    return _njit(pipeline_class=compiler, _nrt=allocates)(mixed_sum)  # type: ignore[no-any-return]


def test_the_same_rules_of_types_give_the_same_numbers_however_often_they_were_asked() -> None:
    usual = compiled_by(Compiler, allocates=True)
    for dtype in (np.int8, np.uint64, np.float32, np.float64, np.int8):
        for factor in (3, 2.5, np.float32(1.5), True):
            for ours in (compiled_by(LeanCompiler), compiled_by(LeanCompiler, allocates=True)):
                values = np.arange(20).astype(dtype)
                found, wanted = ours(values, factor), usual(values, factor)
                assert (found, type(found)) == (wanted, type(wanted))


def test_a_function_is_no_rule_each_is_asked_what_it_gives() -> None:
    """Two functions of the same form, which are not remembered one for the other."""

    def caller_of(shift: int) -> Any:
        shifted = _njit(pipeline_class=LeanCompiler, _nrt=False)(lambda x: x + shift)
        return _njit(pipeline_class=LeanCompiler, _nrt=False)(lambda x: shifted(x))

    assert [caller_of(shift)(1) for shift in (1, 2.5, 1)] == [2, 3.5, 2]


def test_arguments_that_no_rule_fits_are_refused_each_time() -> None:
    for _ in range(2):
        add = _njit(pipeline_class=LeanCompiler, _nrt=False)(lambda x, y: x + y)
        with pytest.raises(numba.TypingError, match="No implementation of function"):
            add.compile((types.int64, types.unicode_type))


@pytest.mark.parametrize("was_on", [True, False])
def test_garbage_is_looked_for_again_if_it_was_before(was_on: bool) -> None:
    before = gc.isenabled()
    try:
        (gc.enable if was_on else gc.disable)()
        with uncollected():
            assert not gc.isenabled()
        assert gc.isenabled() == was_on
    finally:
        (gc.enable if before else gc.disable)()
