"""The one way from a mapping to a dataclass: what it takes, what it refuses, in which words."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Literal

import pytest

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.config.toml_source import TomlSource
from reflexarc_runtime.errors import ContractError, UsageError


class Colour(StrEnum):
    RED = "red"
    GREEN = "green"


@dataclass(frozen=True)
class Wheel:
    radius_m: float = 0.1

    def __post_init__(self) -> None:
        require(self.radius_m > 0.0, "radius_m", "positive", self.radius_m)


@dataclass(frozen=True)
class SpareWheel:
    place: str


@dataclass(frozen=True)
class Car:
    name: str
    wheels: tuple[Wheel, ...] = ()
    colour: Colour = Colour.RED
    drive: Literal["front", "rear", "all"] = "front"
    has_roof: bool = True
    seats: int = 4
    weight_kg: float | None = None
    versions: Mapping[str, str] = field(default_factory=dict)
    notes: Mapping[str, Any] = field(default_factory=dict)
    extra: Wheel | SpareWheel | None = None


def filled(document: Mapping[str, object], **options: bool) -> Car:
    return fill(Car, MappingSource(document, "car", ContractError), **options)  # type: ignore[arg-type]


WHOLE = {
    "name": "c",
    "wheels": [{"radius_m": 1}, {"radius_m": 0.5}],
    "colour": "green",
    "drive": "all",
    "has_roof": False,
    "seats": 2,
    "weight_kg": 900,
    "versions": {"numpy": "2"},
    "notes": {"a": [None, {"b": 1}]},
    "extra": {"kind": "spare-wheel", "place": "boot"},
}


def test_every_kind_of_annotation_is_filled() -> None:
    car = filled(WHOLE, require_all=True)
    assert car == Car(
        name="c",
        wheels=(Wheel(1.0), Wheel(0.5)),
        colour=Colour.GREEN,
        drive="all",
        has_roof=False,
        seats=2,
        weight_kg=900.0,
        versions={"numpy": "2"},
        notes={"a": [None, {"b": 1}]},
        extra=SpareWheel("boot"),
    )
    assert isinstance(car.weight_kg, float)
    assert isinstance(car.colour, Colour)


def test_null_is_none_where_a_field_may_be_none_and_nowhere_else() -> None:
    assert filled({"name": "c", "weight_kg": None, "extra": None}) == Car("c")
    with pytest.raises(ContractError, match=r"car\.seats: expected a whole number, got None"):
        filled({"name": "c", "seats": None})


def test_missing_fields_have_their_defaults_unless_all_are_required() -> None:
    assert filled({"name": "c"}) == Car("c")
    with pytest.raises(ContractError, match=r"car\.wheels: missing; expected a list of objects"):
        filled({"name": "c"}, require_all=True)


def test_unknown_keys_are_refused_unless_they_are_to_be_ignored() -> None:
    with pytest.raises(ContractError, match=r"car\.horn: unknown; known: name, wheels, "):
        filled({"name": "c", "horn": 1})
    assert filled({"name": "c", "horn": 1}, ignore_unknown=True) == Car("c")


REFUSED: dict[str, tuple[dict[str, object], str]] = {
    "missing": ({}, "car.name: missing; expected a text"),
    "text": ({"name": 3}, "car.name: expected a text, got 3"),
    "list": ({"name": "c", "wheels": {}}, "car.wheels: expected a list of objects, got {}"),
    "element": ({"name": "c", "wheels": [1]}, "car.wheels[0]: expected an object, got 1"),
    "choice": ({"name": "c", "colour": "blue"}, "car.colour: expected red or green, got 'blue'"),
    "literal": ({"name": "c", "drive": 4}, "car.drive: expected one of front, rear, all, got 4"),
    "truth": ({"name": "c", "has_roof": 1}, "car.has_roof: expected true or false, got 1"),
    "number": ({"name": "c", "seats": True}, "car.seats: expected a whole number, got True"),
    "fraction": ({"name": "c", "seats": 1.5}, "car.seats: expected a whole number, got 1.5"),
    "or none": ({"name": "c", "weight_kg": "1"}, "car.weight_kg: expected a number, got '1'"),
    "value": ({"name": "c", "versions": {"x": 1}}, "car.versions.x: expected a text, got 1"),
    "mapping": ({"name": "c", "notes": []}, "car.notes: expected an object, got []"),
    "kind": ({"name": "c", "extra": {}}, "car.extra.kind: expected one of wheel, spare-wheel"),
    "odd key": ({"name": "c", "a\nb": 1}, r"car.'a\nb': unknown"),
    "its own check": (
        {"name": "c", "wheels": [{"radius_m": 1}, {"radius_m": -1}]},
        "car.wheels[1].radius_m: expected positive, got -1.0",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_fit_is_refused_in_one_line_by_the_path_of_its_field(case: str) -> None:
    document, words = REFUSED[case]
    with pytest.raises(ContractError) as refusal:
        filled(document)
    assert str(refusal.value).startswith(words)
    assert "\n" not in str(refusal.value)


def test_the_same_complaint_names_file_and_line_where_the_mapping_is_toml() -> None:
    text = 'name = "c"\n[[wheels]]\n[[wheels]]\nradius_m = -1\n'
    with pytest.raises(UsageError, match=r"^car\.toml:4: wheels\[1\]\.radius_m: expected positive"):
        fill(Car, TomlSource(text, "car.toml"))


@dataclass(frozen=True)
class Shelf:
    share: float = 1.0
    refusal: str = ""

    def __post_init__(self) -> None:
        if self.refusal:
            raise UsageError(self.refusal)


@pytest.mark.parametrize(
    ("refusal", "said"),
    [
        ("share: expected less", "shelf.share: expected less"),
        ("shelf.share: expected less", "shelf.share: expected less"),
        ("/usr/share/w.toml:3: expected more", "shelf: /usr/share/w.toml:3: expected more"),
        ("share/w.toml: expected more", "shelf: share/w.toml: expected more"),
        ("share", "shelf: share"),
    ],
)
def test_a_refusal_is_told_at_a_field_only_if_it_begins_with_one(refusal: str, said: str) -> None:
    with pytest.raises(UsageError) as caught:
        fill(Shelf, MappingSource({"refusal": refusal}, "shelf"))
    assert str(caught.value) == said


@dataclass(frozen=True)
class Route:
    spans_m: tuple[tuple[float, float], ...] = ()
    runs: tuple[tuple[int, ...], ...] = ()


def test_one_list_stands_for_its_only_element_only_where_its_length_is_fixed() -> None:
    assert fill(Route, MappingSource({"spans_m": [0, 1]})) == Route(((0.0, 1.0),))
    with pytest.raises(UsageError, match=r"^runs\[0\]: expected a list of whole numbers, got 0"):
        fill(Route, MappingSource({"runs": [0, 1]}))
