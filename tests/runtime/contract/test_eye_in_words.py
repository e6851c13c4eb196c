"""A retina names its eye: the runtime takes no other, and a hostile name costs nothing."""

import dataclasses

import pytest

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.contract.eye_in_words import differences, eye_in_words

SPEC = RetinaSpec()
OTHERS = {
    "rays": RetinaSpec(rays=8),
    "fov_rad": RetinaSpec(fov_rad=1.5707963),
    "range_m": RetinaSpec(range_m=1.5),
    "shading": RetinaSpec(shading=Shading.COLOUR),
    "eyes": RetinaSpec(eyes=2),
    "baseline_m": RetinaSpec(baseline_m=0.1),
    "channels": RetinaSpec(channels=3),
    "samples": RetinaSpec(samples=4),
    "beams": RetinaSpec(beams=BeamRule.SECTOR_MINIMUM),
}


def test_an_eye_is_its_own_and_the_number_of_frames_is_not_in_it():
    assert differences(eye_in_words(SPEC), SPEC) == []
    assert differences(eye_in_words(SPEC), dataclasses.replace(SPEC, frames=3)) == []


@pytest.mark.parametrize("field", OTHERS)
def test_one_other_field_is_named_with_both_values(field: str):
    (words,) = differences(eye_in_words(OTHERS[field]), SPEC)
    assert words.startswith(f"{field} ")
    assert " instead of " in words


def test_numbers_are_compared_to_a_millionth():
    near = dataclasses.replace(SPEC, range_m=5.0 + 4e-6)
    far = dataclasses.replace(SPEC, range_m=5.0 + 6e-6)
    assert differences(eye_in_words(near), SPEC) == []
    assert len(differences(eye_in_words(far), SPEC)) == 1


@pytest.mark.parametrize(
    "words",
    [
        "eye ",
        "eye rays=16",
        eye_in_words(SPEC) + " colour=blue",
        eye_in_words(SPEC) + " rays=16",
        eye_in_words(SPEC).replace("rays=16", "rays=nan"),
        eye_in_words(SPEC).replace("range_m=5", "range_m=inf"),
        "eye " + "a " * 500_000,
        "eye \x1b[31m=1",
    ],
)
def test_what_is_no_eye_is_refused_in_few_printable_words(words: str):
    wrong = ", ".join(differences(words, SPEC))
    assert 0 < len(wrong) < 400
    assert wrong.isprintable()
