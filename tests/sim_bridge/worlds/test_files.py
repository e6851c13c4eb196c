import dataclasses
import math
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.config.toml_lines import key_lines, line_of
from reflexarc_runtime.config.toml_source import MAX_BYTES
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds import files as world_files
from reflexarc_sim_bridge.worlds import ranges as world_ranges
from reflexarc_sim_bridge.worlds.files import (
    WORLDS,
    WorldFamily,
    parse_world,
    read_world,
    world_named,
    world_text,
)
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

WHOLE = """
name = "whole"
description = "Everything that a file can say."
width_m = 12
edges = "periodic"
dt_s = 0.05
stream = 3
layers = [{ kind = "gates", spacing_m = 5.0, colour = [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]] },
          { kind = "automaton", fill = 0.3, motion = { kind = "swing", period_s = 9.0 } }]

[senses]
noise = 0.1
dead_sectors = [[-0.5, -0.4], [0.1, 0.2]]
latency_s = 0.1
gap_s = 0.25

[chassis]
radius_m = 0.3
acceleration_mps2 = inf
after_contact = "ghost"

[scanner]
beams = 91
"""


def test_a_whole_file_is_read() -> None:
    rgb = ((0.1, 0.2), (0.3, 0.4), (0.5, 0.6))
    assert parse_world(WHOLE) == World(
        "whole",
        "Everything that a file can say.",
        width_m=12.0,
        edges=Edges.PERIODIC,
        dt_s=0.05,
        stream=3,
        layers=(Gates(spacing_m=5.0, colour=rgb), Automaton(fill=0.3, motion=Swing(period_s=9.0))),
        senses=Senses(
            noise=0.1, dead_sectors=((-0.5, -0.4), (0.1, 0.2)), latency_s=0.1, gap_s=0.25
        ),
        chassis=Chassis(radius_m=0.3, after_contact=AfterContact.GHOST),
        scanner=Scanner(beams=91),
    )


def test_layers_and_their_shapes_may_stand_under_headers() -> None:
    text = """
    name = "headers"
    [[layers]]
    kind = "scatter"
    colour = [0.2, 0.4]
    [[layers.shapes]]
    kind = "polygons"
    corners = [3, 4]
    [[layers.shapes]]
    kind = "curves"
    share = 2
    [layers.motion]
    kind = "drift"
    left_mps = -1
    [[layers]]
    kind = "scatter"
    [[layers.shapes]]
    kind = "discs"
    """
    moving = Scatter(
        shapes=(Polygons(corners=(3, 4)), Curves(share=2.0)),
        colour=((0.2, 0.4),),
        motion=Drift(left_mps=-1.0),
    )
    assert parse_world(text) == World("headers", layers=(moving, Scatter(shapes=(Discs(),))))


def test_a_name_alone_is_the_default_world() -> None:
    assert parse_world('name = "plain"') == World("plain")


LAYER = 'name = "x"\n[[layers]]\nkind = "scatter"\n'

