"""The attacks, tried: each on real processes, one row of a Markdown table each.

    python tests/campaigns/attacks [--only WORD] [--reflex POLICY.onnx] [--json]

Who says what it may not, twice, late, or on purpose, to a body, a runtime or a bridge; and how far
the robot rolls by it. Exit status 1: an attack got through that should not. What is known to get
through, because there is no authentication, says so in its row.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # the tests' packages

from campaigns.attacks import (
    brains,
    bridge,
    endings,
    files,
    hangs,
    operators,
    overriding,
    posts,
    retinas,
    strangers,
)
from campaigns.attacks.outcome import Held, Outcome, held_if, row, table
from campaigns.attacks.stage import Stage
from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported

Attack = Callable[[Stage], Iterator[Outcome]]

FAMILIES = (
    strangers,
    overriding,
    brains,
    retinas,
    operators,
    files,
    hangs,
    endings,
    bridge,
    posts,
)


def main() -> int:
    """Try them, and print the table."""
    given, began_s = _arguments(), time.monotonic()
    attacks = [a for a in _attacks() if given.only in f"{a.__module__}.{a.__name__}"]
    outcomes: list[Outcome] = []
    if not given.json:
        print(table([]))
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(_policy(Path(folder)), Path(folder), given.reflex)
        for attack in attacks:
            for outcome in tried(attack, stage):
                outcomes.append(outcome)
                print(json.dumps(asdict(outcome)) if given.json else row(outcome), flush=True)
    got_through = [outcome for outcome in outcomes if outcome.held is Held.NO]
    if not given.json:
        known = sum(outcome.held is Held.KNOWN for outcome in outcomes)
        print(
            f"\n{len(outcomes)} attacks, {known} of them get through as the documentation says, "
            f"{len(got_through)} otherwise; {time.monotonic() - began_s:.0f} s"
        )
    return 1 if got_through or not outcomes else 0


def tried(attack: Attack, stage: Stage) -> Iterator[Outcome]:
    """The rows of an attack; one that breaks has not shown that anything holds."""
    try:
        yield from attack(stage)
    except Exception as error:
        yield Outcome(attack.__name__, "it broke", None, f"{error!r}"[:300], held_if(False))


def _attacks() -> Iterator[Attack]:
    for family in FAMILIES:
        yield from family.ATTACKS


def _policy(folder: Path) -> Path:
    """An exported policy of random weights, with the eye of the reference field."""
    path = folder / "policy.onnx"
    path.write_bytes(exported(PolicyContract(), seed=5))
    return path


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--only", default="", help="only attacks with this word in their name")
    parser.add_argument("--reflex", type=Path, help="a trained policy for the guard's attack")
    parser.add_argument("--json", action="store_true", help="one JSON object a row")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
