"""What each trick of `native/` buys: the world with all of them, and without one.

    python benchmarks/native_tricks.py                 every trick, seven rounds in turns
    python benchmarks/native_tricks.py --rounds 5 --tricks wide noalias

Each variant is a process of its own, with a cache of its own that it fills first: the CPU time of
that is the cold start. Then all variants step the same fields in turns, on one thread. Figures are
medians over rounds of the ratio to the world with all tricks.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Never

import numba
import numpy as np

TRICKS: dict[str, str] = {
    "none": "all tricks on",
    "wide": "vectors of 512 bits",
    "noalias": "loops that say that their arrays share no memory",
    "refusal": "no wrapper for Python around inner functions",
    "borrowed": "arrays without reference counts",
    "fetch": "asking ahead for the next agent's lists",
    "multiply_add": "one rounding in a·b + c",
    "uncollected": "no garbage collection while it compiles",
}
AGENTS, STEPS = 4096, 30
SAMPLES = 1, 4


def without_wide() -> None:
    """Ask LLVM for vectors of its own choice."""
    from reflexarc_sim_bridge.native import numba_compiler

    numba_compiler.FUNCTION_ATTRIBUTES.clear()


def without_noalias() -> None:
    """Let no loop say that its arrays share no memory."""
    from reflexarc_sim_bridge.native import numba_compiler

    numba_compiler.DisjointCompiler.lowering = numba_compiler.InnerLowering


def without_refusal() -> None:
    """Give inner functions Numba's own wrapper for Python."""
    from reflexarc_sim_bridge.native import numba_compiler

    numba_compiler.InnerCompiler.lowering = numba_compiler.WideLowering


def without_borrowed() -> None:
    """Count references to arrays."""
    from reflexarc_sim_bridge.native import decorators

    decorators.BORROWED["_nrt"] = True


def without_fetch() -> None:
    """Ask for no memory ahead."""
    from reflexarc_sim_bridge.native import decorators, intrinsics

    @decorators.compiled_inline
    def fetch(array: Any, index: int) -> None:
        """Ask for nothing."""

    intrinsics.fetch = fetch


def without_multiply_add() -> None:
    """Round a product before the sum."""
    from reflexarc_sim_bridge.native import decorators, intrinsics

    @decorators.compiled_inline
    def multiply_add(a: Any, b: Any, c: Any) -> Any:
        return a * b + c

    intrinsics.multiply_add = multiply_add


def without_uncollected() -> None:
    """Leave the garbage collector on while something is compiled."""
    import gc

    gc.disable = lambda: None  # type: ignore[assignment]


WITHOUT: dict[str, Callable[[], None]] = {
    "none": lambda: None,
    "wide": without_wide,
    "noalias": without_noalias,
    "refusal": without_refusal,
    "borrowed": without_borrowed,
    "fetch": without_fetch,
    "multiply_add": without_multiply_add,
    "uncollected": without_uncollected,
}


def serve(trick: str) -> None:
    """The process of a variant: compiles, then measures once for each line that it is given."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # no second process compiles for it
    WITHOUT[trick]()
    start_s = time.process_time()
    from world_scenes import MODES, Scene, actions_of, advancing

    from reflexarc_sim_bridge.native.threads import set_thread_count

    set_thread_count(1)
    scenes = [Scene(agents=AGENTS, samples=samples) for samples in SAMPLES]
    steps = [advancing(scene.simulation(), MODES["both"]) for scene in scenes]
    actions = actions_of("blind", STEPS, AGENTS)
    for step in steps:
        for each in actions:
            step(each)
    print(json.dumps(time.process_time() - start_s), flush=True)
    for _ in sys.stdin:
        print(json.dumps([rate(step, actions) for step in steps]), flush=True)


def rate(step: Callable[[Any], object], actions: Any) -> float:
    """Millions of agent-steps a second."""
    start_s = time.perf_counter()
    for each in actions:
        step(each)
    return AGENTS * len(actions) / (time.perf_counter() - start_s) / 1e6


def measure(tricks: list[str], rounds: int) -> list[dict[str, Any]]:
    """All variants in turns."""
    rates: dict[str, list[list[float]]] = {trick: [] for trick in tricks}
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        variants = [Variant(trick, folder, stack) for trick in tricks]
        for _ in range(rounds):
            for variant in variants:
                rates[variant.trick].append(variant.rates())
    cold_s = {variant.trick: variant.cold_s for variant in variants}
    return [row(trick, rates, cold_s) for trick in tricks]


class Variant:
    """A process that steps the world without one trick; it ends with the stack, whatever happens.

    Args:
        trick: what it does without.
        folder: for its cache.
        stack: what ends it.
    """

    def __init__(self, trick: str, folder: str, stack: ExitStack) -> None:
        print(f"compiling without {trick} …", file=sys.stderr)
        self.trick = trick
        self._process = subprocess.Popen(
            [sys.executable, __file__, "--serve", trick],
            env={**os.environ, "NUMBA_CACHE_DIR": os.path.join(folder, trick)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        stack.callback(self._end)
        self.cold_s = float(self._said())
        """Processor time until everything was compiled."""

    def rates(self) -> list[float]:
        """Let it measure once."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write("go\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            self._refuse()
        measured: list[float] = self._said()
        return measured

    def _said(self) -> Any:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        return json.loads(line) if line else self._refuse()

    def _refuse(self) -> Never:
        refuse(f"the world without {self.trick} ended with {self._process.wait()}; see above")

    def _end(self) -> None:
        self._process.kill()
        self._process.communicate()


def refuse(words: str) -> Never:
    """Say what is wrong in one line, and end with status 2."""
    print(f"native_tricks: {words}", file=sys.stderr)
    raise SystemExit(2)


def row(
    trick: str, rates: dict[str, list[list[float]]], cold_s: dict[str, float]
) -> dict[str, Any]:
    """Median ratios, pair by pair, to the world with all tricks."""
    ratios = np.array(rates[trick]) / np.array(rates["none"])
    return {
        "without": trick,
        "what": TRICKS[trick],
        **{
            f"{samples} samples": round(statistics.median(ratios[:, k].tolist()), 3)
            for k, samples in enumerate(SAMPLES)
        },
        "cold start": round(cold_s[trick] / cold_s["none"], 3),
    }


def main() -> None:
    """Measure what each trick buys, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--tricks", nargs="*", default=list(TRICKS), choices=list(TRICKS))
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--serve")
    options = parser.parse_args()
    if options.serve:
        serve(options.serve)
        return
    if options.rounds < 1:
        refuse(f"--rounds: expected 1 or more, got {options.rounds}")
    rows = measure(["none", *(t for t in options.tricks if t != "none")], options.rounds)
    if options.json:
        print(json.dumps({"numba": numba.__version__, "rows": rows}))
        return
    for each in rows:
        print(
            *(
                f"{value!s:<48}" if key == "what" else f"{value!s:<14}"
                for key, value in each.items()
            )
        )


if __name__ == "__main__":
    main()
