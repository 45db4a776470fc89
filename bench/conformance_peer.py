"""The conformance cases through python-statemachine; prints what went wrong in each as JSON.

Run by :mod:`bench.conformance` in an environment of its own; imports nothing of ours. Delays are
waited for, since that engine sleeps by the wall clock.
"""

import json
import sys
import time
from pathlib import Path

from statemachine.io.scxml.processor import SCXMLProcessor

PYTHON = {"!In(": "not In(", "Math.pow(": "pow(", "!==": "!=", "===": "==", "&amp;&amp;": "and"}
"""It evaluates Python, so that the cases' few words of ECMAScript are put into that."""


def verdict(path: Path) -> str:
    expected = json.loads(path.with_suffix(".json").read_text())
    text = path.read_text()
    for word, python in PYTHON.items():
        text = text.replace(word, python)
    processor = SCXMLProcessor(trusted=True)
    processor.parse_scxml(path.stem, text)
    chart = processor.start()
    wrong = difference(chart, "the start", expected["initialConfiguration"])
    for step in expected["events"]:
        time.sleep(step.get("after", 0) / 1000)
        chart.send(step["event"]["name"])
        wrong = wrong or difference(chart, step["event"]["name"], step["nextConfiguration"])
    return wrong


def difference(chart: object, after: str, expected: list[str]) -> str:
    active = sorted(state.id for state in chart.configuration if not state.states)
    return "" if active == sorted(expected) else f"after {after}: {active}, not {sorted(expected)}"


def main() -> None:
    folder, found = Path(sys.argv[1]), {}
    for case in sys.stdin.read().split():
        try:
            found[case] = verdict(folder / "scion" / f"{case}.scxml")
        except Exception as error:  # whatever a peer does is a result
            found[case] = f"{type(error).__name__}: {error}"
    print()  # what the charts log stands before
    print(json.dumps(found))


if __name__ == "__main__":
    main()
