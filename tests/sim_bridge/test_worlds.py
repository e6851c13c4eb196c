import dataclasses
import math

import pytest

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds import WORLDS, Discs, Edges, Rectangles, World, world_named


def test_the_reference_world_is_as_specified() -> None:
    world = world_named("reference-1")
    assert (world.width_m, world.edges, world.density_per_m2) == (20.0, Edges.PERIODIC, 0.40)
    assert world.shapes == (Rectangles(width_m=(0.3, 1.5), length_m=(0.3, 1.2)),)
    assert (world.dt_s, world.colour) == (0.1, (1.0, 1.0))
    assert world.cover == pytest.approx(1.0 - math.exp(-0.27))
    assert world.blind_contacts_per_100m == pytest.approx(36.0)


@pytest.mark.parametrize("name", ["discs", "mixed"])
def test_worlds_of_discs_have_the_same_blind_figure(name: str) -> None:
    assert world_named(name).blind_contacts_per_100m == pytest.approx(36.0)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(WorldError, match="no world is named 'narnia'; known: reference-1, discs"):
        world_named("narnia")


def test_every_named_world_carries_its_name() -> None:
    assert all(world.name == name for name, world in WORLDS.items())


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"width_m": 0.0}, "width_m"),
        ({"width_m": math.nan}, "width_m"),
        ({"density_per_m2": -1.0}, "density_per_m2"),
        ({"density_per_m2": 5.0}, "density_per_m2"),
        ({"density_per_m2": math.inf}, "density_per_m2"),
        ({"shapes": ()}, "shapes"),
        ({"shapes": (Discs(), Discs())}, "shapes"),
        ({"shapes": (Discs(share=0.0),)}, "shapes"),
        ({"dt_s": 0.0}, "dt_s"),
        ({"colour": (0.5, 0.2)}, "colour"),
        ({"colour": (0.0, 1.5)}, "colour"),
        ({"stream": -1}, "stream"),
        ({"width_m": 1.2, "edges": Edges.OPEN}, "shapes"),
    ],
)
def test_a_world_that_cannot_be_names_its_field(change: dict[str, object], field: str) -> None:
    with pytest.raises(WorldError, match=rf"^world\.{field}: expected .*, got "):
        dataclasses.replace(world_named("reference-1"), **change)  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("span", [(0.0, 1.0), (2.0, 1.0), (-1.0, 1.0), (1.0, 99.0)])
def test_sizes_that_cannot_be_are_refused(span: tuple[float, float]) -> None:
    with pytest.raises(WorldError, match=r"rectangles\.width_m"):
        Rectangles(width_m=span)
    with pytest.raises(WorldError, match=r"discs\.radius_m"):
        Discs(radius_m=span)


def test_a_world_without_obstacles_is_a_world() -> None:
    assert World("empty", density_per_m2=0.0).blind_contacts_per_100m == 0.0
