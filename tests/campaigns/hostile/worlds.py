"""Worlds that were made to harm: extreme numbers, files without end, and a few that are legal."""

from pathlib import Path

from hostile.measured import Maker

_HEAD = (
    'name = "mine"\n{world}\n[[layers]]\nkind = "scatter"\ndensity_per_m2 = {density}\n{layer}\n'
)
_SHAPE = '[[layers.shapes]]\nkind = "{shape}"\n{numbers}\n'
_RECTANGLES = "width_m = [0.3, 1.5]\nlength_m = [0.3, 1.2]"
_COMMANDS = [["worlds", "show", "FILE"], ["worlds", "check", "FILE"]]
_POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 99\n"


def _scatter(
    world: str = "",
    density: str = "0.2",
    layer: str = "",
    shape: str = "rectangles",
    numbers: str = _RECTANGLES,
    rest: str = "",
) -> str:
    """A world of one scattered layer."""
    head = _HEAD.format(world=world, density=density, layer=layer)
    return head + _SHAPE.format(shape=shape, numbers=numbers) + rest


def _layer(kind: str, numbers: str, world: str = "") -> str:
    return f'name = "mine"\n{world}\n[[layers]]\nkind = "{kind}"\n{numbers}\n'


def _file(content: str | bytes) -> Maker:
    def made(folder: Path) -> tuple[Path, list[list[str]]]:
        path = folder / "world.toml"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path, _COMMANDS

    return made


def _endless(folder: Path) -> tuple[Path, list[list[str]]]:
    path = folder / "world.toml"
    path.symlink_to("/dev/zero")
    return path, _COMMANDS


def _large(folder: Path) -> tuple[Path, list[list[str]]]:
    path = folder / "world.toml"
    path.write_text(_scatter() + "# a comment\n" * 40_000_000)
    return path, _COMMANDS


FILES: dict[str, Maker] = {
    "10 km wide, legal": _file(_scatter("width_m = 10000.0")),
    "10 km wide and as dense as may be, legal": _file(
        _scatter("width_m = 10000.0", "16.0", numbers="width_m = [0.1, 0.1]\nlength_m = [0.1, 0.1]")
    ),
    "10 km wide in five layers, legal": _file(
        _scatter("width_m = 10000.0") + _scatter().split("\n", 2)[2] * 4
    ),
    "10 km of gates, legal": _file(_layer("gates", "", "width_m = 10000.0")),
    "10 km of an automaton, legal": _file(
        _layer("automaton", "cells_per_chunk = 16\nsmoothings = 4", "width_m = 10000.0")
    ),
    "a corridor of 10 km, legal": _file(
        _layer("corridor", "width_m = 1000.0", 'edges = "unbounded"\nwidth_m = 10000.0')
    ),
    "1e300 obstacles a square metre": _file(_scatter(density="1e300")),
    "a width of 1e999": _file(_scatter("width_m = 1e999")),
    "a density that is nan": _file(_scatter(density="nan")),
    "a width of 1e-300": _file(_scatter("width_m = 1e-300")),
    "steps of a nanosecond": _file(_scatter("dt_s = 1e-9")),
    "an integer of 100,000 digits": _file(_scatter(f"width_m = {'9' * 100_000}")),
    "an integer of 1,900 digits": _file(_scatter(f"width_m = {'9' * 1900}")),
    "discs of a picometre": _file(_scatter(shape="discs", numbers="radius_m = [1e-12, 1e-12]")),
    "discs of a thousand kilometres": _file(
        _scatter(shape="discs", numbers="radius_m = [1e6, 1e6]", density="1e-9")
    ),
    "a polygon of 2^62 corners": _file(
        _scatter(shape="polygons", numbers=f"radius_m = [0.5, 0.5]\ncorners = [3, {2**62}]")
    ),
    "drifting at 1e300 m/s": _file(
        _scatter(rest='[layers.motion]\nkind = "drift"\nleft_mps = 1e300\n')
    ),
    "swinging every 1e-300 s": _file(
        _scatter(rest='[layers.motion]\nkind = "swing"\nleft_m = 1.0\nperiod_s = 1e-300\n')
    ),
    "smoothed 2^31 times": _file(
        _layer("automaton", f"cells_per_chunk = 8\nfill = 0.4\nsmoothings = {2**31}")
    ),
    "2^31 cells a chunk": _file(_layer("automaton", f"cells_per_chunk = {2**31}\nfill = 0.4")),
    "gates every micrometre": _file(
        _layer("gates", "spacing_m = 1e-6\npitch_m = 1e-6\nopening_m = [1e-7, 1e-7]")
    ),
    "a scanner of 100,000 beams, legal": _file(
        _scatter(rest="[scanner]\nbeams = 100000\nsweep_rad = 3.14\n")
    ),
    "seen a year late": _file(_scatter(rest="[senses]\nlatency_s = 3e7\n")),
    "seen as late as may be, legal": _file(_scatter(rest="[senses]\nlatency_s = 102.0\n")),
    "a thousand layers": _file('name = "mine"\n' + _layer("corridor", "width_m = 4.0")[15:] * 1000),
    "arrays in arrays in arrays": _file(f"name = {'[' * 100_000}"),
    "a name of a mebibyte": _file(_scatter().replace("mine", "n" * 2**20)),
    "a name that is markup": _file(_scatter().replace("mine", "[bold]x[/red]\\u001b[31m")),
    "bytes that are no text": _file(bytes(range(256)) * 40),
    "a pointer of Git LFS": _file(_POINTER),
    "half a gigabyte of comments": _large,
    "a file without end": _endless,
}
