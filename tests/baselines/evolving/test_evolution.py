from pathlib import Path

import numpy as np
import pytest

from reflexarc_baselines.evolving.__main__ import main
from reflexarc_baselines.evolving.evolution import Generation, Hall, Settings, evolve
from reflexarc_baselines.evolving.species import SPECIES
from reflexarc_baselines.genome_files import genome_text, provenance_of, read_genome
from reflexarc_runtime.errors import UsageError

TINY = Settings(
    genomes=8,
    worlds=2,
    steps=20,
    most_generations=3,
    validation_worlds=4,
    finalists=2,
    final_worlds=4,
)


@pytest.mark.parametrize("name", sorted(SPECIES))
def test_the_same_seed_evolves_the_same_genome(name: str) -> None:
    once, again, other = (evolve(name, seed, settings=TINY) for seed in (3, 3, 4))
    assert once == again
    assert once.genome != other.genome


def test_it_ends_when_generations_bring_nothing() -> None:
    seen: list[Generation] = []
    settings = Settings(**{**vars(TINY), "patience": 1, "most_generations": 50})
    evolved = evolve("closed-loop", 0, seen.append, settings)
    assert [each.number for each in seen] == list(range(1, len(seen) + 1))
    assert [each.since for each in seen] == [0] * (len(seen) - 1) + [1]
    assert evolved.provenance.why_it_ended == "1 generations brought nothing"
    assert evolved.provenance.generations == len(seen) < 50


def test_ctrl_c_ends_it_with_the_best_so_far() -> None:
    def stop(generation: Generation) -> None:
        if generation.number == 2:
            raise KeyboardInterrupt

    evolved = evolve("closed-loop", 0, stop, TINY)
    assert evolved.provenance.why_it_ended == "interrupted"
    two = evolve("closed-loop", 0, settings=Settings(**{**vars(TINY), "most_generations": 2}))
    assert evolved.genome == two.genome
    assert two.provenance.why_it_ended == "the cap"
    assert evolved.provenance.command == two.provenance.command


def test_the_record_is_the_least_of_the_validation_costs_so_far() -> None:
    seen: list[Generation] = []
    evolve("evolved-viewing", 1, seen.append, TINY)
    costs = [each.validation for each in seen]
    assert [each.record for each in seen] == np.minimum.accumulate(costs).tolist()


def test_the_hall_keeps_the_best_once_each() -> None:
    hall, genes = Hall(2), np.eye(4)
    admitted = [hall.admit(genes[k], cost) for k, cost in ((0, 5.0), (1, 6.0), (2, 4.0), (2, 4.0))]
    assert admitted == [True, False, True, False]
    assert (hall.genomes == genes[[2, 0]]).all()
    assert hall.record == 4.0


def test_what_the_command_writes_is_read_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    evolved = evolve("spiking-network", 2, settings=TINY)
    monkeypatch.setattr("reflexarc_baselines.evolving.__main__.evolve", lambda *_: evolved)
    out = tmp_path / "genome.toml"
    main(["spiking-network", "--seed", "2", "--out", str(out)])
    assert out.read_text(encoding="utf-8") == genome_text(evolved.genome, evolved.provenance)
    assert read_genome(out, type(evolved.genome)) == evolved.genome
    assert provenance_of(out) == evolved.provenance
    assert str(out) in capsys.readouterr().out


def test_who_does_not_evolve_is_refused() -> None:
    with pytest.raises(UsageError, match="braitenberg-2a"):
        evolve("braitenberg-2a")
