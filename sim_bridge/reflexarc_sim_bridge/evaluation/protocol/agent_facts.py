"""The specification of whoever is measured, from its contract and its provenance."""

import hashlib
import json
from typing import Any

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye_in_words import eye_in_words
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.moving_like import body_words, motion_words
from reflexarc_sim_bridge.evaluation.protocol.results import Agent


def agent_of(contender: Contender, source: str, content: str) -> Agent:
    """The specification of a contender.

    Args:
        contender: who drives.
        source: what it was made from.
        content: see `Entrant.content_hash`.
    """
    contract = contender.contract
    provenance = contract.provenance
    is_trained = _learned_from(provenance) is not None
    return Agent(
        name=contender.name,
        source=source,
        hash=content,
        seed=provenance.seed if is_trained else None,
        preset=provenance.preset,
        eye=_eye(contender),
        motion=_motion(contract, contender.is_guarded),
        body=body_words(contract.body),
        rate_hz=contract.rate_hz,
        turns=contender.turns,
        tuned=_tuned(provenance, contender.policy),
        group=group_of(provenance) if is_trained else "",
    )


def _learned_from(provenance: Provenance) -> Any:
    """How many transitions it learned from; None for what was not learned."""
    config = provenance.config
    return config.get("steps", config.get("decisions"))


def group_of(provenance: Provenance) -> str:
    """Preset, and a hash of the configuration without its seed."""
    config = {key: value for key, value in provenance.config.items() if key != "seed"}
    text = json.dumps(config, sort_keys=True, default=str)
    return f"{provenance.preset}@{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def _eye(contender: Contender) -> str:
    words = f"{eye_in_words(contender.contract.retina)} frames={contender.contract.retina.frames}"
    return f"{words}, ranges" if contender.sees_ranges else words


def _motion(contract: PolicyContract, is_guarded: bool) -> str:
    words = motion_words(contract)
    if contract.hold_s:
        words += f", holds {contract.hold_s:g} s"
    if contract.margin:
        words += f", margin {contract.margin:g}"
    return f"{words}, guarded" if is_guarded else words


def _tuned(provenance: Provenance, policy: Any) -> str:
    steps = _learned_from(provenance)
    if steps is not None:
        return f"trained: {provenance.preset}, {steps} steps, seed {provenance.seed}"
    origin = getattr(policy, "ORIGIN", None)
    return f"{origin.fidelity}: {origin.source}" if origin is not None else ""
