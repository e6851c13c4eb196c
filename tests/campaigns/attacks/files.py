"""Policy files that drive where they must not, from the disk and as an answer on the bus."""

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from campaigns.attacks.outcome import Outcome, held_if, last_line
from campaigns.attacks.stage import Stage
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action, sideways_actions
from support.policies import exported
from support.processes import finished, reflexarc, said_line, started, wait_until
from support.witness import witness

USUAL = PolicyContract()
GREEDY = {
    "a safe command that drives": replace(USUAL, safe_command=Action("creep", 0.1, 0.0)),
    "speeds of 10³⁰⁸ m/s": replace(USUAL, actions=sideways_actions(1e308)),
    "inputs that may be an hour old": replace(USUAL, max_input_age_s=3600.0),
}


def from_the_disk(stage: Stage) -> Iterator[Outcome]:
    """`run` and `sim --policy` with such a file."""
    files = {name: exported(contract) for name, contract in GREEDY.items()}
    usual = exported(USUAL)
    files["a text that was changed, its digest kept"] = usual.replace(
        b'"max_input_age_s":0.1', b'"max_input_age_s":1.9'
    ).replace(b'"linear_mps":1.0', b'"linear_mps":9.0')
    assert usual not in [*files.values()]
    for name, data in files.items():
        port, folder = stage.place()
        path = folder / "policy.onnx"
        path.write_bytes(data)
        run = reflexarc("run", path, "--ticks", 3, "--port", port)
        sim = reflexarc("sim", "--policy", path, "--steps", 3, "--port", port)
        yield Outcome(
            f"a policy file: {name}",
            "`run FILE`, `sim --policy FILE`",
            None,
            f"exit status {run.returncode} and {sim.returncode}: {last_line(run.stderr)}",
            held_if(run.returncode == sim.returncode == 2),
        )


def as_an_answer(stage: Stage) -> Iterator[Outcome]:
    """A stranger who answers the `policy` query of a body, before any runtime is there."""
    answers = {name: exported(contract) for name, contract in GREEDY.items()}
    for name, data in {**answers, "garbage": b"garbage"}.items():
        line, waits = _answered(stage, data)
        yield Outcome(
            f"an answer to `sim`'s query for the policy: {name}",
            "first to answer, no runtime",
            0.0,
            f"{last_line(line)}; {'it waits on' if waits else 'it ended'}",
            held_if(waits),
        )
    yield _usual_answer(stage)


def _answered(stage: Stage, data: bytes) -> tuple[str, bool]:
    """What a body says that is given these bytes for a policy, and whether it waits on."""
    port, folder = stage.place()
    with started("sim", "--port", port, "--json", cwd=folder) as body:
        said_line(body, "waiting for a runtime")
        with _Answering(port, data):
            line = said_line(body, "is no policy to build an eye for")
            time.sleep(1.0)
            return line, body.poll() is None


def _usual_answer(stage: Stage) -> Outcome:
    """A file within the bounds, and far too fast: the body is built for it, and stands."""
    port, folder = stage.place()
    fast = exported(replace(USUAL, actions=sideways_actions(19.0), max_input_age_s=1.9))
    with started("sim", "--port", port, "--json", cwd=folder) as body:
        said_line(body, "waiting for a runtime")
        with _Answering(port, fast):
            said_line(body, "reference-1")
            with witness(port) as seen:
                wait_until(lambda: seen.x_m, "a pose")
                time.sleep(5.0)
                rolled_m = seen.way_m
        journey = finished(body, 2)
    return Outcome(
        "an answer to `sim`'s query for the policy: 19 m/s, inputs of 1.9 s, within the bounds",
        "first to answer, no runtime, 5 s",
        rolled_m,
        f"it is built for that file, and stands: {journey['distance_m']:.2f} m",
        held_if(rolled_m == 0.0 and journey["distance_m"] == 0.0),
    )


class _Answering:
    """A stranger who answers the query of a body; a context manager."""

    def __init__(self, port: int, data: bytes) -> None:
        self._bus = Bus(BusConfig("robot0", port), time.monotonic_ns)
        self._data = data

    def __enter__(self) -> None:
        self._bus.__enter__()
        self._bus.offer_policy(lambda: self._data)

    def __exit__(self, *reason: Any) -> None:
        self._bus.__exit__(*reason)


ATTACKS = (from_the_disk, as_an_answer)