REFUSED: dict[str, tuple[str, str]] = {
    "no TOML": ('name = "x"\nwidth_m = = 3', r"bad\.toml:2: expected TOML: "),
    "no name": ("width_m = 3.0", r"bad\.toml:1: name: missing; expected a text"),
    "name of another type": ("name = 3", r"bad\.toml:1: name: expected a text, got 3"),
    "name without letters": ('name = ""', r"bad\.toml:1: name: expected 1 to 60 printable"),
    "name of two lines": (r'name = "a\nb"', r"bad\.toml:1: name: expected 1 to 60 printable"),
    "description of two lines": (
        'name = "x"\ndescription = """\na\nb"""',
        r"bad\.toml:2: description: expected one line",
    ),
    "unknown field": ('name = "x"\n\nwidth = 3', r"bad\.toml:3: width: unknown; known: name, "),
    "unknown table": ('name = "x"\n[ears]', r"bad\.toml:2: ears: unknown"),
    "text for a number": ('name = "x"\nwidth_m = "3"', r":2: width_m: expected a number, got '3'"),
    "truth for a number": ('name = "x"\ndt_s = true', r":2: dt_s: expected a number, got True"),
    "date for a number": ('name = "x"\ndt_s = 2020-01-01', r":2: dt_s: expected a number, got"),
    "NaN": ('name = "x"\nwidth_m = nan', r":2: width_m: expected 1 to 10000, got nan"),
    "huge number": (f'name = "x"\nwidth_m = {10**400}', r":2: width_m: expected a number"),
    "huge range": (
        f'name = "x"\nwidth_m = {{ from = 2, to = {10**400} }}',
        r":2: width_m: expected a range",
    ),
    "hexadecimal number": (f'name = "x"\nwidth_m = 0x{"f" * 1900}', r":2: width_m: expected a num"),
    "fraction of a whole": ('name = "x"\nstream = 0.5', r":2: stream: expected a whole number"),
    "edges": ('name = "x"\nedges = "round"', r":2: edges: expected one of periodic, unbounded, o"),
    "senses": ('name = "x"\n[senses]\nnoise = 2', r":3: senses\.noise: expected 0 to 1, got 2\.0"),
    "senses as a number": ('name = "x"\nsenses = 2', r":2: senses: expected a table, \[senses\]"),
    "sectors": ('name = "x"\n[senses]\ndead_sectors = [1]', r"dead_sectors\[0\]: expected two"),
    "scanner": ('name = "x"\n[scanner]\nbeams = 1', r":3: scanner\.beams: expected 2 to"),
    "layers as a table": ('name = "x"\n[layers]', r":2: layers: expected tables, each under \[\[l"),
    "layer without a kind": (
        'name = "x"\n[[layers]]\nfill = 0.1',
        r":2: layers\[0\]\.kind: expected one of scatter, gates, corridor, automaton, got none",
    ),
    "unknown kind": (LAYER + '[[layers]]\nkind = "sea"', r":5: layers\[1\]\.kind: .*, got 'sea'"),
    "field of another kind": (LAYER + "fill = 0.1", r":4: layers\[0\]\.fill: unknown; known: dens"),
    "out of range": (LAYER + "\ndensity_per_m2 = -1", r":5: layers\[0\]\.density_per_m2: expected"),
    "too crowded": (LAYER + "density_per_m2 = 9", r":4: layers\[0\]\.density_per_m2: .*cover"),
    "shape": (
        f'{LAYER}[[layers.shapes]]\nkind = "discs"\n[[layers.shapes]]\nkind = "discs"\n\n'
        "radius_m = [0.5, 0.1]",
        r":9: layers\[0\]\.shapes\[1\]\.radius_m: expected \(low, high\)",
    ),
    "span of one": (
        f'{LAYER}[[layers.shapes]]\nkind = "discs"\nradius_m = [0.5]',
        r":6: layers\[0\]\.shapes\[0\]\.radius_m: expected two numbers, got \[0\.5\]",
    ),
    "corners by halves": (
        f'{LAYER}[[layers.shapes]]\nkind = "polygons"\ncorners = [3, 4.5]',
        r":6: .*corners: expected two whole numbers, got \[3, 4\.5\]",
    ),
    "motion": (
        LAYER + '[layers.motion]\nkind = "swing"\nperiod_s = 0.0',
        r":6: layers\[0\]\.motion\.period_s: expected 0\.1 to",
    ),
    "colour": (LAYER + 'colour = "red"', r":4: layers\[0\]\.colour: expected a list of two number"),
    "two colours": (LAYER + "colour = [[0, 1], [0, 1]]", r":4: layers\[0\]\.colour: expected one"),
    "inline": (
        'name = "x"\nlayers = [\n  { kind = "scatter" },\n  { kind = "gates", pitch_m = 0 } ]',
        r":2: layers\[1\]\.pitch_m: expected 2\.5 to",
    ),
    "together impossible": (
        'name = "x"\n\n[[layers]]\nkind = "corridor"\n[chassis]\nradius_m = 0.1',
        r":1: edges: expected unbounded",
    ),
    "a field of a part": (
        'name = "x"\nedges = "unbounded"\n[[layers]]\nkind = "corridor"\n[chassis]\n'
        'after_contact = "ghost"',
        r":6: chassis\.after_contact: expected no ghost",
    ),
    "deep": (f"name = {'[' * 1990}", r":1: expected TOML, got brackets"),
    "deep keys": (f'name = "x"\n{".".join("a" * 900)} = 1', r":2: a: unknown"),
    "deep values": (
        f'name = "x"\nwidth_m.{".".join("a" * 900)} = 1',
        r":2: width_m: expected a ra",
    ),
    "long key": (f'name = "x"\n{"a" * 1900} = 1', r":2: 'a{40}': unknown"),
    "long line": (f'name = "x"\n{".".join("a" * 30_000)} = 1', r":2: expected at most 2000 cha"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_what_is_no_world_is_refused_by_line_and_field(name: str, tmp_path: Path) -> None:
    text, reason = REFUSED[name]
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(WorldError, match=reason) as refusal:
        read_world(path)
    assert str(refusal.value).startswith(f"{path}:")
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 500


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b'name = "x"\ndescription = "\xff"', r":2: expected TOML in UTF-8"),
        (b"#" * (MAX_BYTES + 1), r": expected at most 64 KiB of TOML"),
        (b"version https://git-lfs.github.com/spec/v1\nsize 9\n", r": is a Git LFS pointer"),
        (b"name = '\x00'", r":1: expected TOML"),
    ],
)
def test_what_is_no_text_or_too_long_is_refused(
    content: bytes, reason: str, tmp_path: Path
) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(WorldError, match=reason):
        read_world(path)


