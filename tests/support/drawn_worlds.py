"""Hypothesis strategies: any world, any eye, any scene of a few obstacles."""

import math

from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.worlds.layers import (
    Automaton,
    Corridor,
    Drift,
    Gates,
    Layer,
    Scatter,
    Swing,
)
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, Edges, Senses, World
from support.slow_geometry import box, disc, star

TURNING = (
    Action("ahead", 2.0, 0.0),
    Action("left", 1.0, 0.5, 4.0),
    Action("right", 1.0, 0.0, -3.0),
)
SIDEWAYS = sideways_actions(2.0, 3.0)

_COLOURS = [((1.0, 1.0),), ((0.2, 1.0),), ((0.1, 1.0), (0.0, 0.9), (0.4, 0.6))]
_SHAPES = [
    Rectangles(),
    Rectangles(width_m=(0.1, 2.0), turned_rad=(-1.0, 2.0)),
    Discs(),
    Polygons(),
    Polygons(corners=(5, 32), dent=(0.1, 0.6)),
    Curves(waviness=(0.0, 0.8)),
]
_MOTIONS = [None, None, Drift(-1.5, 0.4), Swing(0.5, 2.0, 3.0)]


def _scatter(motion: bool) -> st.SearchStrategy[Scatter]:
    return st.builds(
        Scatter,
        density_per_m2=st.sampled_from([0.05, 0.2, 0.3]),
        shapes=st.lists(st.sampled_from(_SHAPES), min_size=1, max_size=3).map(tuple),
        gap_m=st.sampled_from([0.0, 0.0, 1.0]),
        sections=st.sampled_from([(), (), (0.0, 1.5)]),
        section_m=st.sampled_from([2.5, 10.0]),
        colour=st.sampled_from(_COLOURS),
        motion=st.sampled_from(_MOTIONS) if motion else st.none(),
    )


_MOVING: st.SearchStrategy[Layer] = st.one_of(
    _scatter(True),
    _scatter(True),
    st.builds(
        Gates,
        spacing_m=st.just(5.0),
        pitch_m=st.sampled_from([4.0, 10.0]),
        colour=st.sampled_from(_COLOURS),
        motion=st.sampled_from(_MOTIONS),
    ),
    st.builds(
        Automaton,
        fill=st.sampled_from([0.1, 0.2]),
        colour=st.sampled_from(_COLOURS),
        motion=st.sampled_from(_MOTIONS),
    ),
)
_CORRIDORS = st.builds(
    Corridor,
    width_m=st.sampled_from([4.0, 9.0]),
    meander_m=st.sampled_from([0.0, 3.0]),
    wavelength_m=st.sampled_from([10.0, 40.0]),
    colour=st.sampled_from(_COLOURS),
)
_CHASSIS = st.builds(Chassis, radius_m=st.sampled_from([0.0, 0.0, 0.25]))
_SENSES = st.builds(Senses, background=st.sampled_from([0.0, 0.0, 0.3]))


def _world(edges: Edges, layers: st.SearchStrategy[tuple[Layer, ...]]) -> st.SearchStrategy[World]:
    return st.builds(
        World,
        st.just("drawn"),
        width_m=st.sampled_from([6.0, 20.0]),
        edges=st.just(edges),
        layers=layers,
        senses=_SENSES,
        chassis=_CHASSIS,
    )


worlds = st.one_of(
    _world(Edges.PERIODIC, st.lists(_MOVING, min_size=1, max_size=3).map(tuple)),
    _world(Edges.UNBOUNDED, st.lists(_MOVING, min_size=1, max_size=2).map(tuple)),
    _world(Edges.UNBOUNDED, st.tuples(_CORRIDORS, _scatter(True))),
    _world(Edges.OPEN, st.tuples(_scatter(False))),
)

eyes = st.builds(
    lambda eyes, baseline_m, **fields: RetinaSpec(
        eyes=eyes, baseline_m=baseline_m if eyes == 2 else 0.0, **fields
    ),
    st.sampled_from([1, 1, 2]),
    st.sampled_from([0.1, 0.6]),
    rays=st.sampled_from([8, 16, 17, 33, 256]),
    fov_rad=st.sampled_from([math.pi / 3, math.pi, 4.7, math.tau]),
    range_m=st.sampled_from([0.8, 3.0, 5.0]),
    shading=st.sampled_from(Shading),
    channels=st.sampled_from([1, 3]),
    samples=st.sampled_from([1, 1, 4]),
    beams=st.sampled_from(BeamRule),
)

contracts = st.builds(PolicyContract, retina=eyes, actions=st.sampled_from([TURNING, SIDEWAYS]))

_places = st.floats(-4.0, 5.0).map(lambda v: round(v, 3))
_sizes = st.floats(0.05, 1.5).map(lambda v: round(v, 3))
_shades = st.integers(1, 255).map(lambda v: v / 255)
_tints = st.tuples(_shades, _shades, _shades)


@st.composite
def _star(draw: st.DrawFn) -> Outline:
    corners = draw(st.integers(3, 24))
    outline: Outline = star(
        draw(_places),
        draw(_places),
        draw(_sizes),
        corners,
        draw(st.sampled_from([0.0, 0.4])) if corners > 4 else 0.0,
        draw(st.floats(0.0, math.tau)),
        draw(_tints),
    )
    return outline


stars = _star()
outlines = st.one_of(
    st.builds(box, _places, _places, _sizes, _sizes, _tints),
    st.builds(box, _places, _places, _sizes, _sizes, _tints, st.floats(0.0, math.pi)),
    st.builds(disc, _places, _places, _sizes, _tints),
    stars,
)
scenes = st.lists(outlines, max_size=6)
headings = st.one_of(st.just(0.0), st.floats(-math.pi, math.pi).map(lambda v: round(v, 3)))
