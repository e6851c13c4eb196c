"""The limit below: a contender's body, at its rate and speeds, that never steers."""

from dataclasses import replace

from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy


def blind_like(contender: Contender) -> Contender:
    """Who is driven in a contender's place and always does its first action."""
    contract = replace(contender.contract, state=StateSpec(), hold_s=0.0, margin=0.0)
    return Contender(BLIND, BlindPolicy(len(contract.actions)), contract)
