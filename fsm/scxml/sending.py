"""Sends events: the SCXML event processor (W3C recommendation of 2015, 6.2 and C.1).

An event can go to the document itself, to its external or its internal queue. There are no other
sessions: what is addressed to one raises ``error.communication``, and a target or processor that is
none raises ``error.execution``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fsm.chart.executable import INTERNAL, EventFields, NotSentError, Origin, Runtime
from fsm.expressions.compiled import Evaluator
from fsm.scxml.datamodel import PROCESSORS, DataModel
from fsm.values.functions import FAILURES, EvaluationError, plain, shown
from vencejo.errors import UserError, Where

SESSION = "1"
"""The value of ``_sessionid``: every document runs in a session of its own."""
ADDRESS = f"#_scxml_{SESSION}"
"""The target that means the document itself."""
IO_PROCESSORS = {processor: {"location": ADDRESS} for processor in PROCESSORS}
"""The value of ``_ioprocessors``."""

_INTERNAL = "#_internal"
_DELAY = re.compile(r"\s*(\d{1,12}(?:\.\d*)?|\.\d+)\s*(ms|s)\s*")
"""At most 12 digits before the point: a longer number could be slow to read, or infinite."""


def seconds(text: str, where: Where) -> float:
    """A delay such as ``10ms`` or ``1.5s``. Raises UserError."""
    match = _DELAY.fullmatch(text)
    if match is None:
        raise UserError("bad-delay", f"'{text}' is no delay", where, "10ms or 1.5s")
    return float(match[1]) * (0.001 if match[2] == "ms" else 1.0)


@dataclass(frozen=True, slots=True)
class Unreachable:
    """The reason why nothing can be sent to a target."""

    attribute: str
    """The attribute that is wrong."""
    message: str
    event: str = "error.execution"
    """The event that the document hears of it."""


def unreachable(target: str, processor: str) -> Unreachable | None:
    """Why nothing can be sent to a target by a processor; None when it can."""
    if processor not in ("", *PROCESSORS):
        return Unreachable("type", f"there is no event processor '{processor}'")
    if target in ("", _INTERNAL, ADDRESS):
        return None
    if target.startswith("#_"):
        message = f"there is no session '{target}'"
        return Unreachable("target", message, "error.communication")
    return Unreachable("target", f"'{target}' is no target")


@dataclass(frozen=True)
class Sending:
    """A `<send>`, run once for each event. All its values are taken when it is run."""

    model: DataModel
    name: Evaluator
    fields: Mapping[str, Evaluator]
    target: Evaluator | None
    processor: Evaluator | None
    delay: Evaluator | None
    id: str | None
    keep_id: Callable[[list[Any], EventFields, Any], None] | None
    """Puts the id where `idlocation` says."""
    counter: int
    """Slot of the number of events sent without an id."""

    def run(self, instance: Runtime, event: EventFields) -> None:
        """Send the event. Raises NotSentError, with the id of this sending."""
        slots, id_ = instance.slots, self.id
        if id_ is None:
            slots[self.counter] += 1
            id_ = f"send.{slots[self.counter]}"
        try:
            if self.keep_id is not None:
                self.keep_id(slots, event, id_)
            self.dispatch(instance, event, id_)
        except NotSentError:
            raise
        except FAILURES as error:
            raise NotSentError(plain(error), "error.execution", id_) from error

    def dispatch(self, instance: Runtime, event: EventFields, id_: str) -> None:
        """Queue the event under an id."""

        def text(value: Evaluator | None) -> str:
            return "" if value is None else self.model.text_of(value(instance.slots, event))

        name, target = text(self.name), text(self.target)
        fields = {key: value(instance.slots, event) for key, value in self.fields.items()}
        wait = 0.0 if self.delay is None else _wait(self.delay(instance.slots, event))
        wrong = unreachable(target, text(self.processor))
        if wrong is not None:
            raise NotSentError(wrong.message, wrong.event, id_)
        given = id_ if self.id is not None or self.keep_id is not None else None
        if target != _INTERNAL:
            origin = Origin("external", given, ADDRESS, self.model.processor)
            instance.send(name, fields, wait, id_, origin=origin)
        elif wait:
            raise EvaluationError(f"what goes to {_INTERNAL} cannot wait")
        else:
            instance.raise_event(name, fields, Origin(INTERNAL.type, given))


def _wait(value: Any) -> float:
    if isinstance(value, str) and _DELAY.fullmatch(value):
        return seconds(value, Where(""))
    raise EvaluationError(f"{shown(value)} is no delay like '10ms'")
