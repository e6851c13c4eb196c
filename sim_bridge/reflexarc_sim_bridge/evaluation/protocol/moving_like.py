"""Whose limits count for whom: a body's motion, without its eye and without its mind.

What is possible in a cell depends on how fast a body goes ahead and aside, how often it may decide
and how wide it is. All contenders of one motion share their limits.
"""

from dataclasses import replace

from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.worlds.reference_contract import reference_retina


def moving_like(contract: PolicyContract, setting: Setting) -> PolicyContract:
    """A contract with nothing but the motion of another one in a setting; its own eye is any.

    Whoever drives by it does so at its own rate and with its own body (`Setting.ROBOT`).
    """
    actions = tuple(
        replace(action, name=f"motion {number}") for number, action in enumerate(contract.actions)
    )
    return PolicyContract(
        retina=reference_retina(),
        actions=actions,
        rate_hz=setting.rate_hz(contract),
        body=setting.body(contract) or BodySpec(),
    )


def motion_words(contract: PolicyContract) -> str:
    """Speeds in words; two contracts of one motion have the same."""
    ahead = contract.actions[0].linear_mps
    aside = max(abs(action.lateral_mps) for action in contract.actions)
    turning = max(abs(action.angular_radps) for action in contract.actions)
    words = [f"{ahead:g} m/s ahead"]
    if aside:
        words.append(f"{aside:g} m/s aside")
    if turning:
        words.append(f"{turning:g} rad/s")
    return ", ".join(words)


def body_words(body: BodySpec) -> str:
    """Its outline, and how late and how hard it obeys."""
    outline = body.footprint
    words = [f"round, {outline.radius_m:g} m" if outline.radius_m else "point"]
    if outline.half_width_m:
        sides = (outline.ahead_m, outline.behind_m, outline.half_width_m)
        words = ["rectangle, " + " / ".join(f"{side:g}" for side in sides) + " m"]
    if body.actuation_delay_s:
        words.append(f"{body.actuation_delay_s:g} s late")
    if body.deceleration_mps2 is not None:
        words.append(f"brakes {body.deceleration_mps2:g} m/s²")
    return ", ".join(words)


def who_words(contract: PolicyContract) -> str:
    """Motion, rate and body, as limits are told apart."""
    return f"{motion_words(contract)}, {contract.rate_hz:g} Hz, {body_words(contract.body)}"
