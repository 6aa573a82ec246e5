"""Files of the benchmarks of SEAS, Sequences of Earthquakes and Aseismic Slip (strike.scec.org/cvws/seas), from the
output of a run.

The benchmarks are described by Jiang and Erickson (2020), SEAS Benchmark Problems BP5-QD and BP5-FD, in the supplement
of Jiang et al. (2022), doi:10.1029/2021JB023519; Erickson and Jiang (2018), SEAS Benchmark Problem BP1-QD; Erickson et
al. (2023), BP3-QD, doi:10.1785/0120220066; for BP6-QD by SEAS_BP6_Nov18.pdf (Lambert et al. 2025), and for BP7-QD-A by
its description there.
Files, columns, units and headers are those that public codes write for them: HBI, EQquasi, TriBIE, Thrase.jl.

Lines of a header begin with #, then comes a line with the names of the columns, then rows of numbers: times in s, slips
in m, slip rates as log10 of m/s, stresses in MPa, states as log10 of s. The component that no fault of ours slips along
has the rate NOTHING.
"""

import math
import os

import numpy as np

from ..errors import OutputError
from ..times import YEAR
from .fields import Fields, rupture_times
from .files import plain

NOTHING = 1e-30  # m/s
FRONT_RATE = 0.1  # m/s: a cell of BP4 or BP5 breaks when it is that fast first
PAUSE = YEAR  # [s]: events that begin earlier after the one before belong to it, as a rupture may pause
NEVER = 1e9  # s: the time of cells that do not break
AROUND = 1.0  # [s]: of a later event
# where x2 of BP4 and BP5, BP4's x3 and BP6's z are 0 [m], along strike and in depth, and BP7's x2 and x3
ORIGIN = {"bp4": 40e3, "bp5": 50e3, "bp6": 20e3, "bp7": 400.0}
DAY = 86400.0
PLATES = 1e-9  # rate of BP3's [m/s]
# BP6: hydraulic diffusivity [m^2/s], compressibility [1/Pa], porosity, flux [m/s], its end [s]
ALPHA, BETA, PHI, FLUX, STOP = 0.1, 1e-8, 0.1, 1.25e-6, 100 * DAY

COLUMNS = {"t": "Time (s)", "slip": "Slip (m)", "slip_2": "Slip_2 (m)", "slip_3": "Slip_3 (m)",
           "slip_rate": "Slip rate (log10 m/s)",
           "slip_rate_2": "Slip_rate_2 (log10 m/s)", "slip_rate_3": "Slip_rate_3 (log10 m/s)",
           "shear_stress": "Shear stress (MPa)",
           "shear_stress_2": "Shear_stress_2 (MPa)", "shear_stress_3": "Shear_stress_3 (MPa)",
           "pore_pressure": "Pore pressure (MPa)", "normal_stress": "Normal stress (MPa), positive in compression",
           "darcy_vel": "Darcy velocity (m/s)", "state": "State (log10 s)",
           "max_slip_rate": "Max_slip_rate (log10 m/s)",
           "disp_1": "Horizontal displacement (m), positive to the right",
           "disp_2": "Vertical displacement (m), positive down", "vel_1": "Horizontal velocity (m/s)",
           "vel_2": "Vertical velocity (m/s)", "moment_rate": "Moment_rate (N-m/s)",
           "moment_density_rate": "Moment density rate (N/s)", "x2": "Position along strike (m)", "x3": "Depth (m)"}
# Names, and the columns of the files of stations
BENCHMARKS = {
    "bp1": {"name": "BP1-QD", "station": ("t", "slip", "slip_rate", "shear_stress", "state")},
    "bp3": {"name": "BP3-QD", "station": ("t", "slip", "slip_rate", "shear_stress", "normal_stress", "state")},
    "bp4": {"name": "BP4-QD", "station": ("t", "slip_2", "slip_3", "slip_rate_2", "slip_rate_3", "shear_stress_2",
                                          "shear_stress_3", "state")},
    "bp5": {"name": "BP5-QD", "station": ("t", "slip_2", "slip_3", "slip_rate_2", "slip_rate_3", "shear_stress_2",
                                          "shear_stress_3", "state")},
    "bp7": {"name": "BP7-QD-A", "station": ("t", "slip_2", "slip_3", "slip_rate_2", "slip_rate_3", "shear_stress_2",
                                            "shear_stress_3", "state")},
    "bp6": {"name": "BP6-QD-A", "station": ("t", "slip", "slip_rate", "shear_stress", "pore_pressure", "darcy_vel",
                                            "state")},
}
erfc = np.vectorize(math.erfc, otypes=[float])


