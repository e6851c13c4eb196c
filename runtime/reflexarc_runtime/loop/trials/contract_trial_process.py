"""The process that reads the contract of a policy that somebody sent: see `contract_trial`.

    python -m reflexarc_runtime.loop.trials.contract_trial_process < POLICY

It prints `ready` when it has loaded its own modules, then one JSON object.
"""

import json
import signal
import sys
from dataclasses import replace

from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.loop.trials.trial import READY
from reflexarc_runtime.loop.trials.trial_process import ALONE_S, limit_memory
from reflexarc_runtime.policy.model_file import MAX_FILE_BYTES
from reflexarc_runtime.policy.policy import load_contract

MOST_CHARACTERS = 1 << 16
"""Of a contract without its golden vectors: 64 actions take a few thousand."""


def main() -> None:
    """Read a policy file from standard input; print its contract."""
    signal.alarm(ALONE_S)
    limit_memory(MAX_FILE_BYTES)
    print(READY, flush=True)
    print(json.dumps(_read(sys.stdin.buffer.read())))


def _read(data: bytes) -> dict[str, str]:
    try:
        contract = load_contract(data, bounds=None)
    except ReflexarcError as error:
        return {"error": str(error)[:MOST_CHARACTERS]}
    text = replace(contract, golden=GoldenVectors(), provenance=Provenance()).to_json()
    if len(text) > MOST_CHARACTERS:
        return {"error": f"policy: expected a contract of {MOST_CHARACTERS} characters, got more"}
    return {"contract": text}


if __name__ == "__main__":
    main()
