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
from typing import Any

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
    from reflexarc_sim_bridge.native import numba_compiler

    numba_compiler.FUNCTION_ATTRIBUTES.clear()


def without_noalias() -> None:
    from reflexarc_sim_bridge.native import numba_compiler

    numba_compiler.DisjointCompiler.lowering = numba_compiler.InnerLowering


def without_refusal() -> None:
    from reflexarc_sim_bridge.native import numba_compiler

    numba_compiler.InnerCompiler.lowering = numba_compiler.WideLowering


def without_borrowed() -> None:
    from reflexarc_sim_bridge.native import decorators

    decorators.BORROWED["_nrt"] = True


def without_fetch() -> None:
    from reflexarc_sim_bridge.native import decorators, intrinsics

    @decorators.compiled_inline
    def fetch(array: Any, index: int) -> None:
        """Ask for nothing."""

    intrinsics.fetch = fetch


def without_multiply_add() -> None:
    from reflexarc_sim_bridge.native import decorators, intrinsics

    @decorators.compiled_inline
    def multiply_add(a: Any, b: Any, c: Any) -> Any:
        return a * b + c

    intrinsics.multiply_add = multiply_add


def without_uncollected() -> None:
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
    with tempfile.TemporaryDirectory() as folder:
        servers, cold_s = {}, {}
        for trick in tricks:
            print(f"compiling without {trick} …", file=sys.stderr)
            servers[trick] = start(trick, folder)
            cold_s[trick] = json.loads(line_of(servers[trick]))
        rates: dict[str, list[list[float]]] = {trick: [] for trick in tricks}
        for _ in range(rounds):
            for trick, server in servers.items():
                assert server.stdin is not None
                server.stdin.write("go\n")
                server.stdin.flush()
                rates[trick].append(json.loads(line_of(server)))
        for server in servers.values():
            server.communicate()
    return [row(trick, rates, cold_s) for trick in tricks]


def start(trick: str, folder: str) -> "subprocess.Popen[str]":
    cache = {"NUMBA_CACHE_DIR": os.path.join(folder, trick)}
    return subprocess.Popen(
        [sys.executable, __file__, "--serve", trick],
        env={**os.environ, **cache},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def line_of(server: "subprocess.Popen[str]") -> str:
    assert server.stdout is not None
    return server.stdout.readline()


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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--tricks", nargs="*", default=list(TRICKS), choices=list(TRICKS))
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--serve")
    options = parser.parse_args()
    if options.serve:
        serve(options.serve)
        return
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
