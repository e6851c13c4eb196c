"""Evolves a baseline and writes what was found: `python -m reflexarc_baselines.evolving NAME`."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from reflexarc_baselines.evolving.evolution import Generation, Settings, evolve
from reflexarc_baselines.evolving.species import SPECIES
from reflexarc_baselines.genome_files import genome_text


def main(words: Sequence[str] | None = None) -> None:
    """Evolve what the command line names."""
    given = _parser().parse_args(words)
    settings = Settings(worlds=given.worlds, most_generations=given.generations)
    evolved = evolve(given.name, given.seed, _show, settings)
    given.out.write_text(genome_text(evolved.genome, evolved.provenance), encoding="utf-8")
    print(f"{given.out}: {evolved.provenance.validation:.2f} on other validation worlds")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m reflexarc_baselines.evolving")
    parser.add_argument("name", choices=sorted(SPECIES), help="the baseline")
    parser.add_argument("--seed", type=int, default=0, help="of all chance; 0 if not given")
    parser.add_argument("--out", type=Path, required=True, help="the TOML file to write")
    usual = Settings()
    for flag, number, words in (
        ("--worlds", usual.worlds, "in which each genome of a generation is tried"),
        ("--generations", usual.most_generations, "at most"),
    ):
        parser.add_argument(flag, type=int, default=number, help=f"{words}; {number}")
    return parser


def _show(now: Generation) -> None:
    print(
        f"generation {now.number}: mean {now.mean:.2f}, best {now.best:.2f}; on validation worlds "
        f"{now.validation:.2f}, record {now.record:.2f}, {now.since} generations ago",
        file=sys.stderr,
        flush=True,
    )


if __name__ == "__main__":
    main()
