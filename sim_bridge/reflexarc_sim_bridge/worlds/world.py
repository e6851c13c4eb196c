"""A world: its layers of obstacles, its sides, and the senses and the chassis of a body in it.

Frame: x ahead, y to the left, metres. A world is endless along x. In an even Poisson field an agent
that never steers meets 2ρR obstacles a metre, R being half their mean lateral width plus the
agent's radius, so such a world says what a blind agent must score.

Worlds that have a name are in `files.py`.
"""

import math
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_sim_bridge.worlds import stepping
from reflexarc_sim_bridge.worlds.checks import Span, require, require_within
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, chunks_across
from reflexarc_sim_bridge.worlds.layers import Corridor, Gates, Layer, Scatter

MAX_LAYERS = 5
"""One at rest and four that move."""
MAX_DEAD_SECTORS = 8
MAX_DELAY_S = 1000.0


class Edges(StrEnum):
    """What lies at the sides of a world."""

    PERIODIC = "periodic"
    """Leaving at one side is entering at the other; cover is the same everywhere."""
    UNBOUNDED = "unbounded"
    """There are no sides; a corridor's walls, where there is one, hold the agent."""
    OPEN = "open"
    """The paper's: sideways motion ends at 0 and at the width, nothing is seen there, and
    obstacles are placed whole between the two, so that the edges are thinly covered."""


class AfterContact(StrEnum):
    """What follows a contact."""

    RESPAWN = "respawn"
    """The agent goes on at the same x, at a y drawn uniformly among the free places."""
    GHOST = "ghost"
    """It passes through, sees nothing but the obstacle, and can touch again once it is clear."""
    TERMINATE = "terminate"
    """As `respawn`, and an episode ends there."""


@dataclass(frozen=True)
class Scanner:
    """A planar range scanner: beams at equal angles, the outermost ones at ±half of the sweep."""

    beams: int = 181
    """Beams of one sweep, 2 or more."""
    sweep_rad: float = math.pi
    """Angle from the first beam to the last, in (0, 2π)."""

    def __post_init__(self) -> None:
        require(2 <= self.beams <= 100_000, "scanner.beams", "2 to 100000", self.beams)
        fits = 0.0 < self.sweep_rad < 2 * math.pi
        require(fits, "scanner.sweep_rad", "in (0, 2π)", self.sweep_rad)

    @property
    def start_rad(self) -> float:
        """Bearing of the first, rightmost beam."""
        return -self.sweep_rad / 2

    @property
    def step_rad(self) -> float:
        """Angle from one beam to the next."""
        return self.sweep_rad / (self.beams - 1)


@dataclass(frozen=True)
class Senses:
    """What goes wrong on the way from the light to the retina. By default nothing."""

    noise: float = 0.0
    """Standard deviation that is added to every value of a retina, as a share of full scale; drawn
    anew at every look, so that an eye that looks more often is disturbed as often."""
    dropout: float = 0.0
    """Probability that a ray reads 0, drawn anew at every look, however many there are a second."""
    dead_sectors: tuple[Span, ...] = ()
    """Bearings on the body, lowest and highest (rad, to the left positive), between which rays read
    0, wherever the contract says that they look."""
    latency_s: float = 0.0
    """A retina is so old when the agent sees it, to the nearest step and, if above 0, one step at
    least."""
    gap_s: float = 0.0
    """Longest time from one new retina to the next: it comes after 1 to n steps, drawn evenly each
    time, n being the whole steps within that time, one at least. In between the last one stays: a
    slow sensor, with jitter and lost scans."""
    background: float = 0.0
    """Value of a ray that meets nothing within its range, as a share of full scale."""
    permuted: int = 0
    """Seed of a permutation of each eye's rays, the same for all agents; 0: in their order. What
    the contract says of their bearings is then wrong, and nobody is told."""
    mounted_rad: float = 0.0
    """Each eye is turned on the body by this angle, to the left positive, while the contract goes
    on to say that its middle looks ahead."""

    def __post_init__(self) -> None:
        require_within("senses.noise", self.noise, 0.0, 1.0)
        require_within("senses.dropout", self.dropout, 0.0, 1.0)
        few = len(self.dead_sectors) <= MAX_DEAD_SECTORS
        require(few, "senses.dead_sectors", f"at most {MAX_DEAD_SECTORS}", len(self.dead_sectors))
        for low_rad, high_rad in self.dead_sectors:
            holds = -math.tau <= low_rad <= high_rad <= math.tau
            require(holds, "senses.dead_sectors", "(low, high) rad", (low_rad, high_rad))
        require_within("senses.latency_s", self.latency_s, 0.0, MAX_DELAY_S)
        require_within("senses.gap_s", self.gap_s, 0.0, MAX_DELAY_S)
        require_within("senses.background", self.background, 0.0, 1.0)
        fits = 0 <= self.permuted < 1 << 63
        require(fits, "senses.permuted", "a seed, 0 to 2⁶³ − 1", self.permuted)
        require_within("senses.mounted_rad", self.mounted_rad, -math.pi, math.pi)


