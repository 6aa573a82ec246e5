"""Files of the benchmarks of SEAS, Sequences of Earthquakes and Aseismic Slip (strike.scec.org/cvws/seas), from the output of a run.

Formats: Jiang and Erickson (2020), SEAS Benchmark Problems BP5-QD and BP5-FD, in the supplement of Jiang et al. (2022),
doi:10.1029/2021JB023519; Erickson and Jiang (2018), SEAS Benchmark Problem BP1-QD; Erickson et al., BP6-QD (SEAS_BP6_Nov18.pdf). Names of
columns, units and the order of headers are those that the public codes HBI, EQquasi and Thrase write.

Lines of a header begin with #, then comes a line with the names of the columns, then rows of numbers: times in s, slips in m, slip rates as
log10 of m/s, stresses in MPa, states as log10 of s. The component that no fault of ours slips along has the rate NOTHING.
"""

import os

import numpy as np

from slipstep_fields import Fields, rupture_times
from slipstep_output import OutputError, _plain

NOTHING = 1e-30  # m/s
FRONT_RATE = 0.1  # m/s: a cell of BP5 breaks when it is that fast first
NEVER = 1e9  # s: the time of cells that do not break
ORIGIN = 50e3  # BP5's x2 = 0 [m] along strike

COLUMNS = {"t": "Time (s)", "slip": "Slip (m)", "slip_2": "Slip_2 (m)", "slip_3": "Slip_3 (m)", "slip_rate": "Slip rate (log10 m/s)",
           "slip_rate_2": "Slip_rate_2 (log10 m/s)", "slip_rate_3": "Slip_rate_3 (log10 m/s)", "shear_stress": "Shear stress (MPa)",
           "shear_stress_2": "Shear_stress_2 (MPa)", "shear_stress_3": "Shear_stress_3 (MPa)", "pore_pressure": "Pore pressure (MPa)",
           "state": "State (log10 s)", "max_slip_rate": "Max_slip_rate (log10 m/s)", "moment_rate": "Moment_rate (N-m/s)",
           "x2": "Position along strike (m)", "x3": "Depth (m)"}
# name: as the benchmark calls itself; station: the name of a station's file, its columns in order
BENCHMARKS = {
    "bp1": {"name": "BP1-QD", "station": ("t", "slip", "slip_rate", "shear_stress", "state")},
    "bp5": {"name": "BP5-QD", "station": ("t", "slip_2", "slip_3", "slip_rate_2", "slip_rate_3", "shear_stress_2", "shear_stress_3", "state")},
}


def log_rate(rate):
    """What is locked may creep at 1e-40 m/s; a rate of 0 counts as the least number."""
    return np.log10(np.maximum(np.abs(rate), np.finfo(float).tiny))


def stations_of(run):
    """Of -fault_stations, in their order: dicts of arrays, one value per accepted step, and of x, z, cell_x, cell_z [m]."""
    with run._open() as file:
        group = file.get("stations")
        if group is None or not len(group):
            raise OutputError(f"{run.path}: no /stations; run with -fault_stations, as the benchmark's options file has them")
        rows = len(run.series["time"])
        found = []
        for k in range(len(group)):
            station = {key: _plain(value) for key, value in group[str(k)].attrs.items()}
            station.update((key, data[:rows]) for key, data in group[str(k)].items())
            if _plain(group[f"{k}/state"].attrs["units"]) != "s":
                raise OutputError(f"{run.path}: the state of its stations is not a time: expected a run with -fault_friction_law rate_and_state")
            found.append(station)
    return found


