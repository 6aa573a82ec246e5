"""Read the file of evaluate: Study(path), its cells (one run each) and references.

    from slipstep.results.study import Study study = Study("output/study.h5") for cell in study.select(problem="fault",
    size_km=3, mesh=50, controller="rl"):
        cell.name, cell["solves"], cell["final_error"], cell.series()["mean_slip"]
"""

import os
import re
import sys

import numpy as np

from ..errors import OutputError
from ..modules import program
from .course import Course, slip_at
from .files import attributes, open_file, plain

FORMAT = "slipstep-evaluation"
CLASSICAL = ("heuristic", "pi", "dsp", "basic", "none")
ATTEMPTS = ("time", "dt", "accepted", "error", "converged")


def _columns(dataset):
    """A dataset with the attribute columns "time s, mean_slip m, ..." as a dict of arrays."""
    names = [part.strip().split(" ")[0] for part in plain(dataset.attrs["columns"]).split(",")]
    return dict(zip(names, dataset[()].T))


def integral(time, values):
    """Trapezoidal rule."""
    return 0.5 * np.sum(np.diff(time) * (values[1:] + values[:-1]))


class Cell:
    """One run of the matrix: cell["solves"], cell["attempts"] and other attributes; series, attempts and profile are
    read when asked for."""

    def __init__(self, study, path, attributes):
        self.study, self.path, self.attributes = study, path, attributes
        if "policy" in attributes:
            attributes["policy_name"] = attributes["policy"]
        if attributes.get("accuracy", 0) > 0:  # a policy with a dial counts as one policy for each of its settings
            attributes["policy"] += f"@{attributes['accuracy']:g}"
        attributes.setdefault("cpu", np.nan)
        if "accepted" in attributes:
            attributes["attempts"] = attributes["accepted"] + attributes["rejected"]

    def __getitem__(self, key):
        if key == "history_error" and key not in self.attributes:
            self.attributes[key] = self._history_error()
        return self.attributes[key]

    def _history_error(self):
        """Error between the steps too, at the times of the reference. Errors at the ends of steps miss what a long step
        jumps over.

        Fault: the largest error of mean slip over its final value, the run taken by the cubics of mean slip and its
        rate. Others: the L2 error of the states, the run linear between its steps; over that of the reference but for
        sliding_mode.
        """
        reference, own = self.study.reference(self.case), self.series()
        time = reference["time"]
        if self["problem"] == "fault":
            found = Course(own["time"], own["mean_slip"], own["mean_slip_rate"])
            return float(np.abs(slip_at(found, time) - reference["mean_slip"]).max() / abs(reference["mean_slip"][-1]))
        states = [name for name in reference if name not in ("time", "reaction")]
        error = sum((np.interp(time, own["time"], own[name]) - reference[name])**2 for name in states)
        size = sum(reference[name]**2 for name in states) if self["problem"] != "sliding_mode" else np.ones_like(time)
        return float(np.sqrt(integral(time, error) / integral(time, size)))

    def get(self, key, default=None):
        return self.attributes.get(key, default)

    @property
    def case(self):
        """Group of its problem, size and mesh."""
        return self.path.split("/")[-2]

    @property
    def name(self):
        """What chose its steps: the policy's name, or the controller's."""
        return self.get("policy") or self["controller"]

    @property
    def learned(self):
        return self["controller"] == "rl"

    @property
    def converged(self):
        return bool(self["converged"])

    @property
    def treatment(self):
        """Estimate and reaction; of constant steps the estimate is "none"."""
        return self["error"], self["reaction"]

    def error(self, measure="final_error"):
        """Size of one of its errors."""
        return abs(self[measure])

    def _read(self, name):
        with self.study.open() as file:
            group = file[self.path]
            if name not in group:
                raise OutputError(f"{self.study.path}: {self.path} has no {name}")
            return _columns(group[name]) if name == "series" else group[name][()]

    def series(self):
        """dict of arrays, one value per accepted step, the start included."""
        return self._read("series")

    def attempts(self):
        """dict of arrays, one value per attempt."""
        return dict(zip(ATTEMPTS, self._read("attempts").T))

    def profile(self):
        """Times [n] and slip rate averaged along strike [n, mesh] by depth, of a converged run at the reference
        tolerance."""
        data = self._read("profile")
        return data[:, 0], data[:, 1:]


