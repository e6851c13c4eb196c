import dataclasses
import math
from collections.abc import Callable

import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.arrays.world_tables import world_tables
from reflexarc_sim_bridge.worlds.layers import Automaton, Corridor, Drift, Gates, Scatter, Swing
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import (
    AfterContact,
    Chassis,
    Edges,
    Scanner,
    Senses,
    World,
)

GREY = ((0.0, 1.0),)
WALLED = {"edges": Edges.UNBOUNDED, "layers": (Corridor(width_m=4.0),)}


def test_a_world_is_by_default_the_reference_world() -> None:
    world = World("plain")
    assert (world.width_m, world.edges, world.dt_s) == (20.0, Edges.PERIODIC, 0.1)
    (layer,) = world.layers
    assert isinstance(layer, Scatter)
    assert layer.density_per_m2 == 0.40
    assert layer.shapes == (Rectangles(width_m=(0.3, 1.5), length_m=(0.3, 1.2)),)
    assert layer.colour == ((1.0, 1.0),)
    assert layer.cover == pytest.approx(1.0 - math.exp(-0.4 * 0.9 * 0.75))
    assert world.blind_contacts_per_100m == pytest.approx(36.0)
    assert world.clutter() == pytest.approx(0.4 * 0.45**2)
    assert world.clutter(2.0, 0.5) == pytest.approx(4 * world.clutter())
    assert (world.senses, world.chassis) == (Senses(), Chassis())


def test_a_world_is_its_own_for_every_seed() -> None:
    world = World("plain")
    assert world.drawn(3) is world


def test_shares_weigh_the_mean_width() -> None:
    layer = Scatter(shapes=(Rectangles(share=3.0), Discs((0.5, 0.5), share=1.0)))
    assert layer.mean_width_m == pytest.approx((3 * 0.9 + 1 * 1.0) / 4)
    only = Scatter(shapes=(Rectangles(share=0.0), Discs()))
    assert only.mean_width_m == pytest.approx(Discs().mean_width_m)


def test_layers_and_the_agent_s_radius_add_up_to_the_blind_figure() -> None:
    layers = (Scatter(density_per_m2=0.1), Scatter(density_per_m2=0.2, shapes=(Discs(),)))
    world = World("two", layers=layers, chassis=Chassis(radius_m=0.25))
    assert world.blind_contacts_per_100m == pytest.approx(100 * (0.1 + 0.2) * (0.9 + 0.5))
    assert World("empty", layers=()).blind_contacts_per_100m == 0.0
    assert World("empty", layers=()).clutter() == 0.0


@pytest.mark.parametrize(
    "change",
    [
        {"edges": Edges.OPEN},
        {"layers": (Gates(),)},
        {"layers": (Automaton(),)},
        {"layers": (Scatter(gap_m=0.5),)},
        {"layers": (Scatter(sections=(0.5, 1.5)),)},
        {"layers": (Scatter(motion=Drift(1.0)),)},
    ],
)
def test_where_the_blind_figure_is_not_known_there_is_none(change: dict[str, object]) -> None:
    assert dataclasses.replace(World("plain"), **change).blind_contacts_per_100m is None  # type: ignore[arg-type]  # by name


def test_matern_keeps_fewer_the_wider_the_gap() -> None:
    densities = [Scatter(gap_m=gap_m).mean_density_per_m2 for gap_m in (0.0, 0.01, 0.5, 1.25)]
    assert densities[0] == 0.40
    assert densities[1] == pytest.approx(0.40, rel=1e-3)
    assert densities == sorted(densities, reverse=True)
    assert densities[3] == pytest.approx(
        (1.0 - math.exp(-0.4 * math.pi * 1.25**2)) / (math.pi * 1.25**2)
    )