@pytest.mark.parametrize("name", ["none.toml", "folder/none", "./", "a\0.toml"])
def test_a_file_that_cannot_be_read_is_refused(name: str) -> None:
    with pytest.raises(WorldError):
        world_named(name)


# Lines


def test_every_key_has_its_line_whatever_stands_around_it() -> None:
    text = (
        'a = """\nb = 1 # [c]\n"""\nd = [ # =\n  "]", \'[\',\n  { e = 1 }\n]\n'
        '"f.g" . h = 1 # x = 2\n'
        "\n[[i]]\nj = 'k=l'\n[i.m]\nn = 1\n[[ i ]] # o\r\n[i.m.\"p q\"]\nr = '''\n\\'''\ns = 1"
    )
    tomllib.loads(text)
    lines = key_lines(text)
    expected: dict[tuple[Any, ...], int] = {
        ("a",): 1,
        ("d",): 4,
        ("f.g", "h"): 8,
        ("i", 0): 10,
        ("i", 0, "j"): 11,
        ("i", 0, "m"): 12,
        ("i", 0, "m", "n"): 13,
        ("i", 1): 14,
        ("i", 1, "m", "p q"): 15,
        ("i", 1, "m", "p q", "r"): 16,
        ("i", 1, "m", "p q", "s"): 18,
    }
    assert {path: lines[path] for path in expected} == expected
    assert line_of(("d", 2, "e"), lines) == 4
    assert line_of(("i", 1, "z"), lines) == 14
    assert line_of(("z",), lines) == 1


KEYS = st.sampled_from(["a", "b", '"c d"', "'e.f'", '"g\\"[="'])
VALUES = st.sampled_from(
    ["1", '"#["', "'=]'", "[1,\n 2] # [", '"""\n"a" = 1\n"""', "'''\n[x]\n\\'''", "{ a = '}' }"]
)


@given(st.lists(st.tuples(st.lists(KEYS, min_size=1, max_size=3), VALUES, st.booleans())))
def test_lines_are_those_where_the_text_was_put_together(
    parts: list[tuple[list[str], str, bool]],
) -> None:
    text, expected, table = "", dict[int, int](), ""
    for number, (keys, value, is_table) in enumerate(parts):
        table = f"t{number}" if is_table else table
        text += f"[[{table}.'x y']]\n\n" if is_table else "\r\n"
        expected[number] = text.count("\n") + 1
        text += f"k{number}.{' . '.join(keys)} = {value}\n"
    tomllib.loads(text)
    lines = key_lines(text)
    found = {
        int(part[1:]): line
        for path, line in reversed(list(lines.items()))
        for part in path
        if isinstance(part, str) and part.startswith("k")
    }
    assert found == expected