class Study:
    """All cells and references of a file, but for cells of replaced policies: how many those are, outdated says for
    each name."""

    def __init__(self, path):
        self.path = os.fspath(path)
        with self.open() as file:
            self.attributes = attributes(file)
            found = self.attributes.get("format", "")
            if found != FORMAT:
                raise OutputError(f"{self.path}: not a file of evaluate (attribute format is \"{found}\", expected "
                                  f"\"{FORMAT}\")")
            self.cells = [Cell(self, cell.name, attributes(cell))
                          for case in file.get("cells", {}).values() for cell in case.values()]
            self.cells, self.outdated = newest(self.cells)
            self.references = {name: attributes(group) for name, group in file.get("references", {}).items()}

    def warn(self):
        """Say on the error output which cells are left out."""
        for name, count in self.outdated.items():
            print(f"{program()}: warning: {self.path} has {count} cells of another file of the policy {name}, which "
                  "are left out; evaluate makes them anew", file=sys.stderr)

    def open(self):
        return open_file(self.path, f"evaluate -evaluate_output {self.path} writes it")

    def select(self, **wanted):
        """Cells whose attributes have these values (a tuple: one of them); failed ones too unless converged=1 is asked
        for."""
        def fits(cell):
            return all(cell.get(key) in value if isinstance(value, tuple) else cell.get(key) == value
                       for key, value in wanted.items())
        return [cell for cell in self.cells if fits(cell)]

    def one(self, **wanted):
        """The cell with these attributes, None when it is missing."""
        found = self.select(**wanted)
        return found[0] if found else None

    def reference(self, case):
        """Series of a reference, dict of arrays, the start included."""
        if case not in self.references:
            raise OutputError(f"{self.path}: no reference of {case}; it has {', '.join(self.references) or 'none'}")
        with self.open() as file:
            return _columns(file[f"references/{case}/series"])

    def reference_profile(self, case):
        with self.open() as file:
            data = file[f"references/{case}/profile"][()]
        return data[:, 0], data[:, 1:]

    def axis(self, key, **wanted):
        """Values that an attribute takes, ascending."""
        return sorted({cell[key] for cell in self.select(**wanted) if key in cell.attributes})

    def policies(self, problem):
        """Names of the policies of a problem, by family and alpha."""
        alphas = {cell["policy"]: cell["policy_alpha"] for cell in self.select(problem=problem, controller="rl")}
        return sorted(alphas, key=lambda name: (family(name), family(name) != name,
                                                alphas[name] if np.isfinite(alphas[name]) else 0.0, name))

    def sweeps(self, problem="fault"):
        """Families of policies that differ in alpha: {family: {alpha: name}}, the largest first."""
        found = {}
        for cell in self.select(problem=problem, controller="rl"):
            # its name says the alpha
            if np.isfinite(cell["policy_alpha"]) and family(cell["policy"]) != cell["policy"]:
                found.setdefault(family(cell["policy"]), {})[cell["policy_alpha"]] = cell["policy"]
        return dict(sorted(((k, dict(sorted(v.items()))) for k, v in found.items() if len(v) > 1),
                           key=lambda item: -len(item[1])))


def newest(cells):
    """Cells without those of a policy that has been replaced by another file of its name, and how many these are for
    each name.

    The file that the newest cell of the name was made with counts; cells without a date are the oldest.
    """
    latest = {}
    for cell in cells:
        if cell.learned:
            latest.setdefault(cell["policy_name"], {}).setdefault(cell["policy_hash"],
                                                                  []).append(cell.get("created", ""))
    current = {name: max(files, key=lambda file: max(files[file])) for name, files in latest.items()}
    old = [cell for cell in cells if cell.learned and cell["policy_hash"] != current[cell["policy_name"]]]
    counts = {name: sum(cell["policy_name"] == name for cell in old)
              for name in sorted({cell["policy_name"] for cell in old})}
    return [cell for cell in cells if cell not in old], counts


def family(name):
    """A policy's name without its alpha: fault_tqc_alpha_8 and fault_tqc_a16 are of families fault_tqc."""
    return re.sub(r"[_-]?(alpha|a)[_-]?[0-9][0-9.p]*", "", name)


def envelope(cells, measure="final_error"):
    """The cheapest way to each error: (solves, errors) of the runs that no other beats in both, solves ascending."""
    points = sorted((cell["solves"], cell.error(measure)) for cell in cells if cell.converged)
    best, solves, errors = np.inf, [], []
    for n, error in points:
        if error < best:
            best = error
            solves.append(n)
            errors.append(error)
    return np.array(solves), np.array(errors)


def cheapest(cells, limits):
    """The converged run of fewest solves with errors of at most limits {measure: limit}, or None."""
    good = [cell for cell in cells if cell.converged
            and all(cell.error(measure) <= limit for measure, limit in limits.items())]
    return min(good, key=lambda cell: cell["solves"]) if good else None