class Writer:
    """Files of one run in a folder.

    paths   of the files so far
    """

    def __init__(self, benchmark, run, events, folder):
        self.benchmark, self.run, self.events, self.folder, self.paths = benchmark, run, events, folder, []
        os.makedirs(folder, exist_ok=True)

    @property
    def side(self):
        """Side of a cell, in depth [m]."""
        z = self.run.axes[1]
        return z[1] - z[0]

    def write(self, name, columns, rows, location="", notes=(), steps=True, more=()):
        """Rows [n, columns]; more: lines of numbers that come before them."""
        path = os.path.join(self.folder, name)
        time = self.run.series["time"]
        lines = ["This is the file header:", f"problem=SEAS Benchmark {BENCHMARKS[self.benchmark]['name']}",
                 f"code=SlipStep {self.run.run.get('slipstep_version', '')}".rstrip(), f"element_size={self.side:g} m"]
        if steps and len(time) > 1:
            lines += [f"minimum_time_step={np.diff(time).min():.4g}", f"maximum_time_step={np.diff(time).max():.4g}", f"num_time_steps={len(time)}"]
        lines += [f"location={location}"] if location else []
        lines += [*notes, *(f"Column #{k + 1} = {COLUMNS[column]}" for k, column in enumerate(columns)), "The line below lists the names of the data fields"]
        with open(path, "w", encoding="ascii") as file:
            file.write("".join(f"# {line}\n" for line in lines) + " ".join(columns) + "\n# Here is the data.\n")
            for row in more:
                file.write(row + "\n")
            fmt = ["%.15e" if column in ("t", "x2", "x3") else "%.8e" for column in columns]
            np.savetxt(file, rows, fmt=fmt + ["%.8e"] * (rows.shape[1] - len(columns)))
        self.paths.append(path)
        return path

    def station(self, station):
        """One file. The traction of a run resists slip: the benchmark's shear stress is its negative. BP5's have x2 and x3 in whole km in
        their names, BP1's and BP6's tenths of a km."""
        wanted = BENCHMARKS[self.benchmark]["station"]
        values = {"t": station["time"], "slip": station["slip"], "slip_rate": log_rate(station["slip_rate"]), "shear_stress": -station["traction"] / 1e6,
                  "state": np.log10(station["state"])}
        none = np.zeros(len(station["time"]))
        values.update({"slip_2": values["slip"], "slip_3": none, "slip_rate_2": values["slip_rate"], "slip_rate_3": none + np.log10(NOTHING),
                       "shear_stress_2": values["shear_stress"], "shear_stress_3": none})
        x, z = station["x"] - ORIGIN, station["z"]
        name = f"fltst_strk{x / 1e3:+03.0f}dp{z / 1e3:+03.0f}.txt" if self.benchmark == "bp5" else f"fltst_dp{z / 100:03.0f}"
        own = f"x2 = {station['cell_x'] - ORIGIN:g} m, x3 = {station['cell_z']:g} m" if self.benchmark == "bp5" else f"z = {station['cell_z']:g} m"
        self.write(name, wanted, np.stack([values[column] for column in wanted], axis=1), f"on fault, centre of the cell that has the station: {own}",
                   ["Slip along strike only: component 3 has no slip and no stress, and the rate 1e-30 m/s"] if "slip_3" in wanted else [])

    def totals(self):
        """global.dat: the moment rate is that of the whole fault."""
        series, fault = self.run.series, self.events.attributes
        moment = fault["shear_modulus"] * fault["fault_area"] * series["mean_slip_rate"]
        self.write("global.dat", ("t", "max_slip_rate", "moment_rate"), np.stack([series["time"], log_rate(series["max_slip_rate"]), moment], axis=1), "frictional domain")

    def rupture(self, window):
        """rupture.dat: when each cell was first faster than FRONT_RATE, of the first event."""
        broke = front(self.run, window)
        x, z = np.meshgrid(*self.run.axes)
        rows = np.stack([x - ORIGIN, z, np.nan_to_num(broke, nan=NEVER)], axis=-1).reshape(-1, 3)
        self.write("rupture.dat", ("x2", "x3", "t"), rows, "", [f"First event: when a cell is first faster than {FRONT_RATE:g} m/s; {NEVER:g} where it never is"],
                   steps=False)

    def profiles(self):
        """slip.dat: a row with two zeros and the depths [m], then time, largest slip rate and slip at each depth."""
        slip, rate = Fields(self.run, "slip"), Fields(self.run, "slip_rate")
        rows = [np.column_stack([slip.times[at], log_rate(rates).reshape(len(at), -1).max(axis=1), slips.reshape(len(at), -1)])
                for (at, slips), (_, rates) in zip(slip.chunks(), rate.chunks())]
        depths = " ".join(f"{z:.8e}" for z in (0, 0, *self.run.axes[1]))
        self.write("slip.dat", ("t", "max_slip_rate", "slip"), np.concatenate(rows), "on fault",
                   ["First line of data: 0, 0 and depths (m) of the slips", "Columns from #3 on: slip at these depths"], steps=False, more=[depths])


def front(run, window):
    """Times [Nz, Nx] when cells first pass FRONT_RATE in a window, nan where they do not."""
    return rupture_times(Fields(run, "slip_rate", window), FRONT_RATE)


def first_event(events):
    """(begin, end) of the first event [s]"""
    return 0.0, events["end"][0] + 1.0


def write_files(benchmark, run, events, folder):
    """All files of a benchmark; their paths."""
    writer = Writer(benchmark, run, events, folder)
    for station in stations_of(run):
        writer.station(station)
    if benchmark == "bp5":
        writer.totals()
        writer.rupture(first_event(events))
    else:
        writer.profiles()
    return writer.paths
