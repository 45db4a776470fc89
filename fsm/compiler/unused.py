"""Names that a mission declares and never uses again."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

from fsm.language.spec import MissionSpec
from vencejo.errors import Fault
from vencejo.nodes import Mapping, Scalar, YamlNode

_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_PROSE = frozenset({"description", "help"})


def unused(spec: MissionSpec) -> list[Fault]:
    """A warning for each parameter, variable and `define` that stands nowhere but where it is
    declared. A name that is a word of the file elsewhere counts as used: none is warned of wrongly.
    """
    declared = [("parameter", named.name.text, named.name.where) for named in spec.parameters]
    for state in spec.root.walk():
        declared += [("data variable", named.name.text, named.name.where) for named in state.data]
        declared += [("define", define.name, define.where) for define in state.define]
    # Where nothing is declared no word need be counted.
    texts = _texts(spec.node) if declared and spec.node is not None else ()
    words = Counter(word for text in texts for word in _WORD.findall(text))
    return [
        Fault(
            "unused", f"the {what} '{name}' is never used", where, "remove it, or use it", "warning"
        )
        for what, name, where in declared
        if words[name] == 1
    ]


def _texts(root: YamlNode) -> Iterator[str]:
    """All keys and values of a file, but for its prose."""
    left = [root]
    while left:
        node = left.pop()
        if isinstance(node, Scalar):
            yield node.text
        elif isinstance(node, Mapping):
            yield from (key.text for key, _ in node)
            left.extend(value for key, value in node if key.text not in _PROSE)
        else:
            left.extend(node.items)
