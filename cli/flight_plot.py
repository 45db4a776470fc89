"""The picture of a run: its path from above and its altitude over time, with the states marked.

Made from the run folder's files alone, so that a run that was killed has one too.
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vencejo.errors import UserError, Where

NAME = "flight.png"


@dataclass(frozen=True)
class Stretch:
    """A part of a flight spent in one leaf state."""

    state: str
    times: list[float]
    points: list[tuple[float, float, float]]


def read_track(folder: Path) -> tuple[dict[str, Any], list[Stretch]]:
    """The header of a run's log and its flight, state by state. Raises UserError."""
    try:
        with (folder / "events.jsonl").open(encoding="utf-8") as events:
            header = json.loads(events.readline())
        with (folder / "telemetry.csv").open(encoding="utf-8", newline="") as telemetry:
            rows = [row for row in csv.DictReader(telemetry) if row.get("state")]
    except (OSError, ValueError):
        raise UserError(
            "no-run", f"'{folder}' is no run folder", Where(str(folder)), "name one of `runs/`"
        ) from None
    stretches: list[Stretch] = []
    for row in rows:
        if not stretches or stretches[-1].state != row["state"]:
            stretches.append(Stretch(row["state"], [], []))
            if len(stretches) > 1 and stretches[-2].times:
                stretches[-1].times.append(stretches[-2].times[-1])
                stretches[-1].points.append(stretches[-2].points[-1])
        stretches[-1].times.append(float(row["t"]))
        stretches[-1].points.append((float(row["x"]), float(row["y"]), float(row["z"])))
    if not stretches:
        raise UserError("no-run", "this run has no telemetry", Where(str(folder)))
    return header, stretches


def draw(folder: Path) -> Path:
    """Draw a run into its folder; the picture's path. Raises UserError."""
    header, stretches = read_track(folder)
    # Imported here: it takes longer than many a flight.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5), layout="constrained")
    FigureCanvasAgg(figure)
    above, over_time = figure.subplots(1, 2, width_ratios=(1, 1.2))
    states = list(dict.fromkeys(stretch.state for stretch in stretches))
    colors = {state: f"C{index % 10}" for index, state in enumerate(states)}
    named: set[str] = set()
    for stretch in stretches:
        label = None if stretch.state in named else stretch.state
        named.add(stretch.state)
        x, y, z = zip(*stretch.points, strict=True)
        above.plot(x, y, color=colors[stretch.state], linewidth=1.8, label=label)
        above.plot(x[0], y[0], "o", color=colors[stretch.state], markersize=4)
        over_time.plot(stretch.times, z, color=colors[stretch.state], linewidth=1.8)
        over_time.axvspan(
            stretch.times[0],
            stretch.times[-1],
            color=colors[stretch.state],
            alpha=0.08,
            linewidth=0,
        )
    start = stretches[0].points[0]
    above.plot(start[0], start[1], "k^", markersize=8, label="start")
    above.set_aspect("equal", adjustable="datalim")
    above.set(title="path from above (north up)", xlabel="east, m", ylabel="north, m")
    over_time.set(title="altitude", xlabel="time, s", ylabel="up, m")
    for axes in (above, over_time):
        axes.grid(alpha=0.3)
    over_time.set_ylim(bottom=min(0.0, over_time.get_ylim()[0]))
    if len(states) <= 14:
        figure.legend(loc="outside lower center", ncols=min(6, len(states) + 1), fontsize=9)
    figure.suptitle(f"{header.get('mission', '')} in {header.get('world', '')}")
    path = folder / NAME
    figure.savefig(path, dpi=110)
    return path
