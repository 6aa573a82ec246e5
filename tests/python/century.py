"""A synthetic century for the tests of pictures: circular ruptures whose slip, times and rates are known, on a fault of
20 x 10 km that creeps below 8 km, in the formats of -fault_output and -fault_catalogue."""

import h5py
import numpy as np

YEAR = 365.25 * 86400.0
RATE = 1e-9  # of loading [m/s]
SPEED, RISE = 2500.0, 3.0  # of fronts [m/s], duration of slip [s]
STIFFNESS = 5e6  # traction that falls for each metre of slip [Pa/m]
MODULUS = 30e9
# onset [years], x, z [m], radius [m], slip in the middle [m]
EVENTS = ((31.3, 4000.0, 6000.0, 2500.0, 0.9), (48.7, 15000.0, 5000.0, 3000.0, 1.3),
          (66.1, 7000.0, 6500.0, 3500.0, 1.6),
          (79.9, 12000.0, 3000.0, 2000.0, 0.7), (96.4, 10000.0, 5000.0, 7000.0, 2.2))
END = 110 * YEAR


def grid(nx=40, nz=20):
    """Cells of equal size: x, z, length, width [m]."""
    x, z = np.meshgrid((np.arange(nx) + 0.5) * 20000 / nx, (np.arange(nz) + 0.5) * 10000 / nz)
    one = np.ones(nx * nz)
    return x.ravel(), z.ravel(), 20000 / nx * one, 10000 / nz * one


def graded():
    """Irregular cells of 20 x 10 km: x, z, length, width."""
    x, z = (np.geomspace(1, 5, 21) - 1) / 4 * 20000, np.linspace(0, 10000, 11)
    centres = np.meshgrid((x[1:] + x[:-1]) / 2, (z[1:] + z[:-1]) / 2)
    return [part.ravel() for part in (*centres, *np.meshgrid(np.diff(x), np.diff(z)))]


def duration(event):
    return event[3] / SPEED + RISE


def rupture(event, x, z, time):
    """Slip [m], slip rate [m/s] and the time of the front [s] in each cell, so many seconds after the onset."""
    _, hx, hz, radius, slip = event
    away = np.hypot(x - hx, z - hz)
    size = slip * np.sqrt(np.maximum(1 - (away / radius) ** 2, 0.0)) * (z < 8000)
    s = np.clip((time - away / SPEED) / RISE, 0.0, 1.0)  # slip follows s^2 (3 - 2 s): it begins and ends at rest
    return size * s * s * (3 - 2 * s), size * 6 * s * (1 - s) / RISE, np.where(size > 0, away / SPEED, np.nan)


def state(x, z, time):
    """Slip and slip rate of all cells at a time [s]."""
    creep = np.where(z > 8000, RATE, 0.0)
    slip, rate = creep * time, creep + 0 * time
    for event in EVENTS:
        since = time - event[0] * YEAR
        if since >= 0:
            more, fast, _ = rupture(event, x, z, since)
            slip, rate = slip + more, rate + fast
    return slip, rate


def stored_times(step=0.25):
    """Every four years, and every step seconds during events."""
    inside = [event[0] * YEAR + np.arange(0, duration(event) + 2 * step, step) for event in EVENTS]
    return np.unique(np.concatenate([np.linspace(0, END, 28), *inside]))


def write_run(path, cells=None, planes=1, shape=(20, 40), fields=("slip_rate", "slip", "traction"), step=0.25):
    """The run; cells: irregular ones, on so many planes 2 km apart."""
    x, z, length, width = cells if cells is not None else grid(shape[1], shape[0])
    times = stored_times(step)
    slip, rate = np.array([state(x, z, time) for time in times]).swapaxes(0, 1)
    load = RATE * times[:, None]
    values = {"slip_rate": (rate, "m/s"), "slip": (slip, "m"), "displacement": (slip - load, "m"),
              "traction": (-20e6 - STIFFNESS * (load - slip), "Pa")}
    area = length * width / (length * width).sum()
    with h5py.File(path, "w") as file:
        file.attrs["complete"] = 1
        write_mesh(file, (x, z, length, width), cells is not None, planes)
        tail = (planes * len(x),) if cells is not None else shape
        put(file, "fields/time", times, "s")
        for name in fields:
            put(file, f"fields/{name}", np.tile(values[name][0], planes).reshape(len(times), *tail), values[name][1])
        rows = slice(1, None)
        series = {"time": (times[rows], "s"), "mean_slip_rate": ((rate @ area)[rows], "m/s"),
                  "max_slip_rate": (rate.max(axis=1)[rows], "m/s"),
                  "mean_slip": ((slip @ area)[rows], "m"), "mean_displacement": (((slip - load) @ area)[rows], "m"),
                  "sliding_fraction": ((rate > 0).mean(axis=1)[rows], "1")}
        for name, (column, unit) in series.items():
            put(file, f"series/{name}", column, unit)
        count = len(times) - 1
        steps = {"time": times[:-1], "dt": np.diff(times), "accepted": np.ones(count, dtype=int),
                 "error": np.full(count, 0.5),
                 "converged": np.ones(count, dtype=int), "newton_iterations": np.ones(count, dtype=int),
                 "linear_iterations": np.ones(count, dtype=int), "reason": np.ones(count, dtype=int),
                 "wall": np.full(count, 0.01)}
        for name, column in steps.items():
            put(file, f"steps/{name}", column, "s" if name in ("time", "dt", "wall") else "1")
        file.create_group("run").attrs["options"] = "-fault_nx 40"
        file.create_group("parameters").attrs.update({"length_x": 20000.0, "length_z": 10000.0, "depth_top": 0.0})
        file.create_group("result").attrs.update({"mean_slip": (slip @ area)[-1], "accepted": count, "rejected": 0,
                                                  "solves": count,
                                                  "newton_iterations": count, "linear_iterations": count,
                                                  "wall_time_setup": 0.0,
                                                  "wall_time_solve": 1.0})
    return path


