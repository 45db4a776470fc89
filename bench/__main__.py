"""`python -m bench`: every benchmark in turn, each in a process of its own."""

from __future__ import annotations

import subprocess
import sys

BENCHMARKS = (
    "first_flight", "startup", "hold", "gotos", "latency", "engine", "conformance", "safety",
    "soundness", "worlds", "cameras", "flight", "fleets", "paths", "tag_programs", "followers",
    "landings", "perception", "sweeps", "roads", "pursuit", "vision_missions",
)  # fmt: skip

for name in BENCHMARKS:
    print(flush=True)
    subprocess.run([sys.executable, "-m", f"bench.{name}", *sys.argv[1:]], check=True)
