"""The slip of a run, or of an event of a catalogue, as a slip model for other programs."""

import numpy as np

from ..errors import OutputError
from ..geometry.surface import slip_of_event, slip_of_run
from ..results.catalogue import Catalogue
from ..results.files import is_catalogue, open_any
from ..results.run import Run
from .model import Model, Segment

BEGUN, DONE = 0.02, 0.98  # shares of a cell's slip at which it begins and has ended, for rupture and rise times


def segments_of(source, labels):
    """Grids are one plane; the cells of a mesh are listed."""
    if source.shape:
        return [Segment(1, np.arange(len(source.cells)), source.shape, float(source.cells[0, 5]))]
    return [Segment(int(k), np.flatnonzero(labels == k), None, None) for k in np.unique(labels)]


def times_of(run, begin, end, step):
    """Of each cell when it has begun to slip and for how long it does [s]; when its slip rates begin [s], and these at steps [m/s]; from the slip in /fields."""
    times, slip = run.field("slip")
    slip = slip.reshape(len(times), -1).astype(float)
    begin, end = times[0] if begin is None else begin, times[-1] if end is None else end
    grid = begin + step * np.arange(int(np.ceil((end - begin) / step)) + 1)
    rupture, rise, start, rates = *np.zeros((3, slip.shape[1])), []
    for cell in range(slip.shape[1]):
        course = np.interp(grid, times, slip[:, cell])
        course -= course[0]
        rate = np.diff(course) / step
        moves = np.flatnonzero(np.abs(rate) > 0)
        total = course[-1]
        if not len(moves) or total == 0:
            rates.append(np.zeros(0))
            continue
        share = course / total
        first, last = (float(grid[np.argmax(share >= level)]) for level in (BEGUN, DONE))
        rupture[cell], rise[cell], start[cell] = first - begin, max(last - first, step), moves[0] * step
        rates.append(rate[moves[0]:moves[-1] + 1])
    return rupture, rise, start, rates


def read(path, event=None, window=None, step=0.1):
    """The model of what slipped; a run has slip rates of each cell as well."""
    with open_any(path) as file:
        of_events = is_catalogue(file)
    begin, end = window or (None, None)
    if of_events:
        catalogue = Catalogue(path)
        number = catalogue.number_of(event or "largest")
        source = slip_of_event(catalogue, number)
        mesh = catalogue.mesh
    else:
        if event:
            raise OutputError(f"--event is one of a catalogue, but {path} is none: expected the file of -fault_catalogue, or --window")
        run = Run(path)
        source, mesh = slip_of_run(run, begin, end, "slip"), run.mesh
    labels = np.asarray(mesh["fault"], int) if "fault" in mesh else np.ones(len(source.cells), int)
    slip, rake = source.slip, source.rake
    if slip.ndim == 2:
        slip, rake = np.hypot(*source.slip.T), np.degrees(np.arctan2(source.slip[:, 1], source.slip[:, 0]))
    model = Model(path, "run of SlipStep" if not of_events else "event of SlipStep", source.cells, np.broadcast_to(rake, len(source.cells)).astype(float), slip, source.triangles, labels,
                  segments=segments_of(source, labels), options={"shear_modulus": source.shear_modulus, "poisson_ratio": source.poisson_ratio})
    model.claims["title"] = source.words
    if of_events:
        rupture = catalogue.map("rupture_time")[number].reshape(-1).astype(float)
        never = np.isnan(rupture)
        rupture[never] = catalogue.event["end"][number] - catalogue.event["onset"][number]
        model.columns = {"rupture_time": (rupture, "s")}
        if never.any():
            model.remarks.append(f"{never.sum()} cells were never above the rate of the catalogue: their rupture time is the end of the event")
    if not of_events and source.slip.ndim == 1:
        rupture, rise, start, rates = times_of(run, begin, end, step)
        model.columns = {"rupture_time": (rupture, "s"), "rise_time": (rise, "s")}
        model.rates = (start, step, rates)
    return model