# Ranges

RANGES = """
name = "family"
description = "d"
[[layers]]
kind = "scatter"
density_per_m2 = { from = 0.1, to = 0.5 }
colour = [{ from = 0.2, to = 0.4 }, 1]
[[layers.shapes]]
kind = "polygons"
radius_m = [{ from = 0.2, to = 0.3 }, { from = 0.3, to = 0.9 }]
corners = [3, { from = 4, to = 6 }]
[senses]
noise = { from = 0, to = 1 }
"""


def family(text: str = RANGES) -> WorldFamily:
    source = parse_world(text)
    assert isinstance(source, WorldFamily)
    return source


def test_every_seed_draws_its_own_numbers_within_the_ranges() -> None:
    worlds = [family().drawn(seed) for seed in range(300)]
    scatters = [world.layers[0] for world in worlds]
    assert all(isinstance(scatter, Scatter) for scatter in scatters)
    densities = [scatter.density_per_m2 for scatter in scatters]  # type: ignore[union-attr]
    corners = [scatter.shapes[0].corners for scatter in scatters]  # type: ignore[union-attr]
    assert len(set(densities)) == 300
    assert 0.1 <= min(densities) < 0.11
    assert 0.49 < max(densities) <= 0.5
    assert {low for low, _ in corners} == {3}
    assert {high for _, high in corners} == {4, 5, 6}
    assert math.fsum(world.senses.noise for world in worlds) / 300 == pytest.approx(
        0.5, abs=4 / math.sqrt(12 * 300)
    )


def test_a_draw_never_changes() -> None:
    # Another number here makes other worlds of every family: it takes a new salt.
    world = family().drawn(7)
    assert world.senses.noise == 0.058637214218222995
    assert family().drawn(7) == world
    assert family().drawn(2**64 - 1) != world


def test_a_draw_does_not_depend_on_the_other_ranges_or_on_their_order() -> None:
    turned = RANGES.replace("colour = [{ from = 0.2, to = 0.4 }, 1]\n", "")
    head, senses = turned.split("[senses]\n")
    name, layers = head.split("[[layers]]\n", 1)
    other = family(f"{name}[senses]\n{senses}[[layers]]\n{layers}")
    for seed in range(20):
        one, two = family().drawn(seed), other.drawn(seed)
        assert one.senses == two.senses
        assert one.layers[0].shapes == two.layers[0].shapes  # type: ignore[union-attr]


@given(
    st.integers(0, 2**64 - 1),
    st.floats(-1e300, 1e300),
    st.floats(0, 1e300),
    st.sampled_from([int, float]),
)
def test_draws_stay_within_their_ends(seed: int, low: float, span: float, kind: type) -> None:
    ends = (low, low + span) if kind is float else (int(low), int(low) + int(span))
    draw = world_ranges.drawn(seed)(ends, kind, ("a", 0))
    assert ends[0] <= draw <= ends[1]
    assert isinstance(draw, kind)


def test_whole_numbers_are_drawn_evenly_with_both_ends() -> None:
    draws = [world_ranges.drawn(seed)((3, 6), int, ("x",)) for seed in range(4000)]
    counts = [draws.count(value) for value in (3, 4, 5, 6)]
    assert sum(counts) == 4000
    assert all(abs(count - 1000) < 5 * math.sqrt(750) for count in counts)


def test_a_world_without_ranges_draws_itself() -> None:
    world = world_named("reference-1")
    assert isinstance(world, World)
    assert world.drawn(5) is world


