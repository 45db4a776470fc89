"""The safety proof against all flights of random missions. Goals: no unsound claim, and at most 3 %
of the sound missions warned of.

python -m bench.soundness [--missions 2000] [--seed N] [--json]
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict

from tests.fsm.soundness import Comparison, compare, summary

GOAL = 0.03


def comparisons(first: int, missions: int) -> Iterator[Comparison]:
    return map(compare, range(first, first + missions))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--missions", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0, help="the first mission's; the rest follow")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = summary(comparisons(options.seed, options.missions))
    if options.json:
        print(json.dumps({**asdict(found), "goal": GOAL, "share": found.alarm_share}, indent=2))
        return
    print(f"{found.missions} random missions from seed {options.seed}, all their flights flown")
    rows = {
        "too large to fly": found.too_large,
        "can stay up": found.stays_up,
        "of these passed by the proof": f"{len(found.unsound)} (goal 0) {list(found.unsound)}",
        "sound": f"{found.sound}, {found.sound_and_handled} of them handle the event",
        "of these warned of": f"{len(found.false_alarms)}, {found.alarm_share:.1%} of those that "
        f"handle it (goal ≤ {GOAL:.0%}) {list(found.false_alarms)}",
        "not proven": found.not_proven,
    }
    for name, figure in rows.items():
        print(f"  {name:30} {figure}")


if __name__ == "__main__":
    main()
