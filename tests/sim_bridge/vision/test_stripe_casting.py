import dataclasses
import itertools
import math

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import parse_world, world_named
from reflexarc_sim_bridge.worlds.layers import Corridor, Drift, Layer, Scatter
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.shapes import Discs, Rectangles
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.drawn_worlds import SIDEWAYS, TURNING
from support.plain_stripes import StripedCorridor
from support.slow_geometry import Floats, ray_lengths_m
from support.slow_world import directions_rad, eye_place_m

GREY = ((0.0, 1.0),)
STRAIGHT = Corridor(4.0, 0.0, colour=GREY, stripes_m=0.5)
COLOUR = {"shading": Shading.COLOUR}
FINE = PolicyContract(retina=RetinaSpec(rays=32, **COLOUR), actions=TURNING)  # type: ignore[arg-type]  # by name


def corridor(walls: Corridor = STRAIGHT, *others: Layer) -> World:
    return World("corridor", width_m=4.0, edges=Edges.UNBOUNDED, layers=(walls, *others))


def seeds(count: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint64]]:
    return np.arange(count, dtype=np.uint64)


def put(simulation: Simulation, agent: int, x_m: float, y_m: float, heading_rad: float) -> None:
    """Stand somewhere else; what is near is listed at the next move."""
    state = simulation.params.agents.state
    for name, at_m in (("x", x_m), ("y", y_m)):
        state[f"cell_{name}"][agent] = math.floor(at_m / 2.5)
        state[f"{name}_m"][agent] = at_m - 2.5 * math.floor(at_m / 2.5)
    state["heading_rad"][agent] = heading_rad


def look_from(world: World, x_m: float, y_m: float, steps: int) -> Floats:
    """What an agent without a heading sees from there after some steps: (rays,)."""
    simulation = Simulation(world, FINE, seeds(1))
    put(simulation, 0, x_m, y_m, 0.0)
    simulation.params.agents.state["steps"] = steps - 1
    assert not simulation.drive(0.0, 0.0, 0.0)
    return simulation.sense()[0, 0, :, 0].astype(float)


@pytest.mark.parametrize("speeds_mps", [(0.0, 0.0), (-0.7, 1.3)])
@pytest.mark.parametrize("shading", Shading)
@pytest.mark.parametrize("samples", [1, 16])
@pytest.mark.parametrize("actions", [SIDEWAYS, TURNING])
def test_each_ray_shows_the_stripes_that_its_samples_meet(
    speeds_mps: tuple[float, float], shading: Shading, samples: int, actions: object
) -> None:
    right_mps, left_mps = speeds_mps
    walls = dataclasses.replace(STRAIGHT, right_wall_mps=right_mps, left_wall_mps=left_mps)
    spec = RetinaSpec(shading=shading, samples=samples)
    simulation = Simulation(corridor(walls), PolicyContract(spec, actions), seeds(4))  # type: ignore[arg-type]  # either
    plain = [StripedCorridor(seed, 4.0, 0.5, speeds_mps) for seed in range(4)]
    put(simulation, 3, -1e6, 0.5, 0.0)
    generator, respawned = np.random.default_rng(1), 0
    for step in range(1, 40):
        respawned += int(simulation.step(generator.integers(0, 3, 4)).sum())
        values = simulation.sense()[:, 0, :, 0]
        for i in range(4):
            place = simulation.x_m[i], simulation.y_m[i], simulation.heading_rad[i]
            bounds = np.array(plain[i].values(spec, *place, step * 0.1))
            assert (values[i] >= bounds[:, 0] - 0.51).all()
            assert (values[i] <= bounds[:, 1] + 0.51).all()
            assert samples == 1 or np.ptp(bounds, axis=1).max() < 80  # bounds that say something
    assert respawned or actions is TURNING


def test_a_moving_wall_looks_as_one_at_rest_from_farther_back() -> None:
    moving = corridor(dataclasses.replace(STRAIGHT, left_wall_mps=0.5))
    here = look_from(moving, 7.0, 0.3, steps=40)
    still, back = (look_from(corridor(), x_m, 0.3, steps=40) for x_m in (7.0, 7.0 - 0.5 * 4.0))
    assert (here[:16] == back[:16]).all()
    assert (here[16:] == still[16:]).all()
    assert (here[:16] != still[:16]).any()


