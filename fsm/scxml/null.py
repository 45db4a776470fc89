"""The null data model: no data, no expressions; conditions are ``In(state)`` alone.

W3C recommendation of 2015, section B.1.
"""

from __future__ import annotations

import re
from typing import NoReturn

from fsm.expressions.compiled import Evaluator
from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.scxml.datamodel import DataModel, Names
from vencejo.errors import UserError, Where

_IN = re.compile(r"\s*In\(\s*(?P<quote>['\"]?)(?P<state>[^'\"()\s]+)(?P=quote)\s*\)\s*")


def _compile_condition(text: str, where: Where, names: Names) -> Evaluator:
    found = _IN.fullmatch(text)
    if found is None:
        _refuse(text, where, names)
    index = names.state(found["state"], where.right(found.start("state")))
    if index is None:
        return lambda slots, event: False
    return lambda slots, event: slots[CONFIGURATION_SLOT] >> index & 1 == 1


def _refuse(text: str, where: Where, names: Names) -> NoReturn:
    message = f"'{text}' means nothing in the null data model"
    raise UserError("not-supported", message, where, "it has conditions In('state') only")


NO_DATA = DataModel(
    compile_value=_refuse,
    compile_condition=_compile_condition,
    compile_location=_refuse,
    compile_script=_refuse,
    assigned_names=lambda text: [],
    text_of=str,
    null=None,
)
