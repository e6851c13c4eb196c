"""Frames of one agent in its world, seen from above, as Gymnasium's `render` gives them.

The look is that of `reflexarc render`: pale ground, obstacles in their colours, the agent with its
path and its rays, the picture around the agent. NumPy alone draws them.
"""

import numpy as np

from reflexarc_sim_bridge.environments.raster import Pixels, Raster
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.world_scenery import WorldScenery
from reflexarc_sim_bridge.worlds.silhouettes import Area, Floats, Rgb
from reflexarc_sim_bridge.worlds.world import AfterContact, Edges

SIDE_PX = 480
"""Width and height of a frame."""
LEAST_RANGE_M, MOST_RANGE_M = 2.0, 20.0
"""Bounds of the range that sets the scale, whatever the eye's own range is."""
MARGIN = 1.15
"""What is shown to each side of the agent, as a multiple of the eye's range."""
MOST_PATH = 400
"""Steps of the path that are shown."""

_GROUND: Rgb = (0.961, 0.953, 0.933)
_INK: Rgb = (0.16, 0.18, 0.22)
_AGENT: Rgb = (0.784, 0.251, 0.184)
_BODY: Rgb = (0.478, 0.137, 0.094)
_CONTACT: Rgb = (0.95, 0.75, 0.1)
_WHITE: Rgb = (1.0, 1.0, 1.0)
_ARROW = np.array([(1.0, 0.0), (-0.55, 0.6), (-0.25, 0.0), (-0.55, -0.6)])
_NOSE = 0.06
"""Half the length of the agent's arrow, as a share of the range."""


class EpisodeFrames:
    """Draws the first agent of a simulation, and remembers the path of its episode.

    Args:
        simulation: where it drives. Drawing reads it and changes nothing.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._range_m = min(max(simulation.contract.retina.range_m, LEAST_RANGE_M), MOST_RANGE_M)
        self.begin()

    def begin(self) -> None:
        """An episode begins, in the world that the simulation now has."""
        self._scenery = WorldScenery(self._simulation)
        world = self._simulation.world.drawn(int(self._state["seed"]))
        self._period_m = world.width_m if world.edges is Edges.PERIODIC else None
        self._radius_m = world.chassis.radius_m
        self._is_put = world.chassis.after_contact is not AfterContact.GHOST
        self._path: list[tuple[float, float]] = [self._place()]
        self._jumps: set[int] = set()
        self._contacts: list[tuple[float, float]] = []
        self._met = False

    def went_on(self, *, met: bool) -> None:
        """The agent took a step, which ended in a contact or not."""
        if met:
            self._contacts.append(self._path[-1])
        self._met = met
        self._path = [*self._path[1 - MOST_PATH :], self._place(self._path[-1][1])]
        self._jumps = {k - (len(self._path) == MOST_PATH) for k in self._jumps}
        if met and self._is_put:
            self._jumps.add(len(self._path) - 1)

    def frame(self) -> Pixels:
        """The picture now: (side, side, 3), a new array."""
        (x_m, y_m), half_m = self._path[-1], MARGIN * self._range_m
        area = Area(x_m - half_m, x_m + half_m, y_m - half_m, y_m + half_m)
        raster = Raster(area, SIDE_PX, _GROUND)
        self._paint_obstacles(raster, area)
        self._paint_rays(raster)
        self._paint_path(raster)
        self._paint_agent(raster)
        return raster.pixels()

    @property
    def _state(self) -> np.void:
        state: np.void = self._simulation.params.agents.state[0]
        return state

    def _place(self, last_y_m: float | None = None) -> tuple[float, float]:
        """Where it is; where the world repeats, y goes on without a jump."""
        x_m, y_m = float(self._simulation.x_m[0]), float(self._simulation.y_m[0])
        if last_y_m is not None and self._period_m is not None:
            y_m += self._period_m * round((last_y_m - y_m) / self._period_m)
        return x_m, y_m

    def _paint_obstacles(self, raster: Raster, area: Area) -> None:
        time_s = float(self._state["steps"]) * self._simulation.dt_s
        for shown in self._scenery.within(area, time_s):
            raster.polygon(shown.corners_m, shown.colour)
            if any(shown.wake_m):
                middle = shown.corners_m.mean(axis=0)
                ends = middle[np.newaxis] - np.array([shown.wake_m]), middle[np.newaxis]
                raster.lines(*ends, 1.5, shown.colour, 0.6)

    def _paint_rays(self, raster: Raster) -> None:
        eye, (x_m, y_m) = self._simulation.contract.retina, self._path[-1]
        rays_m = self._simulation.distances().astype(np.float64)
        heading = float(self._simulation.heading_rad[0])
        left_m = eye.baseline_m / 2 if eye.eyes == 2 else 0.0
        from_m = np.array([x_m - left_m * np.sin(heading), y_m + left_m * np.cos(heading)])
        angles = heading + self._simulation.bearings_rad
        to_m = from_m + rays_m[:, np.newaxis] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        begins, meets = np.broadcast_to(from_m, to_m.shape), rays_m < eye.range_m
        raster.lines(begins[~meets], to_m[~meets], 0.5, _AGENT, 0.4)
        raster.lines(begins[meets], to_m[meets], 1.0, _AGENT, 0.6)
        for spot_x_m, spot_y_m in to_m[meets]:
            raster.disc(spot_x_m, spot_y_m, 0.01 * self._range_m, _AGENT)

    def _paint_path(self, raster: Raster) -> None:
        path: Floats = np.array(self._path)
        driven = [k for k in range(1, len(path)) if k not in self._jumps]
        before = [k - 1 for k in driven]
        raster.lines(path[before], path[driven], 1.5, _INK, 1.0)
        for x_m, y_m in self._contacts:
            raster.disc(x_m, y_m, 0.025 * self._range_m, _INK)
            raster.disc(x_m, y_m, 0.018 * self._range_m, _CONTACT)

    def _paint_agent(self, raster: Raster) -> None:
        (x_m, y_m), heading = self._path[-1], float(self._simulation.heading_rad[0])
        if self._radius_m > 0.0:
            raster.disc(x_m, y_m, self._radius_m, _BODY)
        sin, cos = np.sin(heading), np.cos(heading)
        turn = np.array([[cos, sin], [-sin, cos]])
        for size, colour in ((1.25, _WHITE), (1.0, _CONTACT if self._met else _AGENT)):
            arrow = size * _NOSE * self._range_m * _ARROW @ turn
            raster.polygon(np.array([x_m, y_m]) + arrow, colour)