@pytest.mark.parametrize("contrast", [0.0, 0.5])
def test_a_wall_of_less_contrast_has_its_shades_nearer_to_their_middle(contrast: float) -> None:
    faint = corridor(dataclasses.replace(STRAIGHT, left_contrast=contrast))
    there, here = (look_from(world, 7.0, 0.3, steps=1) for world in (corridor(), faint))
    is_met = there[:16] > 0.0
    assert is_met.sum() >= 10
    assert np.abs(here[:16] - 127.5 - contrast * (there[:16] - 127.5))[is_met].max() <= 1.0
    assert (here[16:] == there[16:]).all()


def test_the_sides_of_a_corridor_and_its_stripes_are_independent() -> None:
    simulation = Simulation(corridor(), reference_contract(), seeds(120))
    walls = []
    for i in range(120):
        outlines = sorted(simulation.outlines_near(i), key=lambda o: (o.y_m > 0.0, o.x_m))
        shades = [stripe.colour[0] for outline in outlines for stripe in outline.stripes]
        walls.append(np.array(shades).reshape(2, -1))
    right, left = np.concatenate(walls, axis=1)
    assert len(right) >= 3000
    for one, other in ((right, left), (right[1:], right[:-1]), (left[2:], left[:-2])):
        assert abs(np.corrcoef(one, other)[0, 1]) < 4 / math.sqrt(len(one))
    for wall in (right, left):  # uniform between 0 and 1: each tenth as often as the others
        counts, _ = np.histogram(wall, 10, (0.0, 1.0))
        assert np.abs(counts - len(wall) / 10).max() < 5 * math.sqrt(len(wall) / 10)


def striped_at(outline: Outline, at_m: Floats) -> set[float]:
    """Shades of the pieces of an outline at whose outer edges a point lies."""
    shades = set()
    for stripe in outline.stripes:
        ends = stripe.corners_m[1:] if len(stripe.corners_m) == 3 else stripe.corners_m
        edges = zip(ends, np.roll(ends, -1, axis=0), strict=True)
        ways_m = [math.dist(at_m, a) + math.dist(at_m, b) - math.dist(a, b) for a, b in edges]
        # Chords of a disc lie within it: by 1 − cos 5° of its radius.
        if min(ways_m) < (4e-3 if outline.is_disc else 1e-6):
            shades.add(stripe.colour[0])
    return shades


POSTS: dict[str, Layer] = {
    "boxes": Scatter(0.15, colour=GREY, stripes_m=0.3),
    "turned": Scatter(0.15, (Rectangles(turned_rad=(-2.0, 2.0)),), colour=GREY, stripes_m=0.2),
    "discs": Scatter(0.15, (Discs(),), colour=GREY, stripes_m=0.4),
    "moving": Scatter(
        0.15, (Rectangles(), Discs()), motion=Drift(0.3, -0.5), colour=GREY, stripes_m=0.3
    ),
}


@pytest.mark.parametrize("posts", POSTS)
@pytest.mark.parametrize("walled", [False, True])
def test_what_is_drawn_is_what_is_seen(posts: str, walled: bool) -> None:
    walls = dataclasses.replace(STRAIGHT, left_contrast=0.5)
    layers = (walls, POSTS[posts]) if walled else (POSTS[posts],)
    world = World("posts", width_m=12.0, edges=Edges.UNBOUNDED, layers=layers)
    two = RetinaSpec(rays=32, eyes=2, baseline_m=0.4, **COLOUR)  # type: ignore[arg-type]  # by name
    simulation = Simulation(world, PolicyContract(two, TURNING), seeds(6))
    for _ in range(8):
        simulation.step(np.arange(6) % 3)  # they look ahead, back and aside
    eyes, compared = simulation.sense()[..., 0] / 255, 0
    for i, eye in itertools.product(range(6), range(2)):
        outlines, seen = simulation.outlines_near(i), eyes[:, eye]
        eye_m, bearings = eye_place_m(simulation, i, eye), directions_rad(simulation, i)
        lengths = ray_lengths_m(outlines, eye_m, bearings)
        for ray, bearing in enumerate(bearings):
            first = int(lengths[:, ray].argmin())
            if lengths[first, ray] >= 5.0:
                assert seen[i, ray] == 0.0
                continue
            if lengths[first, ray] == 0.0:
                continue  # an eye beside the agent's middle may be within an obstacle
            if lengths[first, ray] > np.partition(lengths[:, ray], 1)[1] - 1e-4:
                continue  # where two meet, either is seen
            way = np.array([math.cos(bearing), math.sin(bearing)])
            shades = striped_at(outlines[first], eye_m + lengths[first, ray] * way)
            assert min(abs(shade - seen[i, ray]) for shade in shades) < 1e-9
            compared += len(shades) == 1
    assert compared > 120