def test_sections_are_thinned_each_at_its_own_density() -> None:
    dense, thin = (Scatter(0.4 * f, gap_m=1.0).mean_density_per_m2 for f in (3.0, 0.1))
    layer = Scatter(0.4, gap_m=1.0, sections=(3.0, 0.1))
    assert layer.mean_density_per_m2 == pytest.approx((dense + thin) / 2)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: Scatter(density_per_m2=-1.0), "scatter.density_per_m2"),
        (lambda: Scatter(density_per_m2=math.inf), "scatter.density_per_m2"),
        (lambda: Scatter(density_per_m2=5.0), "scatter.density_per_m2"),
        (lambda: Scatter(shapes=()), "scatter.shapes"),
        (lambda: Scatter(shapes=(Discs(share=0.0),)), "scatter.shapes"),
        (lambda: Scatter(gap_m=1.3), "scatter.gap_m"),
        (lambda: Scatter(sections=(1.0,) * 9), "scatter.sections"),
        (lambda: Scatter(sections=(-1.0,)), "scatter.sections"),
        (lambda: Scatter(section_m=1.0), "scatter.section_m"),
        (lambda: Scatter(colour=((0.5, 0.2),)), "scatter.colour"),
        (lambda: Scatter(colour=((0.0, 1.5),)), "scatter.colour"),
        (lambda: Scatter(colour=((0.0, 1.0),) * 2), "scatter.colour"),
        (lambda: Drift(ahead_mps=101.0), "drift.ahead_mps"),
        (lambda: Drift(left_mps=math.nan), "drift.left_mps"),
        (lambda: Swing(period_s=0.0), "swing.period_s"),
        (lambda: Swing(left_m=1e3), "swing.left_m"),
        (lambda: Gates(spacing_m=1.0), "gates.spacing_m"),
        (lambda: Gates(pitch_m=2.0), "gates.pitch_m"),
        (lambda: Gates(opening_m=(1.0, 10.0)), "gates.opening_m"),
        (lambda: Gates(opening_m=(0.0, 1.0)), "gates.opening_m"),
        (lambda: Gates(thickness_m=2.0), "gates.thickness_m"),
        (lambda: Corridor(width_m=0.1), "corridor.width_m"),
        (lambda: Corridor(meander_m=30.0), "corridor.meander_m"),
        (lambda: Corridor(wavelength_m=1.0), "corridor.wavelength_m"),
        (lambda: Corridor(colour=GREY, stripes_m=0.01), "corridor.stripes_m"),
        (lambda: Corridor(colour=GREY, stripes_m=math.nan), "corridor.stripes_m"),
        (lambda: Corridor(stripes_m=0.5), "corridor.colour"),
        (lambda: Corridor(left_wall_mps=0.5), "corridor.left_wall_mps"),
        (lambda: Corridor(right_contrast=0.5), "corridor.right_contrast"),
        (lambda: Corridor(colour=GREY, stripes_m=1.0, left_contrast=1.1), "corridor.left_contrast"),
        (
            lambda: Corridor(colour=GREY, stripes_m=1.0, right_wall_mps=101.0),
            "corridor.right_wall_mps",
        ),
        (lambda: Scatter(colour=GREY, stripes_m=-0.5), "scatter.stripes_m"),
        (lambda: Scatter(colour=((0.5, 0.5),), stripes_m=0.5), "scatter.colour"),
        (lambda: Scatter(0.1, (Polygons(),), colour=GREY, stripes_m=0.5), "scatter.stripes_m"),
        (
            lambda: Scatter(0.1, (Discs(), Curves()), colour=GREY, stripes_m=0.5),
            "scatter.stripes_m",
        ),
        (lambda: Automaton(cells_per_chunk=17), "automaton.cells_per_chunk"),
        (lambda: Automaton(fill=0.7), "automaton.fill"),
        (lambda: Automaton(smoothings=5), "automaton.smoothings"),
        (lambda: Scanner(beams=1), "scanner.beams"),
        (lambda: Scanner(sweep_rad=7.0), "scanner.sweep_rad"),
        (lambda: Senses(noise=-0.1), "senses.noise"),
        (lambda: Senses(dropout=1.1), "senses.dropout"),
        (lambda: Senses(dead_sectors=((1.0, 0.5),)), "senses.dead_sectors"),
        (lambda: Senses(dead_sectors=((0.0, 0.1),) * 9), "senses.dead_sectors"),
        (lambda: Senses(latency_s=-0.1), "senses.latency_s"),
        (lambda: Senses(latency_s=1001.0), "senses.latency_s"),
        (lambda: Senses(gap_s=math.inf), "senses.gap_s"),
        (lambda: Senses(background=math.nan), "senses.background"),
        (lambda: Senses(permuted=-1), "senses.permuted"),
        (lambda: Senses(permuted=1 << 63), "senses.permuted"),
        (lambda: Senses(mounted_rad=3.2), "senses.mounted_rad"),
        (lambda: Chassis(radius_m=2.0), "chassis.radius_m"),
        (lambda: Chassis(slip=-0.1), "chassis.slip"),
        (lambda: Chassis(slip_over_s=0.0), "chassis.slip_over_s"),
        (lambda: Chassis(lag_s=math.inf), "chassis.lag_s"),
        (lambda: Chassis(acceleration_mps2=0.0), "chassis.acceleration_mps2"),
        (lambda: Chassis(turn_acceleration_radps2=-1.0), "chassis.turn_acceleration_radps2"),
    ],
)
def test_what_cannot_be_names_its_field(make: Callable[[], object], field: str) -> None:
    with pytest.raises(WorldError, match=rf"^world\.{field}: expected .*, got "):
        make()


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"width_m": 0.5}, "width_m"),
        ({"width_m": math.nan}, "width_m"),
        ({"dt_s": 0.0}, "dt_s"),
        ({"dt_s": 11.0}, "dt_s"),
        ({"dt_s": 1e-300, "senses": Senses(latency_s=0.1)}, "senses.latency_s"),
        ({"dt_s": 5e-324, "senses": Senses(gap_s=0.1)}, "senses.gap_s"),
        ({"stream": -1}, "stream"),
        ({"layers": (Scatter(density_per_m2=0.1),) * 6}, "layers"),
        ({"width_m": 1.2, "edges": Edges.OPEN}, "layers"),
        ({"layers": (Gates(),), "edges": Edges.OPEN}, "edges"),
        ({"layers": (Scatter(motion=Drift(1.0)),), "edges": Edges.OPEN}, "edges"),
        ({"layers": (Corridor(),)}, "edges"),
        ({**WALLED, "layers": (Corridor(), Corridor())}, "layers"),
        ({**WALLED, "chassis": Chassis(after_contact=AfterContact.GHOST)}, "chassis.after_contact"),
        (
            {
                "edges": Edges.UNBOUNDED,
                "layers": (Corridor(width_m=1.0),),
                "chassis": Chassis(radius_m=0.5),
            },
            "chassis.radius_m",
        ),
        (
            {"width_m": 7.6, "layers": (Gates(pitch_m=5.0, opening_m=(1.0, 4.5)),)},
            r"layers\[0\]\.opening_m",
        ),
    ],
)
def test_a_world_that_cannot_be_names_its_field(change: dict[str, object], field: str) -> None:
    with pytest.raises(WorldError, match=rf"^world\.{field}: expected .*, got "):
        dataclasses.replace(World("plain"), **change)  # type: ignore[arg-type]  # wrong on purpose


def test_a_scanner_s_outermost_beams_stand_at_half_its_sweep() -> None:
    scanner = Scanner(beams=5, sweep_rad=2.0)
    assert (scanner.start_rad, scanner.step_rad) == (-1.0, 0.5)


def test_nothing_reaches_farther_than_the_farthest_of_a_world_s_layers() -> None:
    layers = (Scatter(density_per_m2=0.01, shapes=(Curves((2.0, 3.0)), Polygons())), Scatter())
    assert World("far", layers=layers).reach_m == 3.0


def test_a_contract_s_fastest_action_is_among_what_a_world_keeps_near() -> None:
    fast = PolicyContract(actions=(Action("a", 90.0, 0.0), Action("b", 0.0, 0.0)))
    plane = world_tables([World("plain")], fast).planes[0]
    assert plane["ahead_m"] >= 9.0
    assert plane["behind_m"] >= 9.0
