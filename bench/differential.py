"""Random charts run by our engine and by an interpreter of the W3C's appendix D, action by action.

    python -m bench.differential [--charts 30000] [--seed 0] [--json]

The first chart is that of the seed, the next ones follow; even ones are SCXML documents, odd ones
missions. What differs is shown, shrunk; `--charts 1 --seed N` shows one again. The charts and the
interpreter lie in tests/fsm/appendix_d. The exit code is 1 when something differs.
"""

from __future__ import annotations

import argparse
import json
import sys
from time import process_time

from bench.machine import machine
from tests.fsm.appendix_d.report import report


def differing(first: int, charts: int) -> dict[int, str]:
    """What differs, by the seed of its chart."""
    return {
        seed: found
        for seed in range(first, first + charts)
        if (found := report(seed, mission=seed % 2 == 1))
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.differential")
    parser.add_argument("--charts", type=int, default=30_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    began = process_time()
    found = differing(given.seed, given.charts)
    seconds = process_time() - began
    if given.json:
        figures = {"charts": given.charts, "seed": given.seed, "seconds": seconds}
        print(json.dumps({"machine": machine(), **figures, "differing": found}, indent=2))
    else:
        print(f"differential test against appendix D; {machine()}")
        print(f"  {given.charts} charts from seed {given.seed}, {seconds:.0f} s of CPU time")
        print(f"  {len(found)} differ")
        print("\n".join(found.values()), end="")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
