"""The tree of states, and how targets find their way in it."""

from __future__ import annotations

from dataclasses import replace

from fsm.chart.graph import Node
from fsm.faults import Faults
from fsm.language.reader import MAX_STATE_DEPTH
from fsm.language.spec import MissionSpec, StateSpec
from vencejo.errors import UserError, nearest
from vencejo.nodes import Scalar

MAX_STATES = 10_000
"""Of a mission with all it includes; twenty files can ask for a million."""


class Tree:
    """The nodes of a mission in document order, each with its spec and a first slot."""

    def __init__(self, mission: MissionSpec, first_slot: int, faults: Faults) -> None:
        self.faults = faults
        self.nodes: list[Node] = []
        self.specs: dict[int, StateSpec] = {}
        self.named: dict[int, dict[str, Node]] = {}
        """The children of a state by name."""
        self.first_slot = first_slot
        self.graphs: dict[int, MissionSpec] = {}
        """The graph that begins at a state."""
        self.root = self.begin(mission, None, "", "")
        self.link()

    def begin(self, mission: MissionSpec, parent: Node | None, name: str, path: str) -> Node:
        """The root of a graph, with all inside."""
        self.graphs[len(self.nodes)] = mission
        node = self.grow(replace(mission.root, name=name), parent, path + name, mission)
        node.border = True
        return node

    def grow(self, spec: StateSpec, parent: Node | None, path: str, mission: MissionSpec) -> Node:
        if len(self.nodes) >= MAX_STATES:
            message = f"with all includes there are more than {MAX_STATES} states"
            raise UserError("too-many-states", message, spec.where)
        node = Node(spec.name, path, spec.type, len(self.nodes), spec.where)
        node.parent = parent
        node.ancestors = (parent, *parent.ancestors) if parent else ()
        node.description = spec.description
        node.deep = spec.deep
        node.outcome = spec.outcome
        node.entered_slot = self.first_slot + node.index
        self.nodes.append(node)
        self.specs[node.index] = spec
        if spec.include is not None:
            # A name that no target can say: the border is not crossed by accident.
            if len(node.ancestors) > MAX_STATE_DEPTH:
                message = f"with all includes, states nest more than {MAX_STATE_DEPTH} deep"
                raise UserError("too-deep", message, spec.include.where)
            included = mission.included.get(spec.include.text)
            if included is not None:
                node.children = (self.begin(included, node, f":{included.name}", path),)
        else:
            # The states of an included graph are known by the state that includes it.
            prefix = path.partition(":")[0] if spec.name.startswith(":") else path
            node.children = tuple(
                self.grow(child, node, f"{prefix}.{child.name}" if prefix else child.name, mission)
                for child in spec.states
            )
        node.last = len(self.nodes) - 1
        self.named[node.index] = {
            child.local_name: child for child in node.children if not child.border
        }
        return node

    def lacks(self, node: Node) -> bool:
        """Whether a state includes a graph that was not found: anything might be in there."""
        return self.specs[node.index].include is not None and not node.children

    def link(self) -> None:
        """Initial states and where history goes the first time."""
        for node in self.nodes:
            spec = self.specs[node.index]
            if node.type == "compound" and not self.lacks(node):
                node.initial = self.initial(node, spec)
            elif spec.initial:
                self.faults.fail(
                    "misplaced-initial",
                    "only a state with `states` has an initial one",
                    spec.initial.where,
                )
            if node.type == "history":
                with self.faults.collecting():
                    self.link_history(node, spec)

    def initial(self, node: Node, spec: StateSpec) -> tuple[Node, ...]:
        first = next((child for child in node.children if child.type != "history"), None)
        if first is None:
            self.faults.fail("no-states", "only history states are in here", node.where)
            return ()
        if spec.initial is None:
            return (first,)
        place = first if first.border else node
        found = self.inside(place, spec.initial.text)
        if found is None:
            names = [child.local_name for child in place.children]
            hint = nearest(spec.initial.text, names)
            self.faults.fail(
                "unknown-target",
                f"there is no state '{spec.initial.text}' in here",
                spec.initial.where,
                hint,
            )
            return (first,)
        return (found,)

    def link_history(self, node: Node, spec: StateSpec) -> None:
        parent = node.parent
        assert parent is not None
        if spec.target is None:
            raise UserError(
                "missing-key", "a history state needs a `target` for the first time", node.where
            )
        found = self.inside(parent, spec.target.text)
        if found is None or found.type == "history":
            names = [child.local_name for child in parent.children if child.type != "history"]
            hint = nearest(spec.target.text, names)
            raise UserError(
                "unknown-target",
                f"there is no state '{spec.target.text}' here",
                spec.target.where,
                hint,
            )
        node.initial = (found,)

    def inside(self, node: Node, path: str) -> Node | None:
        found: Node | None = node
        for name in path.split("."):
            found = (
                next((c for c in found.children if c.local_name == name), None) if found else None
            )
        return found

    def target(self, source: Node, scalar: Scalar) -> Node:
        """The state of a name: among the children, then the siblings, then outwards."""
        first, _, rest = scalar.text.partition(".")
        place: Node | None = source
        while place is not None:
            found = self.named[place.index].get(first)
            if found is not None:
                self.warn_hidden(found, place, scalar)
                target = self.inside(found, rest) if rest else found
                if target is None:
                    raise UserError(
                        "unknown-target",
                        f"there is no state '{rest}' in '{found.path}'",
                        scalar.where,
                        "what is included is entered as a whole; `initial` says where it begins"
                        if found.children and found.children[0].border
                        else nearest(rest, [child.local_name for child in found.children]),
                    )
                return target
            place = None if place.border else place.parent
        visible = {
            child.local_name
            for node in source.outwards()
            for child in node.children
            if not child.border
        }
        raise UserError(
            "unknown-target",
            f"there is no state '{scalar.text}' to go to",
            scalar.where,
            nearest(scalar.text, visible),
        )

    def warn_hidden(self, found: Node, place: Node, scalar: Scalar) -> None:
        """A state further out has the same name as the one that a target means."""
        for outer in place.outwards():
            other = self.named[outer.index].get(found.local_name)
            if other is not None and other is not found:
                self.faults.warn(
                    "hidden-state",
                    f"'{found.local_name}' means '{found.path}' here, not '{other.path}'",
                    scalar.where,
                    "give one of the two another name",
                )


def domain_of(source: Node, targets: tuple[Node, ...], reenter: bool) -> Node:
    """The state whose inside a transition leaves: SCXML's LCCA, or the source it stays within."""
    within = all(source.contains(target) for target in targets)
    if within and source.border:
        return source
    if within and not reenter and source.type == "compound":
        return source
    for ancestor in source.ancestors:
        if ancestor.type == "compound" and all(ancestor.contains(target) for target in targets):
            return ancestor
    return source.ancestors[-1]