@dataclass(frozen=True)
class Chassis:
    """The body's size, and how it follows its commands. By default a point that obeys at once."""

    radius_m: float = 0.0
    """Of the agent, a disc; its eye is in the middle."""
    slip: float = 0.0
    """Standard deviation of every speed over `slip_over_s`, as a share of it. It is drawn anew at
    every step, so that way and turn after a given time deviate as much, whatever a step lasts."""
    slip_over_s: float = 0.1
    """For which time the slip is told. A file that tells none means its own `dt_s`."""
    lag_s: float = 0.0
    """Time constant with which speeds follow a command (first order)."""
    acceleration_mps2: float = math.inf
    """Most that a linear speed can change in a second."""
    turn_acceleration_radps2: float = math.inf
    """Most that the angular speed can change in a second."""
    after_contact: AfterContact = AfterContact.RESPAWN
    """What follows a contact."""

    def __post_init__(self) -> None:
        require_within("chassis.radius_m", self.radius_m, 0.0, 1.0)
        require_within("chassis.slip", self.slip, 0.0, 1.0)
        stepping.require_duration("chassis.slip_over_s", self.slip_over_s)
        require_within("chassis.lag_s", self.lag_s, 0.0, 100.0)
        for name in ("acceleration_mps2", "turn_acceleration_radps2"):
            value = getattr(self, name)
            require(value > 0.0, f"chassis.{name}", "above 0", value)


