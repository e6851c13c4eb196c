"""Reads the contract of a policy that somebody sent, in a process of its own.

Whoever answers a body's question for the policy may answer anything: bytes that a parser chews on
for minutes while it holds the interpreter's lock, or that unfold to more memory than there is. A
process can be ended: `contract_trial_process` is that one. What it gives back is a short text.
"""

import json
import subprocess
import sys

from reflexarc_runtime.contract.bounds import Bounds, check_bounds
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.trial import LOADING_S, STARTING_S, ended_after

_PROCESS = "reflexarc_runtime.loop.trials.contract_trial_process"


def tried_contract(
    data: bytes, bounds: Bounds | None, loading_s: float = LOADING_S
) -> PolicyContract:
    """The contract in the bytes of a policy file, without its golden vectors and provenance.

    Args:
        data: what somebody sent.
        bounds: what it may ask for at most; None: anything.
        loading_s: how long reading may take.

    Raises:
        PolicyError: it is no policy, or reading it takes too long or too much.
        ContractError: its contract is none, or asks for more than the bounds allow.
    """
    answer = _answer_of(data, loading_s)
    if "error" in answer:
        raise PolicyError(answer["error"])
    contract = PolicyContract.from_json(answer["contract"])
    if bounds is not None:
        check_bounds(contract, bounds)
    return contract


def _answer_of(data: bytes, loading_s: float) -> dict[str, str]:
    words = [sys.executable, "-P", "-m", _PROCESS]
    pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=nowhere) as process:
        try:
            assert process.stdout is not None
            with ended_after(STARTING_S, process.kill):
                process.stdout.readline()  # it is ready
            with ended_after(loading_s, process.kill):
                said, _ = process.communicate(data)
        finally:
            process.kill()
    try:
        answer: dict[str, str] = json.loads(said)
    except ValueError:
        raise PolicyError(
            f"policy: expected one that is read within {loading_s:g} s, got one that takes longer, "
            "or more memory than it may"
        ) from None
    return answer
