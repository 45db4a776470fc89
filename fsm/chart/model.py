"""The methods ``is_<state>()`` that `transitions` gives its models, for states of unique name.

These are methods of a class made for each graph. With a ``__getattr__`` that finds them, Python
would look up every attribute of an instance in its slow way, a third of the time of an event.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from fsm.chart.graph import Node


def model_class(base: type, nodes: Sequence[Node]) -> type:
    """A subclass of ``base`` with an ``is_…`` method for each state whose name is unique.

    Methods that ``base`` has stay as they are.
    """
    named = Counter(node.local_name for node in nodes)
    methods = {
        f"is_{node.local_name}": _test_of(node) for node in nodes if named[node.local_name] == 1
    }
    own = {name: test for name, test in methods.items() if not hasattr(base, name)}
    described = {"__module__": base.__module__, "__doc__": base.__doc__}
    return type(base.__name__, (base,), {**described, **own})


def _test_of(node: Node) -> Callable[[Any], bool]:
    path = node.path

    def is_named(self: Any) -> bool:
        active: bool = self.is_active(path)
        return active

    return is_named
