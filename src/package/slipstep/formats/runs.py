"""The slip of a run, or of an event of a catalogue, as a slip model for other programs."""

import numpy as np

from ..errors import OutputError
from ..geometry.surface import slip_at, slip_of_event, slip_of_run, window_of
from ..results.catalogue import Catalogue
from ..results.files import is_catalogue, open_any
from ..results.run import Run
from ..times import written
from .model import Model, Segment

BEGUN, DONE = 0.02, 0.98  # shares of a cell's slip at which it begins and has ended, for rupture and rise times
MOST = 10 ** 8  # slip rates of all cells in a file, 1.2 GB of text
TOGETHER = 10 ** 7  # numbers of the slip of some cells in memory


def segments_of(source, labels):
    """Grids are one plane; the cells of a mesh are listed."""
    if source.shape:
        return [Segment(1, np.arange(len(source.cells)), source.shape, float(source.cells[0, 5]))]
    return [Segment(int(k), np.flatnonzero(labels == k), None, None) for k in np.unique(labels)]


def times_of(run, window, total):
    """When each cell begins to slip in a window, from the begin on, and for how long [s]; total [N]: its slip [m]."""
    with run.open() as file:
        times, data = run.stored(file, "slip")
        begin, end = window_of(run, times, *window)
        before, start = begin, slip_at(times, data, begin).reshape(-1)
        share, passed, moved = np.zeros(len(total)), np.full((2, len(total)), np.nan), total != 0
        for time in [*times[(times > begin) & (times < end)], end]:
            now = np.zeros(len(total))
            now[moved] = (slip_at(times, data, time).reshape(-1) - start)[moved] / total[moved]
            for level, at in zip((BEGUN, DONE), passed):
                here = np.isnan(at) & moved & (now >= level)
                at[here] = before + (time - before) * (level - share[here]) / (now[here] - share[here])
            before, share = time, now
    rupture, rise = passed[0] - begin, passed[1] - passed[0]
    return np.where(moved, rupture, 0.0), np.where(moved, rise, 0.0)


class Rates:
    """Slip rates of each cell of a run, for SRF: rates(cell) is when they begin in the window [s], their step [s], and
    they [n] [m/s], by slip linear between the rows of /fields. Some cells at a time are in memory."""

    def __init__(self, run, window, step):
        self.run, self.step, self.cells = run, step, range(0)
        with run.open() as file:
            self.times, data = run.stored(file, "slip")
            self.shape = data.shape[1:]
        self.begin, self.end = window_of(run, self.times, *window)
        rows = np.searchsorted(self.times, (self.begin, self.end), side="right")
        self.rows = slice(max(rows[0] - 1, 0), min(rows[1] + 1, len(self.times)))
        self.count = int(np.ceil((self.end - self.begin) / step))

    def __call__(self, cell):
        if self.count * np.prod(self.shape) > MOST:
            raise OutputError(f"{self.run.path} from {written(self.begin)} to {written(self.end)} has {self.count:.3g} "
                              f"slip rates, each of {self.step:g} s (--step), in each of {np.prod(self.shape)} cells, "
                              f"expected {MOST:.0e} in all at most: --window BEGIN END of an event")
        if cell not in self.cells:
            self.load(cell)
        grid = np.minimum(self.begin + self.step * np.arange(self.count + 1), self.end)
        rate = np.diff(np.interp(grid, self.times[self.rows], self.slip[:, cell - self.cells.start])) / self.step
        moves = np.flatnonzero(rate)
        return ((moves[0] * self.step, self.step, rate[moves[0]:moves[-1] + 1]) if len(moves)
                else (0.0, self.step, np.zeros(0)))

    def load(self, cell):
        """The slip of the rows of cells that have this one."""
        inner = int(np.prod(self.shape[1:]))
        count = max(TOGETHER // (inner * (self.rows.stop - self.rows.start)), 1)
        first = cell // inner // count * count
        with self.run.open() as file:
            data = self.run.stored(file, "slip")[1][self.rows, first:first + count]
        self.slip = data.reshape(len(data), -1).astype(float)
        self.cells = range(first * inner, first * inner + self.slip.shape[1])


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
            raise OutputError(f"--event is one of a catalogue, but {path} is none: expected the file of "
                              "-fault_catalogue, or --window")
        run = Run(path)
        source, mesh = slip_of_run(run, begin, end, "slip"), run.mesh
    labels = np.asarray(mesh["fault"], int) if "fault" in mesh else np.ones(len(source.cells), int)
    slip, rake = source.slip, source.rake
    if slip.ndim == 2:
        slip, rake = np.hypot(*source.slip.T), np.degrees(np.arctan2(source.slip[:, 1], source.slip[:, 0]))
    model = Model(path, "run of SlipStep" if not of_events else "event of SlipStep", source.cells,
                  np.broadcast_to(rake, len(source.cells)).astype(float), slip, source.triangles, labels,
                  segments=segments_of(source, labels),
                  options={"shear_modulus": source.shear_modulus, "poisson_ratio": source.poisson_ratio})
    model.claims["title"] = source.words
    if of_events:
        model.claims["start"] = [float(catalogue.event[axis][number]) for axis in "xyz"]
        rupture = catalogue.map("rupture_time")[number].reshape(-1).astype(float)
        never = np.isnan(rupture)
        rupture[never] = catalogue.event["end"][number] - catalogue.event["onset"][number]
        model.columns = {"rupture_time": (rupture, "s")}
        if never.any():
            model.remarks.append(f"{never.sum()} cells were never above the rate of the catalogue: their rupture time "
                                 "is the end of the event")
    if not of_events and source.slip.ndim == 1:
        rupture, rise = times_of(run, (begin, end), source.slip)
        model.columns = {"rupture_time": (rupture, "s"), "rise_time": (rise, "s")}
        model.rates = Rates(run, (begin, end), step)
    return model
