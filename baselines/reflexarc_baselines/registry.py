"""All baselines by their names, each loaded when it is first asked for."""

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from reflexarc_baselines.baseline import Baseline, Remembering
from reflexarc_runtime.errors import UsageError

HOMES: Mapping[str, str] = MappingProxyType(
    {
        "braitenberg-2a": "anchors.braitenberg:Braitenberg2a",
        "braitenberg-2b": "anchors.braitenberg:Braitenberg2b",
        "rob-nav": "history.rob_nav:RobNav",
        "subsumption-0": "history.subsumption:Subsumption0",
        "subsumption-1": "history.subsumption:Subsumption1",
        "subsumption": "history.subsumption:Subsumption",
        "motor-schemas-sum": "history.motor_schemas:MotorSchemasSum",
        "motor-schemas-largest": "history.motor_schemas:MotorSchemasLargest",
        "layered-wander": "history.layered_reflexes:LayeredWander",
        "layered-perimeter": "history.layered_reflexes:LayeredPerimeter",
        "vfh-plus": "anchors.vfh_plus:VfhPlus",
        "follow-the-gap": "anchors.follow_the_gap:FollowTheGap",
        "bubble-gap": "anchors.bubble_gap:BubbleGap",
        "potential-field": "anchors.potential_field:PotentialField",
        "look-ahead": "anchors.look_ahead:LookAhead",
        "three-motions": "anchors.three_motions:ThreeMotions",
        "blind": "anchors.blind:Blind",
        "stereo": "history.stereo:Stereo",
        "closed-loop": "history.closed_loop:ClosedLoop",
        "evolved-viewing": "history.viewing_directions:ViewingDirections",
        "spiking-network": "history.spiking_network:SpikingNetwork",
        "flow-balance": "history.flow.flow_balance:FlowBalance",
        "flow-balance-always": "history.flow.flow_balance:FlowBalanceAlways",
        "flow-largest": "history.flow.flow_balance:FlowLargest",
        "flow-correlator": "history.flow.flow_balance:FlowCorrelator",
        "flow-emergency": "history.flow.flow_evasion:FlowEmergency",
        "flow-divergence": "history.flow.flow_evasion:FlowDivergence",
        "flow-regulation": "history.flow.flow_regulation:FlowRegulation",
    }
)
"""Name of a baseline → its module in this package, and its class."""

PYTHON_ONLY: Mapping[str, str] = MappingProxyType(
    {
        "follow-the-gap": "it sorts what it sees",
        "stereo": "it matches edges one after another",
        "closed-loop": "it decides for many genomes at once",
        "evolved-viewing": "it decides for many genomes at once",
        "flow-emergency": "it follows runs of rays, however long",
        "spiking-network": "its neurons run in a compiled loop",
    }
)
"""Baselines that no graph can hold, and why; all others export."""


def baseline_named(name: str) -> Baseline | Remembering:
    """The baseline of a name, with the parameters that it ships with.

    Raises:
        UsageError: no baseline has this name.
    """
    module, _, kind = source_of(name).partition(":")
    made: Baseline | Remembering = getattr(import_module(module), kind)()
    return made


def source_of(name: str) -> str:
    """`module:Class` of a baseline, from which any process can make it.

    Raises:
        UsageError: no baseline has this name.
    """
    if name not in HOMES:
        raise UsageError(f"baseline: none is named {name!r}; known: {', '.join(HOMES)}")
    return f"reflexarc_baselines.{HOMES[name]}"