def scaled(z, t):
    """|z| over sqrt(4 ALPHA t); before the start so large that nothing of the pressure is there."""
    return np.where(t > 0, np.abs(z) / np.sqrt(4 * ALPHA * np.where(t > 0, t, 1)), 1e3)


def pressure(z, t):
    """Of BP6 [Pa] at distances z [m] from the injection, of constant flux until STOP: diffusion on a line."""
    def spread(t):
        x = scaled(z, t)
        return np.sqrt(np.maximum(t, 0)) * (np.exp(-x * x) / math.sqrt(math.pi) - x * erfc(x))

    return FLUX / (BETA * PHI * math.sqrt(ALPHA)) * (spread(t) - spread(t - STOP))


def darcy(z, t):
    """Its flux [m/s], - ALPHA BETA PHI dp/dz: half of the injection's goes to each side."""
    return FLUX / 2 * np.sign(z) * (erfc(scaled(z, t)) - erfc(scaled(z, t - STOP)))


def has_waves(run):
    return run.parameters.get("medium") == "waves"


def name_of(benchmark, run):
    """As the benchmark calls itself: BP6 has a letter for the law of the state, fully dynamic ones FD."""
    slip = "-fault_state_law slip" in run.run.get("options", "")
    name = "BP6-QD-S" if benchmark == "bp6" and slip else BENCHMARKS[benchmark]["name"]
    return name.replace("QD", "FD") if has_waves(run) else name


def dip_of(run):
    """Dip [degrees], and 1 where slip is that of a thrust or along strike, -1 of a normal fault."""
    with run.open() as file:
        dip = float(plain(file["parameters"].attrs["dip"]))
    return dip, -1 if np.mean(run.mesh["rake"]) < 0 else 1


def log_rate(rate):
    """What is locked may creep at 1e-40 m/s; a rate of 0 counts as the least number."""
    return np.log10(np.maximum(np.abs(rate), np.finfo(float).tiny))


def stations_of(run):
    """Of -fault_stations: dicts of x, z, cell_x, cell_z [m] and a value for the start and each step."""
    with run.open() as file:
        group = file.get("stations")
        if group is None or not len(group):
            raise OutputError(f"{run.path}: no /stations; run with -fault_stations, as the benchmark's options "
                              "file has them")
        found = []
        for k in range(len(group)):
            station = run.group(file, f"stations/{k}")
            if run.units[f"/stations/{k}/state"] != "s":
                raise OutputError(f"{run.path}: the state of its stations is not a time: expected a run with "
                                  "-fault_friction_law rate_and_state")
            found.append(station)
    return found


def surface_of(run):
    """Of BP3's stations on the ground, by their distance from the trace [m]: time [s], displacement [n, 2] [m] and
    velocity [m/s], to the right and down. Plates bring their rigid motion, of half the slip of the fault at depth:
    against it on the hanging wall, to the right."""
    dip, sign = dip_of(run)
    half = sign * 0.5 * np.array([math.cos(math.radians(dip)), math.sin(math.radians(dip))])
    found = {}
    with run.open() as file:
        total = "ground" in file and bool(file["ground"].attrs["total"])  # -fault_surface_motion: it is in the file
        for station in file.get("surface", {}).values():
            y, time = float(plain(station.attrs["y"])), station["time"][...]
            rigid = 0 * half if total else (-1 if y >= 0 else 1) * PLATES * half
            found[y] = time, station["displacement"][:, 1:] + np.outer(time, rigid), station["velocity"][:, 1:] + rigid
    return dict(sorted(found.items()))


