"""The plot of a run: paths from above and altitudes over time, with the states marked.

Made from the run folder's files alone, so that a run that was killed has one too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from runner.run_folder import Run, Sample, read_run
from vencejo.errors import UserError, Where, cannot_write
from vencejo.files import write_whole

NAME = "flight.png"


@dataclass(frozen=True)
class Stretch:
    """A part of a vehicle's flight spent in one configuration."""

    state: str
    """The active states; with the vehicle's name where there are several."""
    samples: Sequence[Sample]
    """The last sample before that configuration, and those in it."""


def stretches(run: Run) -> list[list[Stretch]]:
    """The flight of each vehicle while its mission ran, from configuration to configuration."""
    found = (
        _stretches(samples, f"{vehicle}: " if len(run.telemetry) > 1 else "")
        for vehicle, samples in run.telemetry.items()
    )
    return [flight for flight in found if flight]


def _stretches(samples: Sequence[Sample], prefix: str) -> list[Stretch]:
    samples = [sample for sample in samples if sample.states]  # none: the mission has ended
    if not samples:
        return []
    changes = [n for n in range(1, len(samples)) if samples[n].states != samples[n - 1].states]
    return [
        Stretch(prefix + "|".join(samples[begin].states), samples[max(0, begin - 1) : end])
        for begin, end in zip([0, *changes], [*changes, len(samples)], strict=True)
    ]


def draw(folder: Path) -> Path:
    """Draw a run into its folder; the picture's path. Raises UserError."""
    run = read_run(folder)
    flights = stretches(run)
    if not flights:
        raise UserError("no-run", "this run has no telemetry", Where(str(folder)))
    # Imported here: it takes longer than many a flight.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5), layout="constrained")
    FigureCanvasAgg(figure)
    above, over_time = figure.subplots(1, 2, width_ratios=(1, 1.2))
    states = list(dict.fromkeys(stretch.state for flight in flights for stretch in flight))
    colors = {state: f"C{index % 10}" for index, state in enumerate(states)}
    named: set[str] = set()
    for stretch in (stretch for flight in flights for stretch in flight):
        label = None if stretch.state in named else stretch.state
        named.add(stretch.state)
        times = [sample.time for sample in stretch.samples]
        x, y, z = zip(*(sample.position for sample in stretch.samples), strict=True)
        color = colors[stretch.state]
        above.plot(x, y, color=color, linewidth=1.8, label=label)
        above.plot(x[0], y[0], "o", color=color, markersize=4)
        over_time.plot(times, z, color=color, linewidth=1.8)
        over_time.axvspan(times[0], times[-1], color=color, alpha=0.08, linewidth=0)
    starts = [flight[0].samples[0].position for flight in flights]
    above.plot(
        *zip(*(start[:2] for start in starts), strict=True), "k^", markersize=8, label="start"
    )
    above.set_aspect("equal", adjustable="datalim")
    above.set(title="path from above (north up)", xlabel="east, m", ylabel="north, m")
    over_time.set(title="altitude", xlabel="time, s", ylabel="up, m")
    for axes in (above, over_time):
        axes.grid(alpha=0.3)
    over_time.set_ylim(bottom=min(0.0, over_time.get_ylim()[0]))
    if len(states) <= 14:
        figure.legend(loc="outside lower center", ncols=min(6, len(states) + 1), fontsize=9)
    missions = dict.fromkeys(mission.name for mission in run.header.missions.values())
    figure.suptitle(f"{', '.join(missions)} in {run.header.world}")
    image, path = BytesIO(), folder / NAME
    figure.savefig(image, format="png", dpi=110)
    try:
        write_whole(path, image.getbuffer())
    except OSError as error:
        message = "this picture cannot be written"
        raise cannot_write(error, "cannot-write", message, Where(str(path))) from None
    return path
