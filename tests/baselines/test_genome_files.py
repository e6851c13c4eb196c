from pathlib import Path

import pytest

from reflexarc_baselines.baseline import Remembering
from reflexarc_baselines.evolving.species import SPECIES
from reflexarc_baselines.genome_files import provenance_of, read_genome, shipped_path
from reflexarc_baselines.history.motion_steering import Detectors
from reflexarc_baselines.registry import baseline_named
from reflexarc_runtime.errors import UsageError


@pytest.mark.parametrize("name", sorted(SPECIES))
def test_each_that_evolved_ships_with_how_it_came_about(name: str) -> None:
    provenance = provenance_of(shipped_path(name))
    assert f"evolving {name} --seed {provenance.seed}" in provenance.command
    assert provenance.stopped_at < provenance.first_generation
    shipped: Remembering = baseline_named(name)  # type: ignore[assignment]  # these have a memory
    assert shipped.contract.state.size == SPECIES[name].contract.state.size > 0
    assert shipped.contract.retina == SPECIES[name].contract.retina


def test_a_broken_file_is_told_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    for text, words in (
        ("[genome", "mine.toml:1: expected TOML"),
        ("x = 1", r"\[genome\]"),
        ("[genome]", "genome"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(UsageError, match=words):
            read_genome(path, Detectors)
    with pytest.raises(UsageError, match="give a TOML file"):
        read_genome(tmp_path / "none.toml", Detectors)