def test_a_post_keeps_its_stripes_wherever_it_is_seen_from() -> None:
    simulation, shades = Simulation(world_named("bees-posts"), FINE, seeds(1)), {}
    for x_m in (0.0, 5.3, 11.1, 2.6, -3.0):
        put(simulation, 0, x_m, 0.0, 0.0)
        simulation.drive(0.0, 0.0, 0.0)
        for outline in simulation.outlines_near(0):
            if not outline.is_box:
                continue
            place = (round(outline.x_m, 3), round(outline.y_m, 3))
            now = [stripe.colour for stripe in outline.stripes]
            assert shades.setdefault(place, now) == now
    assert len({tuple(own) for own in shades.values()}) == len(shades) >= 3


def test_a_layer_without_stripes_looks_the_same_beside_a_striped_one() -> None:
    none = Scatter(0.0, colour=GREY, stripes_m=0.3)
    for shapes in ((Rectangles(),), (Rectangles(turned_rad=(0.1, 1.0)),), (Discs(),)):
        seen = []
        for layers in ((Scatter(0.4, shapes),), (Scatter(0.4, shapes), none)):
            simulation = Simulation(World("w", layers=layers), FINE, seeds(8))
            for _ in range(20):
                simulation.step_and_sense(np.ones(8, np.int64))
            seen.append(simulation.stacks.copy())
        assert (seen[0] == seen[1]).all()
        assert seen[0].max() == 255


def test_a_belt_beside_a_striped_layer_writes_into_nobody_else_s_lists() -> None:
    world = World("w", layers=(Scatter(0.2, colour=GREY, stripes_m=0.3), Scatter(0.4)))
    crowd = Simulation(world, FINE, seeds(8))
    alone = [Simulation(world, FINE, seeds(8)[i : i + 1]) for i in range(8)]
    for _ in range(30):
        seen = crowd.sense()
        assert (seen == np.concatenate([one.sense() for one in alone])).all()
        crowd.step(np.zeros(8, np.int64))
        for one in alone:
            one.step(np.zeros(1, np.int64))


def test_a_coloured_stripe_has_three_draws() -> None:
    walls = dataclasses.replace(STRAIGHT, colour=((0.1, 0.4), (0.5, 0.6), (0.7, 1.0)))
    retina = RetinaSpec(rays=16, channels=3, **COLOUR)  # type: ignore[arg-type]  # by name
    simulation = Simulation(corridor(walls), PolicyContract(retina, SIDEWAYS), seeds(50))
    values = simulation.sense()[:, 0].reshape(-1, 3).astype(float)
    met = values[values.sum(axis=1) > 0] / 255
    for channel, (low, high) in enumerate(walls.colour):
        assert met[:, channel].min() >= low - 0.002
        assert met[:, channel].max() <= high + 0.002
    assert np.abs(np.corrcoef(met.T) - np.eye(3)).max() < 0.3


FAMILY = """
name = "hives"
edges = "unbounded"

[[layers]]
kind = "corridor"
width_m = { from = 3.0, to = 5.0 }
colour = [0.0, { from = 0.5, to = 1.0 }]
stripes_m = { from = 0.3, to = 1.0 }
left_wall_mps = { from = -1.0, to = 1.0 }
"""


def test_every_seed_of_a_family_has_its_own_stripes() -> None:
    family, several = parse_world(FAMILY), Simulation(parse_world(FAMILY), FINE, seeds(5))
    alone = [Simulation(family.drawn(seed), FINE, seeds(5)[seed : seed + 1]) for seed in range(5)]
    for _ in range(20):
        seen = several.sense()
        assert (seen == np.concatenate([one.sense() for one in alone])).all()
        several.step(np.zeros(5, np.int64))
        for one in alone:
            one.step(np.zeros(1, np.int64))
    corridors = [family.drawn(seed).corridor for seed in range(5)]
    assert len({walls.stripes_m for walls in corridors if walls}) == 5
