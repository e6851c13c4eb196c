"""Settings in a command line: values as TOML has them, and bare words."""

import math

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.setting_words import parse_settings


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("0.3", 0.3),
        ("-1e-3", -0.001),
        ("64", 64),
        ("[64, 32]", [64, 32]),
        ('"online"', "online"),
        ("online", "online"),
        ("tier-05:1", "tier-05:1"),
        ("true", True),
        ("inf", math.inf),
        ("", ""),
        ("a=b", "a=b"),
        ("1\nother = 2", "1\nother = 2"),
        ("[" * 5000, "[" * 5000),
        ("9" * 5000, "9" * 5000),
        ('["a", "b"]', ["a", "b"]),
    ],
)
def test_a_value_is_tomls_or_the_words_themselves(word: str, value: object) -> None:
    assert parse_settings([f"learner.form={word}"]) == {"learner.form": value}


def test_spaces_around_do_not_count() -> None:
    assert parse_settings([" gamma = 0.5 "]) == {"gamma": 0.5}


@pytest.mark.parametrize("word", ["learner.gamma", "=3", "", "  = 3"])
def test_what_names_no_field_or_no_value_is_refused(word: str) -> None:
    with pytest.raises(UsageError, match="expected FIELD=VALUE"):
        parse_settings([word])


def test_a_field_set_twice_is_refused() -> None:
    with pytest.raises(UsageError, match=r"learner\.gamma: set twice"):
        parse_settings(["learner.gamma=0.5", "learner.gamma = 0.6"])