class Writer:
    """Files of one run in a folder.

    paths   of the files so far
    """

    def __init__(self, benchmark, run, events, folder):
        self.benchmark, self.run, self.events, self.folder, self.paths = benchmark, run, events, folder, []
        os.makedirs(folder, exist_ok=True)

    @property
    def side(self):
        """Side of a cell, along the dip [m]."""
        z = self.run.axes[1]
        return (z[1] - z[0]) / math.sin(math.radians(dip_of(self.run)[0]))

    def write(self, name, columns, rows, location="", notes=(), steps=True, more=()):
        """Rows [n, columns]; more: lines of numbers that come before them."""
        path = os.path.join(self.folder, name)
        time = self.run.series["time"]
        lines = ["This is the file header:", f"problem=SEAS Benchmark {name_of(self.benchmark, self.run)}",
                 f"code=SlipStep {self.run.run.get('slipstep_version', '')}".rstrip(), f"element_size={self.side:g} m"]
        if steps and len(time) > 1:
            lines += [f"minimum_time_step={np.diff(time).min():.4g}", f"maximum_time_step={np.diff(time).max():.4g}",
                      f"num_time_steps={self.run.result['accepted']}"]
        lines += [f"location={location}"] if location else []
        lines += [*notes, *(f"Column #{k + 1} = {COLUMNS[column]}" for k, column in enumerate(columns)),
                  "The line below lists the names of the data fields"]
        with open(path, "w", encoding="ascii") as file:
            file.write("".join(f"# {line}\n" for line in lines) + " ".join(columns) + "\n# Here is the data.\n")
            for row in more:
                file.write(row + "\n")
            fmt = ["%.15e" if column in ("t", "x2", "x3") else "%.8e" for column in columns]
            np.savetxt(file, rows, fmt=fmt + ["%.8e"] * (rows.shape[1] - len(columns)))
        self.paths.append(path)
        return path

    def station(self, station):
        """One file. The traction of a run resists slip: the benchmark's shear stress is its negative. BP5's have x2 and
        x3 in whole km in their names, BP1's and BP6's the depth in tenths of a km, BP3's the distance along the dip."""
        wanted = BENCHMARKS[self.benchmark]["station"]
        vectors = station["slip"].ndim == 2  # along strike and up dip, while x3 goes down
        slip, rate, traction = (station[name][:, 0] if vectors else station[name]
                                for name in ("slip", "slip_rate", "traction"))
        values = {"t": station["time"], "slip": slip, "slip_rate": log_rate(rate), "shear_stress": -traction / 1e6,
                  "state": np.log10(station["state"])}
        none = np.zeros(len(station["time"]))
        values.update({"slip_2": values["slip"], "slip_3": none, "slip_rate_2": values["slip_rate"],
                       "slip_rate_3": none + np.log10(NOTHING), "shear_stress_2": values["shear_stress"],
                       "shear_stress_3": none})
        if vectors:
            values.update({"slip_3": -station["slip"][:, 1], "slip_rate_3": log_rate(station["slip_rate"][:, 1]),
                           "shear_stress_3": station["traction"][:, 1] / 1e6})
        x = station["cell_x"] - ORIGIN["bp7" if self.benchmark == "bp7" else "bp5"]
        z = station["cell_z"] - (ORIGIN[self.benchmark] if self.benchmark in ("bp4", "bp6", "bp7") else 0)
        if self.benchmark == "bp3":  # thrust slip and its stress are positive there, slip of a normal fault negative
            dip, sign = dip_of(self.run)
            z /= math.sin(math.radians(dip))
            values.update(slip=sign * values["slip"], shear_stress=sign * values["shear_stress"],
                          normal_stress=station["normal_stress"] / 1e6)
        if "pore_pressure" in wanted:
            values.update(pore_pressure=pressure(z, station["time"]) / 1e6, darcy_vel=darcy(z, station["time"]))
        own = (f"x2 = {x:g} m, x3 = {z:g} m" if self.benchmark in ("bp4", "bp5", "bp7")
               else f"{'z' if self.benchmark != 'bp3' else 'distance along the dip'} = {z:g} m")
        notes = (["Slip along strike only: component 3 has no slip and no stress, and the rate 1e-30 m/s"]
                 if "slip_3" in wanted and not vectors else [])
        self.write(self.station_name(station), wanted, np.stack([values[column] for column in wanted], axis=1),
                   f"on fault, centre of the cell that has the station: {own}", notes)

    def station_name(self, station):
        x, z = station["x"], station["z"]
        if self.benchmark == "bp5":
            return f"fltst_strk{(x - ORIGIN['bp5']) / 1e3:+03.0f}dp{z / 1e3:+03.0f}.txt"
        if self.benchmark == "bp4":  # tenths of km, but of one station, whose x3 of -7.5 km the benchmark calls -750
            x3 = z - ORIGIN["bp4"]
            return f"fltst_strk{(x - ORIGIN['bp5']) / 100:+04.0f}dp{'-750' if x3 == -7500 else f'{x3 / 100:+04.0f}'}"
        if self.benchmark == "bp7":
            return f"fltst_strk{x - ORIGIN['bp7']:+04.0f}dp{z - ORIGIN['bp7']:+04.0f}"
        if self.benchmark == "bp3":
            z /= math.sin(math.radians(dip_of(self.run)[0]))
        return (f"fltst_strk{(z - ORIGIN['bp6']) / 100:+03.0f}" if self.benchmark == "bp6"
                else f"fltst_dp{z / 100:03.0f}")

    def surface(self):
        """A file for each station on the ground, by its distance in km; -00 is the foot wall's side of the trace."""
        columns = ("t", "disp_1", "disp_2", "vel_1", "vel_2")
        for y, (time, displacement, velocity) in surface_of(self.run).items():
            name = f"srfst_fn{'-' if y < 0 else '+'}{abs(y) / 1e3:02.0f}"
            self.write(name, columns, np.column_stack([time, displacement, velocity]),
                       f"on the ground, {y:g} m to the right of the trace")

    def totals(self):
        """global.dat: the moment rate is that of the whole fault, of BP6 over its length along strike."""
        series, fault = self.run.series, self.events.attributes
        whole = self.benchmark in ("bp4", "bp5", "bp7")
        rate = "moment_rate" if whole else "moment_density_rate"
        moment = (fault["shear_modulus"] * fault["fault_area"] * series["mean_slip_rate"]
                  / (1 if whole else fault["length_x"]))
        self.write("global.dat", ("t", "max_slip_rate", rate),
                   np.stack([series["time"], log_rate(series["max_slip_rate"]), moment], axis=1), "frictional domain")

    def rupture(self, window):
        """rupture.dat: when each cell was first faster than FRONT_RATE, of the first event; of one that does not come
        at the start, as all of them come later than NEVER, from its onset on."""
        onset = window[0] + AROUND if window[0] else 0.0
        broke = front(self.run, window) - onset
        x, z = np.meshgrid(*self.run.axes)
        rows = np.stack([x - ORIGIN["bp5"], z - (ORIGIN["bp4"] if self.benchmark == "bp4" else 0),
                         np.nan_to_num(broke, nan=NEVER)], axis=-1).reshape(-1, 3)
        since = f", from its onset on, which is at {onset:.9e} s" if onset else ""
        self.write("rupture.dat", ("x2", "x3", "t"), rows, "",
                   [f"First event that breaks more than a patch: when a cell is first faster than {FRONT_RATE:g} "
                    f"m/s{since}; {NEVER:g} where it never is"], steps=False)

    def profiles(self):
        """slip.dat: a row with two zeros and the depths [m], then time, largest slip rate and slip at each depth."""
        slip, rate = Fields(self.run, "slip"), Fields(self.run, "slip_rate")
        rows = [np.column_stack([slip.times[at], log_rate(rates).reshape(len(at), -1).max(axis=1),
                                 slips.reshape(len(at), -1)])
                for (at, slips), (_, rates) in zip(slip.chunks(), rate.chunks())]
        z = self.run.axes[1] - (ORIGIN["bp6"] if self.benchmark == "bp6" else 0)
        if self.benchmark == "bp3":
            z = z / math.sin(math.radians(dip_of(self.run)[0]))
        depths = " ".join(f"{place:.8e}" for place in (0, 0, *z))
        self.write("slip.dat", ("t", "max_slip_rate", "slip"), np.concatenate(rows), "on fault",
                   ["First line of data: 0, 0 and depths (m) of the slips", "Columns from #3 on: slip at these depths"],
                   steps=False, more=[depths])