def put(file, name, data, unit):
    file.create_dataset(name, data=data).attrs["units"] = unit


def write_mesh(file, cells, irregular, planes):
    x, z, length, width = cells
    if not irregular:
        put(file, "mesh/x", np.unique(x), "m")
        put(file, "mesh/z", np.unique(z), "m")
        return
    for name, column in (("x", x), ("z", z), ("length", length), ("width", width)):
        put(file, f"mesh/{name}", np.tile(column, planes), "m")
    put(file, "mesh/y", np.repeat(2000.0 * np.arange(planes), len(x)), "m")


def turn(path, cells, fault):
    """Gives a run or catalogue of irregular cells other places in space: cells [N, 7] and labels of faults [N]."""
    with h5py.File(path, "r+") as file:
        for name in list(file["mesh"]):
            del file["mesh"][name]
        for name, column in zip(("x", "y", "z", "length", "width", "strike", "dip"), np.asarray(cells).T):
            put(file, f"mesh/{name}", column, "degrees" if name in ("strike", "dip") else "m")
        file["mesh/fault"] = fault
    return path


def columns():
    """The catalogue of EVENTS: moments from the area means of slip, stress drops from the stiffness."""
    x, z, length, width = grid()
    rows = []
    for event in EVENTS:
        slip, _, front = rupture(event, x, z, 1e9)
        broken = slip > 0
        area = (length * width)[broken].sum()
        moment = MODULUS * (slip * length * width).sum()
        rows.append((event[0] * YEAR, event[0] * YEAR + duration(event), event[1], event[2], area, slip[broken].mean(),
                     slip.max(), moment, (np.log10(moment) - 9.1) / 1.5, STIFFNESS * slip[broken].mean(),
                     1.5 * slip.max() / RISE, np.argmin(np.hypot(x - event[1], z - event[2]))))
    names = ("onset", "end", "x", "z", "area", "mean_slip", "max_slip", "moment", "magnitude", "stress_drop",
             "peak_slip_rate", "cell")
    units = ("s", "s", "m", "m", "m^2", "m", "m", "N m", "1", "Pa", "m/s", "1")
    return {name: (np.array(column), unit) for name, unit, column in zip(names, units, zip(*rows))}


def write_catalogue(path, data=None, maps=True, skip=(), complete=1):
    """The catalogue, of EVENTS or of columns {name: (values, unit)} of one's own; skip: datasets to leave out."""
    x, z, _, _ = cells = grid()
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": "slipstep-catalogue", "version": 1, "complete": complete, "event_rate": 1e-3,
                           "shear_modulus": MODULUS,
                           "length_x": 20000.0, "length_z": 10000.0, "depth_top": 0.0})
        for name, (values, unit) in (data or columns()).items():
            if name not in skip:
                put(file, name, values, unit)
        write_mesh(file, cells, False, 1)
        if maps and data is None:
            found = [rupture(event, x, z, 1e9) for event in EVENTS]
            put(file, "maps/slip", np.array([slip for slip, _, _ in found]).reshape(-1, 20, 40), "m")
            put(file, "maps/rupture_time", np.array([front for _, _, front in found]).reshape(-1, 20, 40), "s")
    return path


def many(count=400, b=1.0, smallest=3.0, end=1000 * YEAR, seed=1):
    """A catalogue of independent events whose magnitudes follow Gutenberg and Richter exactly in law."""
    random = np.random.default_rng(seed)
    magnitude = smallest + random.exponential(1 / (b * np.log(10)), count)
    onset = np.sort(random.uniform(0, end, count))
    moment = 10 ** (1.5 * magnitude + 9.1)
    area = np.pi * (moment * 7 / 16 / 3e6) ** (2 / 3)  # a circular crack of 3 MPa
    data = columns()
    data = {name: (np.ones(count), unit) for name, (_, unit) in data.items()}
    for name, values in (("onset", onset), ("end", onset + 3), ("x", random.uniform(0, 20000, count)),
                         ("z", random.uniform(0, 10000, count)),
                         ("area", area), ("moment", moment), ("magnitude", magnitude),
                         ("stress_drop", np.full(count, 3e6))):
        data[name] = (values, data[name][1])
    return data
