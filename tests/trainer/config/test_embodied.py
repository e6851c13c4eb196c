import dataclasses
import math

import pytest

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.world import World
from reflexarc_trainer.config.embodied import embodied
from reflexarc_trainer.config.presets import PRESETS, preset_named
from reflexarc_trainer.config.train_config import TrainConfig, TrainingWorld

BODY = BodySpec(Footprint(radius_m=0.3), actuation_delay_s=0.2, deceleration_mps2=1.5)


def test_a_world_takes_the_body_and_the_slow_sensor() -> None:
    world = embodied(world_named("reference-1"), BODY, 0.35)
    assert isinstance(world, World)
    chassis = world.chassis
    assert (chassis.radius_m, chassis.lag_s, chassis.acceleration_mps2) == (0.3, 0.2, 1.5)
    assert world.gap_steps == 3
    assert dataclasses.replace(world, dt_s=0.02).gap_steps == 17  # 0.35 s
    assert world.body == BODY


def test_without_a_body_and_with_a_quick_sensor_a_world_stays_as_it_is() -> None:
    """So that whatever was learned before is learned again, to the bit."""
    for name in ("reference-1", "rover", "mixed"):
        assert embodied(world_named(name), None, 0.1) == world_named(name)


def test_every_world_of_a_family_takes_them() -> None:
    family = world_named("randomised")
    bodied = embodied(family, BODY, 0.2)
    assert bodied.name == family.name
    for world in (bodied.drawn(5), *bodied.fullest):
        assert world.body == BODY
        assert world.gap_steps == 2
    assert bodied.drawn(5).layers == family.drawn(5).layers


def test_the_contract_names_the_body_that_was_learned_with() -> None:
    reflex = preset_named("reflex")
    assert reflex.contract().body == BodySpec()
    assert dataclasses.replace(reflex, body=BODY).contract().body == BODY
    rover = preset_named("rover").contract().body
    assert (rover.footprint.radius_m, rover.actuation_delay_s) == (0.2, 0.1)
    assert rover.deceleration_mps2 == 2.0
    mixed = dataclasses.replace(reflex, worlds=(TrainingWorld("rover"), TrainingWorld("plane")))
    assert mixed.contract().body == BodySpec()


def test_a_run_goes_on_in_its_own_body_after_it_was_written_down() -> None:
    config = dataclasses.replace(preset_named("lidar"), body=BODY, recovery_inputs=1)
    again = TrainConfig.from_resolved(config.resolved())
    assert again == config
    assert again.contract().recovery_inputs == 1


def test_an_outline_with_corners_is_refused() -> None:
    corners = BodySpec(Footprint(ahead_m=0.3, behind_m=0.3, half_width_m=0.2))
    with pytest.raises(UsageError, match="round"):
        dataclasses.replace(preset_named("reflex"), body=corners)


@pytest.mark.parametrize("name", ["lidar", "rover-lidar"])
def test_presets_for_lidars_know_their_bodies_and_their_sensors(name: str) -> None:
    contract = preset_named(name).contract()
    assert contract.body.footprint.radius_m == 0.2
    assert contract.body.deceleration_mps2 is not None
    assert contract.body.actuation_delay_s > 0.0
    slowest_s = 1 / 5.5 if name == "rover-lidar" else 1 / 10.0
    assert contract.max_input_age_s > 2.0 * slowest_s
    assert contract.recovery_inputs * slowest_s < 0.5
    assert any(a.angular_radps for a in contract.actions) == (name == "rover-lidar")


def test_configurations_of_before_keep_one_beam_a_ray() -> None:
    """They said nothing of beams, and today's default is another."""
    for name, config in PRESETS.items():
        document = config.resolved()
        del document["retina"]["beams"]
        again = TrainConfig.from_resolved(document)
        assert again.retina.beams == "nearest_beam", name
        assert math.isclose(again.retina.range_m, config.retina.range_m)
