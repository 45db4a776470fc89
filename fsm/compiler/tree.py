"""Drafts the states of a mission with all that it includes, and resolves its targets."""

from __future__ import annotations

from fsm.chart.draft import MAX_STATE_DEPTH, Draft, StateDraft
from fsm.faults import Faults
from fsm.language.spec import MissionSpec, StateSpec
from vencejo.errors import UserError, nearest
from vencejo.nodes import Scalar, count

MAX_STATES = 10_000
"""Most states of a mission, included graphs counted; twenty files could ask for a million."""
MAX_VALUES = 80_000
"""Most values of its included graphs, counted each time; a file has 10,000 at most."""


class Tree:
    """The draft of a mission: its states in document order, each with its spec."""

    def __init__(self, mission: MissionSpec, faults: Faults) -> None:
        self.faults = faults
        self.states = Draft()
        self.specs: list[StateSpec] = []
        """The specification of each state, by its index."""
        self.named: list[dict[str, StateDraft]] = []
        """The children of each state by name, without the roots of included graphs."""
        self.graphs: dict[int, MissionSpec] = {}
        """The spec of each graph, by the index of its root."""
        self.values = 0
        """The number of values in the graphs included so far."""
        self.sizes: dict[MissionSpec, int] = {}
        self.root = self.begin(mission, None, "", "")
        self.link()

    def begin(
        self, mission: MissionSpec, parent: StateDraft | None, name: str, path: str
    ) -> StateDraft:
        """Add the root of a graph, with all inside."""
        self.graphs[len(self.states)] = mission
        root = self.states.add(name, path + name, mission.root.type, mission.root.where, parent)
        root.border = True
        # The states of an included graph are known by the state that includes it.
        self.grow(root, mission.root, path.partition(":")[0], mission)
        return root

    def grow(self, state: StateDraft, spec: StateSpec, prefix: str, mission: MissionSpec) -> None:
        """Keep the spec of a state that was just added, and add all inside it."""
        if state.index >= MAX_STATES:
            message = f"with all includes there are more than {MAX_STATES} states"
            raise UserError("too-many-states", message, spec.where)
        self.specs.append(spec)
        state.description, state.deep, state.outcome = spec.description, spec.deep, spec.outcome
        named: dict[str, StateDraft] = {}
        self.named.append(named)
        if spec.include is not None:
            self.include(state, spec.include, mission)
            return
        for child in spec.states:
            path = f"{prefix}.{child.name}" if prefix else child.name
            inner = self.states.add(child.name, path, child.type, child.where, state)
            self.grow(inner, child, path, mission)
            named[child.name] = inner

    def include(self, state: StateDraft, word: Scalar, mission: MissionSpec) -> None:
        """Add the graph that a state includes."""
        if state.depth > MAX_STATE_DEPTH:
            message = f"with all includes, states nest more than {MAX_STATE_DEPTH} deep"
            raise UserError("too-deep", message, word.where)
        included = mission.included.get(word.text)
        if included is not None:
            self.values += self.size_of(included)
            if self.values > MAX_VALUES:
                message = f"with all includes there are more than {MAX_VALUES:,} values"
                raise UserError("too-many-nodes", message, word.where)
            # No target can be written with a colon: none crosses the border by accident.
            self.begin(included, state, f":{included.name}", state.path)

    def size_of(self, graph: MissionSpec) -> int:
        """The number of values in a graph."""
        if graph not in self.sizes:
            self.sizes[graph] = count(graph.node) if graph.node else 0
        return self.sizes[graph]

    def lacks(self, state: StateDraft) -> bool:
        """Whether a state includes a graph that was not found, so that its contents are unknown."""
        return self.specs[state.index].include is not None and not state.children

    def link(self) -> None:
        """Resolve the initial states and the default targets of history states."""
        for state, spec in zip(self.states, self.specs, strict=True):
            misread = spec.flawed and not spec.states
            if state.type == "compound" and not self.lacks(state) and not misread:
                state.initial = self.initial(state, spec)
            elif spec.initial and not spec.flawed:
                self.faults.fail(
                    "misplaced-initial",
                    "only a state with `states` has an initial one",
                    spec.initial.where,
                )
            if state.type == "history":
                with self.faults.collecting():
                    state.initial = (self.default_target(state, spec),)

    def initial(self, state: StateDraft, spec: StateSpec) -> tuple[StateDraft, ...]:
        """The state that a default entry of a compound state enters; none when it has none."""
        first = next((child for child in state.children if child.type != "history"), None)
        if first is None:
            what = "only history states are" if state.children else "no state is"
            self.faults.fail("no-states", f"{what} in here", state.where, "states: {name: {…}}")
            return ()
        if spec.initial is None:
            return (first,)
        place = first if first.border else state
        found = self.inside(place, spec.initial.text)
        if found is None:
            names = [child.name for child in place.children]
            hint = nearest(spec.initial.text, names)
            self.faults.fail(
                "unknown-target",
                f"there is no state '{spec.initial.text}' in here",
                spec.initial.where,
                hint,
            )
            return (first,)
        return (found,)

    def default_target(self, history: StateDraft, spec: StateSpec) -> StateDraft:
        """The state that a history state stands for while it has no content. Raises UserError."""
        parent = history.parent
        assert parent is not None
        if spec.target is None:
            raise UserError(
                "missing-key", "a history state needs a `target` for the first time", history.where
            )
        found = self.inside(parent, spec.target.text)
        if found is None or found.type == "history":
            names = [child.name for child in parent.children if child.type != "history"]
            hint = nearest(spec.target.text, names)
            raise UserError(
                "unknown-target",
                f"there is no state '{spec.target.text}' here",
                spec.target.where,
                hint,
            )
        return found

    def inside(self, state: StateDraft, path: str) -> StateDraft | None:
        """The state of a path from ``state`` inwards; None when there is none."""
        found: StateDraft | None = state
        for name in path.split("."):
            found = next((c for c in found.children if c.name == name), None) if found else None
        return found

    def target(self, source: StateDraft, scalar: Scalar) -> StateDraft:
        """Resolve a target: its first name among the children, then the siblings, then outwards.

        Raises UserError when there is no such state. When a state further out has the same name
        that is a warning.
        """
        first, _, rest = scalar.text.partition(".")
        found: StateDraft | None = None
        for place in source.outwards():
            named = self.named[place.index].get(first)
            if found is None:
                found = named
            elif named is not None:
                self.warn_hidden(found, named, scalar)
        if found is None:
            hint = nearest(scalar.text, self.visible(source))
            message = f"there is no state '{scalar.text}' to go to"
            raise UserError("unknown-target", message, scalar.where, hint)
        target = self.inside(found, rest) if rest else found
        if target is None:
            raise UserError(
                "unknown-target",
                f"there is no state '{rest}' in '{found.path}'",
                scalar.where,
                "what is included is entered as a whole; `initial` says where it begins"
                if found.children and found.children[0].border
                else nearest(rest, [child.name for child in found.children]),
            )
        return target

    def visible(self, source: StateDraft) -> set[str]:
        """The names of the states that a target may begin with."""
        return {name for place in source.outwards() for name in self.named[place.index]}

    def warn_hidden(self, found: StateDraft, hidden: StateDraft, scalar: Scalar) -> None:
        self.faults.warn(
            "hidden-state",
            f"'{found.name}' means '{found.path}' here, not '{hidden.path}'",
            scalar.where,
            "give one of the two another name",
        )
