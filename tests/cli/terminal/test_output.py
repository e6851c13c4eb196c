import json
import math
from dataclasses import dataclass

import pytest

from reflexarc.terminal.output import print_json


@dataclass
class Limits:
    most: float
    others: tuple[float, ...]


def test_what_json_has_no_number_for_is_null(capsys: pytest.CaptureFixture[str]):
    print_json({"limits": {"a": math.inf}, "b": [math.nan, 1.5, -math.inf]})
    print_json(Limits(math.inf, (1.0, math.nan)))
    first, second = capsys.readouterr().out.splitlines()

    def refuse(name: str) -> None:
        raise AssertionError(name)

    assert json.loads(first, parse_constant=refuse) == {
        "limits": {"a": None},
        "b": [None, 1.5, None],
    }
    assert json.loads(second, parse_constant=refuse) == {"most": None, "others": [1.0, None]}