@dataclass(frozen=True)
class World:
    """An endless field of obstacles. With a seed it is one world, to the bit."""

    name: str
    description: str = ""
    """One sentence: what it is for."""
    width_m: float = 20.0
    """Lateral period (periodic), width (open), or width of the strip of starting places."""
    edges: Edges = Edges.PERIODIC
    layers: tuple[Layer, ...] = field(default_factory=lambda: (Scatter(),))
    """What fills it."""
    senses: Senses = field(default_factory=Senses)
    chassis: Chassis = field(default_factory=Chassis)
    limits: BodyLimits = field(default_factory=BodyLimits)
    """What a body on the bus does at most, whatever it is told; training does not ask for them."""
    dt_s: float = 0.1
    """Duration of a step. With another one it is the same world, in finer or coarser steps."""
    scanner: Scanner | None = None
    """Agents see through this scanner, by the rule of their eye; None: along their rays."""
    stream: int = 0
    """Worlds of one seed and different streams share no random number."""

    def __post_init__(self) -> None:
        require_within("width_m", self.width_m, 1.0, 1e4)
        stepping.require_duration("dt_s", self.dt_s)
        stepping.require_latency(self.senses.latency_s, self.dt_s)
        stepping.require_gap(self.senses.gap_s, self.dt_s)
        require(0 <= self.stream < 1 << 32, "stream", "0 to 2³² − 1", self.stream)
        require(len(self.layers) <= MAX_LAYERS, "layers", f"at most {MAX_LAYERS}", len(self.layers))
        self._check_open_sides()
        self._check_corridors()
        self._check_gates()

    @property
    def body(self) -> BodySpec:
        """Its body, as a contract names it: what follows with a lag, stops as late as that lag."""
        braking = self.chassis.acceleration_mps2
        return BodySpec(
            Footprint(radius_m=self.chassis.radius_m),
            self.chassis.lag_s,
            braking if math.isfinite(braking) else None,
        )

    @property
    def latency_steps(self) -> int:
        """A retina is so many steps old when the agent sees it."""
        return stepping.latency_steps(self.senses.latency_s, self.dt_s)

    @property
    def gap_steps(self) -> int:
        """A new retina comes after 1 to so many steps."""
        return stepping.gap_steps(self.senses.gap_s, self.dt_s)

    @property
    def slip_per_step(self) -> float:
        """Standard deviation of every speed in one step, as a share of it."""
        chassis = self.chassis
        return stepping.slip_per_step(chassis.slip, chassis.slip_over_s, self.dt_s)

    @property
    def reach_m(self) -> float:
        """No obstacle reaches farther from its centre."""
        return max((layer.reach_m for layer in self.layers), default=0.0)

    @property
    def corridor(self) -> Corridor | None:
        """The walls that hold the agent, if there are any."""
        return next((layer for layer in self.layers if isinstance(layer, Corridor)), None)

    @property
    def period_m(self) -> float | None:
        """Width after which the world repeats; None: it does not."""
        return self.width_m if self.edges is Edges.PERIODIC else None

    @property
    def chunks_across(self) -> int:
        """How many chunks lie from side to side; 0 where there are no sides."""
        return 0 if self.edges is Edges.UNBOUNDED else chunks_across(self.width_m)

    @property
    def chunk_width_m(self) -> float:
        """Side of a chunk along y."""
        return self.width_m / self.chunks_across if self.chunks_across else CHUNK_M

    @property
    def blind_contacts_per_100m(self) -> float | None:
        """What an agent that never steers scores: 100 · 2ρR; None where that is not known.

        Known in even, unthinned Poisson fields at rest, by the mean free path. Exact for
        rectangles. Beside the disc just met, its wider part still lies ahead, and a new place there
        meets it again: on discs 20 m wide a blind agent scores 3.4 % more. Ghosts begin to touch
        less often: where obstacles overlap they touch the next one before they are clear.
        """
        if self.edges is Edges.OPEN or self.chassis.after_contact is AfterContact.GHOST:
            return None
        met_per_m = 0.0
        for layer in self.layers:
            if not (isinstance(layer, Scatter) and layer.is_poisson):
                return None
            met_per_m += layer.density_per_m2 * (layer.mean_width_m + 2 * self.chassis.radius_m)
        return 100.0 * met_per_m

    def clutter(self, forward_mps: float = 1.0, lateral_mps: float = 1.0) -> float:
        """Clutter number ρR²v/w of all scattered obstacles together (Karaman and Frazzoli)."""
        scatters = [layer for layer in self.layers if isinstance(layer, Scatter)]
        density = math.fsum(layer.mean_density_per_m2 for layer in scatters)
        if density == 0.0:
            return 0.0
        widths = math.fsum(layer.mean_density_per_m2 * layer.mean_width_m for layer in scatters)
        half_m = widths / density / 2 + self.chassis.radius_m
        return density * half_m**2 * forward_mps / lateral_mps

    @property
    def fullest(self) -> "tuple[World, ...]":
        """The worlds of a family that need most memory: itself, for there is no other."""
        return (self,)

    def drawn(self, seed: int) -> "World":
        """The world of a seed: itself. Worlds with ranges draw their numbers here."""
        del seed
        return self

    def _check_open_sides(self) -> None:
        if self.edges is not Edges.OPEN:
            return
        scattered = all(isinstance(layer, Scatter) for layer in self.layers)
        require(scattered, "edges", "open sides with scatter layers only", self.edges)
        fits = 2 * self.reach_m <= self.width_m
        require(fits, "layers", f"sizes up to the width, {self.width_m} m", 2 * self.reach_m)
        at_rest = all(layer.motion is None for layer in self.layers)
        require(at_rest, "edges", "open sides with layers at rest", "a motion")

    def _check_corridors(self) -> None:
        corridors = sum(isinstance(layer, Corridor) for layer in self.layers)
        require(corridors <= 1, "layers", "at most one corridor", corridors)
        if not corridors:
            return
        unbounded = self.edges is Edges.UNBOUNDED
        require(unbounded, "edges", "unbounded, as a corridor has its own walls", self.edges)
        solid = self.chassis.after_contact is not AfterContact.GHOST
        require(solid, "chassis.after_contact", "no ghost: walls hold", "ghost")
        room_m = self.corridor.width_m - 2 * self.chassis.radius_m if self.corridor else 0.0
        require(room_m > 0.0, "chassis.radius_m", "room within the corridor", room_m)

    def _check_gates(self) -> None:
        for number, layer in enumerate(self.layers):
            if isinstance(layer, Gates):
                pitch_m = layer.fitted_pitch_m(self.period_m)
                fits = layer.opening_m[1] < pitch_m
                expected = f"below the pitch, which is {pitch_m:g} m in this width"
                require(fits, f"layers[{number}].opening_m", expected, layer.opening_m)


class WorldSource(Protocol):
    """A world, or a family of worlds from which every seed draws its own."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def description(self) -> str:
        """One sentence: what it is for."""

    @property
    def blind_contacts_per_100m(self) -> float | None:
        """See `World`; None for a family."""

    @property
    def fullest(self) -> tuple[World, ...]:
        """Worlds at the ends of all ranges: no other of the family needs more memory."""

    def drawn(self, seed: int) -> World:
        """The world of a seed, 0 to 2⁶⁴ − 1."""
