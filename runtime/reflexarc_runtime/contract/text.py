"""The text of a contract in a policy file: JSON with a schema version, sealed with a digest.

    {"digest":"<SHA-256 of the rest>", … ,"schema":4, … }

The digest covers every other character of the text, so that no flipped bit, wherever it came from,
changes what a robot does. It is no signature: whoever edits a contract on purpose can seal it anew.
Schema 1 is the first; 2 has `retina.samples`; 3 has the digest, and what `_SINCE_3` names;
4 has `least_lead`.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from reflexarc_runtime.errors import ContractError

SCHEMA_VERSION = 4
SEALED_SINCE = 3

_HEAD = '{"digest":"'
_HEAD_CHARACTERS = len(_HEAD) + 64 + len('",')

_SINCE_3: Mapping[str, Any] = {
    "body": {
        "actuation_delay_s": 0.0,
        "deceleration_mps2": None,
        "footprint": {"ahead_m": 0.0, "behind_m": 0.0, "half_width_m": 0.0, "radius_m": 0.0},
    },
    "goal": False,
    "hold_s": 0.0,
    "margin": 0.0,
    "q_tolerance": 1e-6,
    "recovery_inputs": 3,
    "state": {"size": 0, "start": []},
}
_SINCE_4: Mapping[str, Any] = {"least_lead": 0.0}
"""What older contracts mean where they say nothing. Written out: defaults may change, these not."""


def seal(document: Mapping[str, Any]) -> str:
    """A contract's fields as text of today's schema, with the digest."""
    fields = {"schema": SCHEMA_VERSION, **document}
    body = json.dumps(fields, sort_keys=True, separators=(",", ":"))
    return f'{_HEAD}{digest_of(body)}",{body[1:]}'


def open_text(text: str) -> tuple[dict[str, Any], int]:
    """The fields that a text holds, as today's schema has them, and the schema it was written in.

    Raises:
        ContractError: not JSON, a digest that does not fit or is missing, or a newer schema.
    """
    is_sealed, body = _unseal(text)
    document = _parsed(body)
    schema = _schema(document.pop("schema", None))
    if schema >= SEALED_SINCE and not is_sealed:
        raise ContractError(
            f"contract: expected a digest before the fields of schema {schema}, found none; "
            "the text was edited or is damaged: export the policy again"
        )
    return _migrated(document, schema), schema


def digest_in(text: str) -> str:
    """The digest that a text carries, in hexadecimal; empty for one without."""
    return text[len(_HEAD) : len(_HEAD) + 64] if text.startswith(_HEAD) else ""


def digest_of(body: str) -> str:
    """SHA-256 of a contract's text without its digest, in hexadecimal."""
    return hashlib.sha256(body.encode(errors="surrogatepass")).hexdigest()


def _unseal(text: str) -> tuple[bool, str]:
    """Whether there is a digest, which then fits, and the text without it."""
    if not text.startswith(_HEAD):
        return False, text
    body = "{" + text[_HEAD_CHARACTERS:]
    wanted, got = text[:_HEAD_CHARACTERS], f'{_HEAD}{digest_of(body)}",'
    if wanted != got:
        raise ContractError(
            f"contract: its digest ({wanted[len(_HEAD) :][:12]}…) is not that of its text "
            f"({got[len(_HEAD) :][:12]}…); the text was edited or is damaged: export the policy "
            "again"
        )
    return True, body


def _parsed(text: str) -> dict[str, Any]:
    try:
        document = json.loads(text, object_pairs_hook=_without_duplicates)
    except (ValueError, RecursionError) as error:
        raise ContractError(f"contract: expected JSON, got {text[:40]!r}… ({error})") from None
    if not isinstance(document, dict):
        raise ContractError(f"contract: expected a JSON object, got {type(document).__name__}")
    return document


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A table without a name that stands in it twice: readers differ in which one counts."""
    table = dict(pairs)
    if len(table) != len(pairs):
        raise ValueError("a name stands twice in a table")
    return table


def _schema(version: object) -> int:
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise ContractError(f"contract: expected a schema version from 1 on, got {version!r}")
    if version > SCHEMA_VERSION:
        raise ContractError(
            f"contract: schema {version} is newer than this reflexarc reads ({SCHEMA_VERSION}); "
            "upgrade reflexarc on this machine"
        )
    return version


def _migrated(document: dict[str, Any], schema: int) -> dict[str, Any]:
    """A document of an older schema as one of today's."""
    if schema < 2:
        document = _with(document, "retina", {"samples": 1})
    if schema < 3:
        document = _with(document, "retina", {"beams": "nearest_beam"})
        document = _with(document, "golden", {"sequences": []})
        document = _added(document, "", _SINCE_3)
    if schema < 4:
        document = _added(document, "", _SINCE_4)
    return document


def _with(document: dict[str, Any], name: str, fields: Mapping[str, Any]) -> dict[str, Any]:
    """The document with more fields in one of its tables, if it is one."""
    table = document.get(name)
    if not isinstance(table, dict):
        return document
    return {**document, name: _added(table, f"{name}.", fields)}


def _added(table: dict[str, Any], where: str, fields: Mapping[str, Any]) -> dict[str, Any]:
    """The table with more fields; one that its schema did not have yet is refused."""
    early = sorted(table.keys() & fields.keys())
    if early:
        raise ContractError(f"contract.{where}{early[0]}: unknown in a text of that schema")
    return {**table, **fields}