def front(run, window):
    """Times [Nz, Nx] when cells first pass FRONT_RATE in a window, nan where they do not."""
    return rupture_times(Fields(run, "slip_rate", window), FRONT_RATE)


def cycles(events):
    """Number of the largest event of each cycle."""
    apart = np.append(True, events["onset"][1:] - events["end"][:-1] > PAUSE)
    cycle = np.cumsum(apart)
    return np.array([np.flatnonzero(cycle == k)[np.argmax(events["moment"][cycle == k])]
                     for k in range(1, cycle[-1] + 1)])


def first_event(events):
    """From its onset (of the first cycle: from the start) to the end of the first cycle's largest event [s] that breaks
    more than a patch: a tenth of the largest moment. BP4's first event stays in its square."""
    largest = cycles(events)
    k = largest[np.argmax(events["moment"][largest] > 0.1 * events["moment"].max())]
    return 0.0 if k == largest[0] else events["onset"][k] - AROUND, events["end"][k] + AROUND


def write_files(benchmark, run, events, folder):
    """All files of a benchmark; their paths."""
    writer = Writer(benchmark, run, events, folder)
    for station in stations_of(run):
        writer.station(station)
    if benchmark == "bp3":
        writer.surface()
    if benchmark not in ("bp1", "bp3"):
        writer.totals()
    if benchmark in ("bp4", "bp5"):
        writer.rupture(first_event(events))
    elif benchmark != "bp7":
        writer.profiles()
    return writer.paths