def test_a_family_says_what_it_varies() -> None:
    assert family().ranges == {
        "layers[0].density_per_m2": (0.1, 0.5),
        "layers[0].colour[0][0]": (0.2, 0.4),
        "layers[0].shapes[0].radius_m[0]": (0.2, 0.3),
        "layers[0].shapes[0].radius_m[1]": (0.3, 0.9),
        "layers[0].shapes[0].corners[1]": (4, 6),
        "senses.noise": (0, 1),
    }
    assert (family().name, family().description) == ("family", "d")


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("width_m = { from = 0.5, to = 5 }", r":2: width_m: expected 1 to 10000, got 0\.5"),
        ("width_m = { from = 5, to = 20000 }", r":2: width_m: expected 1 to 10000, got 20000"),
        ("width_m = { from = 5, to = 3 }", r":2: width_m: expected a range"),
        ("width_m = { from = 5 }", r":2: width_m: expected a range"),
        ("width_m = { from = 5, to = 6, step = 1 }", r":2: width_m: expected a range"),
        ("width_m = { from = 5, to = inf }", r":2: width_m: expected a range"),
        ('width_m = { from = 5, to = "6" }', r":2: width_m: expected a range"),
        ("stream = { from = 0, to = 1.5 }", r":2: stream: expected a range .* of whole numbers"),
        ("name = { from = 0, to = 1 }", r":2: name: expected a text"),
        ("edges = { from = 0, to = 1 }", r":2: edges: expected one of"),
        ("layers = { from = 0, to = 1 }", r":2: layers: expected tables"),
        ("layers = [{ kind = { from = 0, to = 1 } }]", r":2: layers\[0\]\.kind: expected one of"),
        (
            'layers = [{ kind = "gates", opening_m = [{ from = 1, to = 3 }, {from = 2, to = 4}] }]',
            r":2: layers\[0\]\.opening_m: .*got \(3\.0, 2\.0\)",
        ),
        ("seed = { from = 0, to = 1 }", r":2: seed: unknown"),
        (
            "senses.latency_s = { from = 0, to = 1 }",
            r":2: senses\.latency_s: .* one number",
        ),
        (
            "senses.latency_steps = { from = 0, to = 1 }",
            r":2: senses\.latency_steps: .* one number",
        ),
        ("senses.dead_sectors = [0, { from = 0, to = 1 }]", r":2: .*: expected one number for all"),
        ("scanner.beams = { from = 20, to = 30 }", r":2: scanner\.beams: expected one number for"),
        ("senses.permuted = { from = 0, to = 3 }", r":2: senses\.permuted: expected one number"),
        ("senses.mounted_rad = { from = 0, to = 1 }", r":2: senses\.mounted_rad: .* one number"),
    ],
)
def test_a_family_that_is_not_sound_everywhere_is_refused(line: str, reason: str) -> None:
    name = "" if line.startswith("name") else 'name = "x"'
    with pytest.raises(WorldError, match=reason):
        parse_world(f"{name}\n{line}", "x")


@pytest.mark.parametrize("seed", [-1, 2**64])
def test_a_seed_that_is_none_is_refused(seed: int) -> None:
    with pytest.raises(WorldError, match="seed: expected 0 to"):
        family().drawn(seed)


# Names


@pytest.mark.parametrize("name", list(WORLDS))
def test_every_shipped_world_has_its_name_a_sentence_and_can_be_drawn(name: str) -> None:
    source = world_named(name)
    assert source.name == name
    assert source.description.endswith(".")
    assert len(source.description) <= 100
    assert parse_world(world_text(name)).drawn(3) == source.drawn(3)


def test_the_reference_world_is_as_specified() -> None:
    shapes = (Rectangles(width_m=(0.3, 1.5), length_m=(0.3, 1.2)),)
    assert world_named("reference-1") == World(
        "reference-1",
        world_named("reference-1").description,
        width_m=20.0,
        edges=Edges.PERIODIC,
        layers=(Scatter(density_per_m2=0.40, shapes=shapes, colour=((1.0, 1.0),)),),
        dt_s=0.1,
    )
    assert world_named("reference-1").blind_contacts_per_100m == pytest.approx(36.0)


def test_the_legacy_world_is_as_it_was() -> None:
    shapes = (Rectangles(width_m=(0.5, 1.5), length_m=(0.5, 1.5)),)
    legacy = world_named("legacy").drawn(0)
    assert (legacy.width_m, legacy.edges) == (12.0, Edges.OPEN)
    assert legacy.layers == (Scatter(density_per_m2=0.30, shapes=shapes),)


