"""Checks whether a world is fair: whether avoiding obstacles is the only way to do well in it.

Three things are measured, without a trained policy.

**Lateral cover profile.** Where obstacles cover less than elsewhere an agent can hide, and learns
only to go there. The profile of a fair world is flat within 5 %: in a corridor, there are as many
obstacles beside the walls as in the middle. The walls themselves are seen, and can be touched.

**Blind contact rate.** In an even, unthinned Poisson field at rest an agent that never steers meets
2ρR obstacles a metre. A simulated one must do so too, or obstacles, vision and motion disagree.

**Clutter number** ρR²v/w: an agent can go on for ever only below a critical value (Karaman and
Frazzoli, arXiv 1202.0253), which for v = w lies between 0.20 and 0.25. A world above it is
hard, but not unfair.

Errors are standard errors. A world is called unfair only where it leaves a tolerance by four of
them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.evaluation.cover_profile import (
    BINS,
    CoverProfile,
    measure_profile,
    ratio,
)
from reflexarc_sim_bridge.evaluation.effort import Effort, effort_of
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.shapes import Rectangles
from reflexarc_sim_bridge.worlds.world import World, WorldSource

SEEDS = 64
MAX_SEEDS = 10_000
FLATNESS = 0.05
"""Largest share of the mean by which cover may deviate anywhere across."""
BLIND_TOLERANCE, BLIND_TOLERANCE_ROUND = 0.02, 0.05
"""Largest deviation from 2ρR, for upright boxes and for other shapes: after a contact with one of
those, some agents meet a wider part of it again."""
CRITICAL_CLUTTER = 0.25
"""Above it, at equal speeds ahead and aside, no agent can go on for ever."""

_SURE = 4.0
"""Standard errors by which a tolerance must be exceeded."""
_BLIND_AGENTS, _BLIND_STEPS, _DISCARDED_STEPS = 1024, 1000, 50
_FEWEST_AGENTS = 64
_SIDES = 0.1
"""Share of the width that counts as a side."""


@dataclass(frozen=True)
class WorldReport:
    """What was measured of a world, and the verdict."""

    name: str
    fair: bool
    reasons: tuple[str, ...]
    """Why it is unfair, in words; none for a fair world."""
    notes: tuple[str, ...]
    """Other remarks, in words."""
    seeds: int
    cover: float
    """Share of the plane that obstacles cover."""
    flatness: float
    """Largest deviation of a bin's cover, as a share of the mean."""
    flatness_error: float
    """Its standard error."""
    blind_contacts_per_100m: float
    """Of a simulated agent that never steers."""
    blind_error: float
    """Its standard error."""
    expected_blind_contacts_per_100m: float | None
    """100 · 2ρR, the mean over seeds; None where that is not known."""
    mean_free_path_m: float | None
    """From contact to contact of that agent; None without any contact."""
    clutter: float
    """ρR²v/w at equal speeds, of the scattered obstacles; the mean over seeds."""
    lateral_m: tuple[float, ...]
    """Middles of the profile's bins, from the right side on."""
    profile: tuple[float, ...]
    """Cover of each bin."""
    profile_error: tuple[float, ...]
    """Standard error of each bin's cover, without that of the mean."""


