"""The evolving itself: generations until many of them bring nothing, then a choice among the best.

Every generation lives in new worlds, drawn from the training seeds, the same for all its genomes;
parents that live on are measured anew, so no genome lives by its luck. The best of each generation
is tried on fixed validation worlds; these say when to stop. The best of those drive in other
validation worlds, and the best there is the result. Test seeds are never looked at.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reflexarc_baselines.evolving.genetics import Costs, Genomes
from reflexarc_baselines.evolving.race import Seeds, race
from reflexarc_baselines.evolving.species import Species, species_named
from reflexarc_baselines.genome_files import Ancestry
from reflexarc_sim_bridge.worlds.seeds import TRAINING_SEEDS, VALIDATION_SEEDS, all_of


@dataclass(frozen=True)
class Settings:
    """How much is tried."""

    genomes: int = 64
    worlds: int = 64
    """Of each generation."""
    steps: int = 400
    """In each world."""
    most_generations: int = 150
    patience: int = 30
    """Generations without a better one that end it."""
    validation_worlds: int = 256
    finalists: int = 8
    final_worlds: int = 512


USUAL = Settings()


@dataclass(frozen=True)
class Generation:
    """How it goes, after a generation."""

    number: int
    """From 1 on."""
    mean: float
    """Cost of its genomes in its own worlds, in the unit of `race`."""
    best: float
    """Of its best there."""
    validation: float
    """Of its best in the validation worlds."""
    record: float
    """The least of those so far."""
    since: int
    """Generations since that."""


@dataclass(frozen=True)
class Evolved:
    """A genome, and how it came about."""

    genome: object
    provenance: Ancestry


Progress = Callable[[Generation], None]


def evolve(
    name: str,
    seed: int = 0,
    progress: Progress = lambda generation: None,
    settings: Settings = USUAL,
) -> Evolved:
    """Evolve a baseline anew; the same name, seed and settings give the same genome.

    Ctrl-C ends the generations, and the best so far go into the last choice.

    Args:
        name: of the baseline.
        seed: of all chance but the worlds' own.
        progress: called after each generation.
        settings: how much is tried.

    Raises:
        UsageError: no baseline of this name evolves.
    """
    species = species_named(name)
    history, hall = _generations(species, seed, progress, settings)
    genome, cost = _final(species, hall, settings)
    provenance = Ancestry(
        command=f"python -m reflexarc_baselines.evolving {name} --seed {seed} "
        f"--worlds {settings.worlds} --generations {len(history)}",
        seed=seed,
        generations=len(history),
        genomes=settings.genomes,
        worlds=settings.worlds,
        steps=settings.steps,
        first_generation=history[0].validation,
        stopped_at=history[-1].record,
        validation=cost,
        why_it_ended=_why_it_ended(history[-1], settings),
    )
    return Evolved(species.grown(genome), provenance)


class Hall:
    """The best genomes so far, each once, the best first.

    Args:
        room: for how many.
    """

    def __init__(self, room: int) -> None:
        self._room = room
        self._held: list[tuple[float, bytes, Genomes]] = []

    @property
    def genomes(self) -> Genomes:
        """(genomes, genes)."""
        return np.stack([genes for _, _, genes in self._held])

    @property
    def record(self) -> float:
        """The least cost."""
        return self._held[0][0]

    def admit(self, genes: Genomes, cost: float) -> bool:
        """Take one in if it is good enough; whether it is the best."""
        key = genes.tobytes()
        if any(key == known for _, known, _ in self._held):
            return False
        self._held.append((cost, key, genes.copy()))
        self._held.sort(key=lambda each: each[0])
        del self._held[self._room :]
        return self._held[0][1] == key


def _generations(
    species: Species, seed: int, progress: Progress, settings: Settings
) -> tuple[list[Generation], Hall]:
    generator = np.random.default_rng(seed)
    validation = all_of(VALIDATION_SEEDS)[: settings.validation_worlds]
    population, hall = species.first(settings.genomes, generator), Hall(settings.finalists)
    history: list[Generation] = []
    try:
        while not history or _goes_on(history[-1], settings):
            costs = _costs(species, population, _new_worlds(generator, settings), settings)
            champion = population[costs.argmin()]
            cost = float(_costs(species, champion[np.newaxis], validation, settings)[0])
            history.append(_generation(history, costs, cost, hall.admit(champion, cost), hall))
            progress(history[-1])
            population = species.children(population, costs, generator)
    except KeyboardInterrupt:
        if not history:
            raise
    return history, hall


def _generation(
    history: list[Generation], costs: Costs, cost: float, is_record: bool, hall: Hall
) -> Generation:
    since = 0 if is_record else history[-1].since + 1
    best, mean = float(costs.min()), float(costs.mean())
    return Generation(len(history) + 1, mean, best, cost, hall.record, since)


def _goes_on(last: Generation, settings: Settings) -> bool:
    return last.number < settings.most_generations and last.since < settings.patience


def _why_it_ended(last: Generation, settings: Settings) -> str:
    if last.since >= settings.patience:
        return f"{settings.patience} generations brought nothing"
    return "the cap" if last.number == settings.most_generations else "interrupted"


def _final(species: Species, hall: Hall, settings: Settings) -> tuple[Genomes, float]:
    """The best of the hall in worlds that chose nothing before, and its cost there."""
    unused = all_of(VALIDATION_SEEDS)[settings.validation_worlds :][: settings.final_worlds]
    costs = _costs(species, hall.genomes, unused, settings)
    return hall.genomes[costs.argmin()], float(costs.min())


def _costs(species: Species, genomes: Genomes, seeds: Seeds, settings: Settings) -> Costs:
    crowd, contract = species.crowd(genomes), species.contract
    return race(crowd, contract, species.home_world, len(genomes), seeds, settings.steps)


def _new_worlds(generator: np.random.Generator, settings: Settings) -> Seeds:
    return generator.choice(all_of(TRAINING_SEEDS), settings.worlds, replace=False)
