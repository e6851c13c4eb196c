"""Messages of ROS 2 as a node says them: objects of any library, or dictionaries; and as CDR."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

_TYPE = "__msgtype__"


def ros2_type_of(message: object) -> str:
    """The type of a message object of rosbags or rclpy; empty of anything else."""
    if name := getattr(message, _TYPE, ""):
        return str(name)
    package, _, rest = type(message).__module__.partition(".")
    is_rclpy = hasattr(message, "get_fields_and_field_types") and rest.startswith("msg.")
    return f"{package}/msg/{type(message).__name__}" if is_rclpy else ""


def ros2_fields(message: object) -> Mapping[str, Any]:
    """The fields of a message: of a dictionary, of a dataclass, of an object of rclpy.

    Raises:
        TypeError: it is none of these.
    """
    if isinstance(message, Mapping):
        return message
    if hasattr(message, "get_fields_and_field_types"):
        return {name: getattr(message, name) for name in message.get_fields_and_field_types()}
    names = getattr(message, "__dataclass_fields__", None)
    if names is None:
        raise TypeError(f"expected a message or a dictionary, got {type(message).__name__}")
    return {name: getattr(message, name) for name in names if name != _TYPE}


def ros2_message(store: "Typestore", type_name: str, said: object) -> object:
    """The message of a type that has what was said in its fields, and zero in all others.

    Raises:
        TypeError, ValueError: it says what the type does not have.
    """
    fields = store.fielddefs[type_name][1]
    given = ros2_fields(said)
    if unknown := sorted(set(given) - {name for name, _ in fields}):
        known = ", ".join(name for name, _ in fields)
        raise ValueError(f"{type_name} has no field {unknown[0]!r}; it has {known}")
    values = {name: _value(store, what, given.get(name)) for name, what in fields}
    return store.types[type_name](**values)


def _value(store: "Typestore", what: Any, said: Any) -> Any:
    from rosbags.interfaces import Nodetype

    kind, inner = what
    if kind == Nodetype.BASE:
        return _plain(inner[0], said)
    if kind == Nodetype.NAME:
        return ros2_message(store, inner, {} if said is None else said)
    element, length = inner
    count = length if kind == Nodetype.ARRAY else 0
    said = [None] * count if said is None else said
    if kind == Nodetype.ARRAY and len(said) != count:
        raise ValueError(f"expected {count} values, got {len(said)}")
    values = [_value(store, element, one) for one in said]
    if element[0] == Nodetype.BASE and element[1][0] not in ("string", "wstring"):
        return np.array(values, _dtype(element[1][0]))
    return values


def _plain(name: str, said: Any) -> Any:
    if name in ("string", "wstring"):
        if not isinstance(said, str | None):
            raise TypeError(f"expected a text, got {type(said).__name__}")
        return said or ""
    if name == "bool":
        return bool(said)
    if name.startswith("float"):
        return 0.0 if said is None else float(said)
    return 0 if said is None else int(said)


def _dtype(name: str) -> "np.dtype[Any]":
    return np.dtype("uint8" if name in ("byte", "char") else name)
