"""What a person needs to see of a chart that runs otherwise than appendix D says."""

from __future__ import annotations

from tests.fsm.appendix_d.comparison import difference
from tests.fsm.appendix_d.random_charts import random_chart
from tests.fsm.appendix_d.shrinking import shrink
from tests.fsm.appendix_d.writers import mission_of, scxml_of


def report(seed: int, mission: bool) -> str:
    """The shrunk chart of a seed, its events and what differs; empty when nothing does.

    Raises UserError when the chart is refused: then it has to be made otherwise.
    """
    root, events = random_chart(seed, mission)
    if not difference(root, events, mission):
        return ""
    shrink(root, events, mission)
    text = mission_of(root) if mission else scxml_of(root)
    found = difference(root, events, mission)
    return f"seed {seed}, shrunk; events {' '.join(events)}\n{text}{found}"