@pytest.mark.parametrize("tier", [5, 10, 15, 20, 25, 30])
def test_tiers_have_their_clutter(tier: int) -> None:
    world = world_named(f"tier-{tier:02}").drawn(0)
    assert world.clutter() == pytest.approx(tier / 100, rel=1e-3)


@pytest.mark.parametrize("ratio", [10, 20, 40])
def test_corridors_have_their_width_in_obstacle_radii(ratio: int) -> None:
    world = world_named(f"corridor-{ratio}").drawn(0)
    corridor, scatter = world.layers
    assert isinstance(corridor, Corridor)
    assert isinstance(scatter, Scatter)
    assert corridor.width_m / (scatter.mean_width_m / 2) == pytest.approx(ratio)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(
        WorldError, match=r"no world is named 'narnia'; known: .*reference-1, "
    ) as e:
        world_named("narnia")
    assert all(name in str(e.value) for name in WORLDS)
    assert "narnia" not in WORLDS
    with pytest.raises(KeyError):
        WORLDS["narnia"]


def test_a_path_is_as_good_as_a_name(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('name = "other"')
    assert world_named(str(path)) == World("other")
    assert world_text(str(path)) == 'name = "other"'


def test_a_shipped_world_is_read_when_it_is_asked_for_and_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert world_named("steps") is world_named("steps")
    monkeypatch.setattr(world_files, "read_world", None)
    assert len(list(WORLDS)) == len(WORLDS) > 30


# Round trip


def toml_of(value: Any) -> str:
    """A value as inline TOML; dataclasses in unions carry their kind."""
    if dataclasses.is_dataclass(value):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        parts = [f"{k} = {toml_of(v)}" for k, v in fields.items() if v is not None]
        if not isinstance(value, Senses | Chassis | BodyLimits | Scanner):
            parts.append(f'kind = "{type(value).__name__.lower()}"')
        return f"{{ {', '.join(parts)} }}"
    if isinstance(value, tuple):
        return f"[{', '.join(map(toml_of, value))}]"
    return f'"{value}"' if isinstance(value, str) else repr(value)


SHAPES = st.one_of(
    st.builds(Rectangles, share=st.floats(0.1, 9)),
    st.builds(Discs, radius_m=st.tuples(st.floats(0.1, 0.4), st.floats(0.5, 0.6))),
    st.builds(Polygons, corners=st.tuples(st.integers(3, 5), st.integers(6, 32))),
)
MOTIONS = st.one_of(
    st.none(), st.builds(Drift, st.floats(-9, 9)), st.builds(Swing, st.floats(-9, 9))
)
LAYERS = st.one_of(
    st.builds(
        Scatter,
        density_per_m2=st.floats(0, 0.5),
        shapes=st.lists(SHAPES, min_size=1, max_size=2).map(tuple),
        sections=st.lists(st.floats(0, 1), max_size=3).map(tuple),
        colour=st.sampled_from([((0.5, 1.0),), ((0.0, 0.1), (0.2, 0.3), (0.4, 1.0))]),
        motion=MOTIONS,
    ),
    st.builds(Gates, spacing_m=st.floats(3, 30), motion=MOTIONS),
    st.builds(Automaton, cells_per_chunk=st.integers(2, 16), motion=MOTIONS),
)


@settings(max_examples=50, deadline=None)
@given(
    st.builds(
        World,
        st.just("trip"),
        width_m=st.floats(3, 1e4),
        layers=st.lists(LAYERS, max_size=3).map(tuple),
        senses=st.builds(Senses, dead_sectors=st.lists(st.just((0.1, 0.2)), max_size=2).map(tuple)),
        chassis=st.builds(Chassis, after_contact=st.sampled_from(AfterContact)),
        scanner=st.none() | st.builds(Scanner, beams=st.integers(2, 999)),
        stream=st.integers(0, 2**32 - 1),
    )
)
def test_a_world_written_down_is_read_as_it_was(world: World) -> None:
    fields = {f.name: getattr(world, f.name) for f in dataclasses.fields(world)}
    text = "\n".join(f"{k} = {toml_of(v)}" for k, v in fields.items() if v is not None)
    assert parse_world(text) == world