def check_world(
    source: WorldSource,
    seeds: int = SEEDS,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> WorldReport:
    """Measure a world, or a family of worlds, on its first seeds.

    Args:
        source: the world.
        seeds: how many, 2 or more.
        progress: called with what is done, and how much there is in all.

    Raises:
        WorldError: too few or too many seeds, or a world that cannot be simulated.
    """
    if not 2 <= seeds <= MAX_SEEDS:
        raise WorldError(f"seeds: expected 2 to {MAX_SEEDS}, got {seeds}")
    profile = measure_profile(source, range(seeds), lambda n, of: progress(n, 2 * of))
    contacts = _blind_rate(source, seeds, profile.mean, lambda n, of: progress(of + n, 2 * of))
    worlds = [source.drawn(seed) for seed in range(seeds)]
    return _report(source.name, worlds, profile, *contacts)


def _report(
    name: str, worlds: list[World], profile: CoverProfile, blind: float, error: float, steps: int
) -> WorldReport:
    """The verdict on a world, by what was measured of it.

    Args:
        name: the world's.
        worlds: the worlds of its seeds.
        profile: their cover.
        blind: contacts per 100 m of an agent that never steers.
        error: the standard error of that.
        steps: that each of them made.
    """
    expected = _expected_blind(worlds)
    clutter = math.fsum(world.clutter() for world in worlds) / len(worlds)
    worst = int(np.abs(profile.deviation).argmax())
    reasons = (*_unevenness(profile), *_disagreement(worlds[0], blind, error, expected))
    return WorldReport(
        name=name,
        fair=not reasons,
        reasons=reasons,
        notes=_notes(profile, clutter, blind, steps),
        seeds=len(worlds),
        cover=profile.mean,
        flatness=float(np.abs(profile.deviation[worst])),
        flatness_error=float(profile.error[worst]),
        blind_contacts_per_100m=blind,
        blind_error=error,
        expected_blind_contacts_per_100m=expected,
        mean_free_path_m=100.0 / blind if blind > 0.0 else None,
        clutter=clutter,
        lateral_m=tuple(profile.lateral_m.tolist()),
        profile=tuple(profile.cover.tolist()),
        profile_error=tuple((profile.error * profile.mean).tolist()),
    )


def _blind_rate(
    source: WorldSource, seeds: int, cover: float, progress: Callable[[int, int], None]
) -> tuple[float, float, int]:
    """Contacts per 100 m of agents that never steer, its standard error, and the steps of each.

    Each agent has a seed of its own; in a family, whose worlds differ by seed, one of `seeds`.
    The discarded steps tell how often they meet something, and so what a step costs.
    """
    efforts = [effort_of(world, reference_contract(), BINS) for world in source.fullest]
    agents = max(blind_agents(efforts), seeds)
    worlds = agents if isinstance(source, World) else seeds
    own = np.resize(np.arange(worlds), agents)
    simulation = Simulation(source, reference_contract(), own.astype(np.uint64))
    _go_on(simulation, _DISCARDED_STEPS, lambda n: progress(n, _DISCARDED_STEPS + _BLIND_STEPS))
    contacts, distance_m = simulation.contacts.copy(), simulation.distance_m.copy()
    met_a_step = float(contacts.mean()) / _DISCARDED_STEPS
    most = min(effort.most_steps(met_a_step, cover) for effort in efforts) / agents
    steps = min(_BLIND_STEPS, max(_DISCARDED_STEPS, int(most)))
    _go_on(simulation, steps, lambda n: progress(_DISCARDED_STEPS + n, _DISCARDED_STEPS + steps))
    # Agents of one seed meet the same obstacles: together they are one sample.
    met, gone_m = np.zeros((worlds, 1)), np.zeros(worlds)
    np.add.at(met[:, 0], own, simulation.contacts - contacts)
    np.add.at(gone_m, own, simulation.distance_m - distance_m)
    rate, error = ratio(100.0 * met, gone_m)
    return float(rate[0]), float(error[0]), steps


def blind_agents(efforts: list[Effort]) -> int:
    """As many as may make the discarded steps in a third of the time, if nothing is met."""
    most = min(effort.most_steps(0.0, 0.0) for effort in efforts)
    return min(_BLIND_AGENTS, max(_FEWEST_AGENTS, int(most / _DISCARDED_STEPS / 3)))


def _go_on(simulation: Simulation, steps: int, progress: Callable[[int], None]) -> None:
    """Let all agents go straight on."""
    onwards = np.zeros(len(simulation.contacts), np.int64)
    for step in range(steps):
        simulation.step(onwards)
        progress(step + 1)


def _expected_blind(worlds: list[World]) -> float | None:
    known = [world.blind_contacts_per_100m for world in worlds]
    rates = [rate for rate in known if rate is not None]
    return math.fsum(rates) / len(rates) if len(rates) == len(known) else None


def _unevenness(profile: CoverProfile) -> tuple[str, ...]:
    """Why the profile is unfair, in words; empty if it is not."""
    beyond = np.abs(profile.deviation) - FLATNESS - _SURE * profile.error
    if beyond.max() <= 0.0:
        return ()
    lowest = int(profile.deviation.argmin())
    if beyond[lowest] <= 0.0:
        lowest = int(profile.deviation.argmax())
    where, share = _place(lowest, profile), 1.0 + profile.deviation[lowest]
    meaning = "an agent can hide there" if share < 1.0 else "there are fewer obstacles elsewhere"
    return (f"cover {where} is {share:.0%} of the mean: {meaning}",)


def _place(bin_number: int, profile: CoverProfile) -> str:
    bins = len(profile.cover)
    if min(bin_number, bins - 1 - bin_number) < _SIDES * bins:
        return "at the sides"
    from_m, to_m = (profile.width_m * edge / bins for edge in (bin_number, bin_number + 1))
    return f"between {from_m:.1f} and {to_m:.1f} m from the right"


def _disagreement(
    world: World, blind: float, error: float, expected: float | None
) -> tuple[str, ...]:
    """Why the contacts of a blind agent are not as expected, in words; empty if they are."""
    if expected is None:
        return ()
    tolerance = BLIND_TOLERANCE if _is_all_upright(world) else BLIND_TOLERANCE_ROUND
    if abs(blind - expected) <= tolerance * expected + _SURE * error:
        return ()
    return (
        f"an agent that never steers has {blind:.1f} contacts per 100 m, and 2ρR says "
        f"{expected:.1f}: contacts do not match the obstacles",
    )


def _is_all_upright(world: World) -> bool:
    shapes = [s for layer in world.layers if isinstance(layer, Scatter) for s in layer.shapes]
    upright = (isinstance(shape, Rectangles) and not shape.is_turned for shape in shapes)
    return all(upright) and world.chassis.radius_m == 0.0


def _notes(profile: CoverProfile, clutter: float, blind: float, steps: int) -> tuple[str, ...]:
    notes = []
    if steps < _BLIND_STEPS:
        notes.append(
            f"so much is near an agent that it made {steps} steps only, of {_BLIND_STEPS}: rates "
            "are known less well"
        )
    if blind == 0.0:
        notes.append("an agent that never steers has no contacts here")
    if round(clutter, 2) > CRITICAL_CLUTTER:
        notes.append(
            f"clutter {clutter:.2f}: above {CRITICAL_CLUTTER} contacts cannot be avoided for ever"
        )
    unsure = float(profile.error.max())
    if unsure > FLATNESS / 2:
        notes.append(
            f"obstacles are rare: the profile is known to ±{unsure:.0%} only; take more seeds"
        )
    return tuple(notes)
