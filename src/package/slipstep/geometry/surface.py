"""What slip on a fault does around it: the cells of a run or catalogue with their slip, and displacement and stress at
points by the program `elastic`, so that the formulas are the library's.

    from slipstep.geometry.surface import Elastic, slip_of_run
    source = slip_of_run(Run("run.h5"), 0, 1e9)
    Elastic(source).displacement(points)      # [n, 3] m, north, east, down
"""

import os
import subprocess
import tempfile

import h5py
import numpy as np

from ..errors import OutputError
from ..modules import find_program
from ..times import written
from .cells import cells_of, corners_of, directions, free_edges, free_sides, level_of, normals, triangles_of

NO_GROUND = "{}: a run in a full space, which has no ground; expected one with -fault_kernel half_space"


class Source:
    """Cells with slip along their rakes, and the rock.

    cells      [N, 7]     x y z length width [m], strike and dip [deg]
    rake       [N]        [deg]
    slip       [N]        [m], along the rake; or [N, 2], along strike and up dip
    words      what the slip is, for a title
    shape      of a grid, or None
    triangles  [N, 3, 3]  corners of cells that are triangles, north, east and down [m], counterclockwise around the
                          normals into their hanging walls; None: rectangles
    """

    def __init__(self, path, cells, rake, slip, shear_modulus, poisson_ratio, words, shape=None, triangles=None):
        self.path, self.cells, self.rake, self.slip = path, cells, rake, slip
        self.words, self.shape, self.triangles = words, shape, triangles
        self.shear_modulus, self.poisson_ratio = shear_modulus, poisson_ratio

    @property
    def vectors(self):
        """Slip [N, 3] along strike, up dip and opening."""
        if self.slip.ndim == 2:
            return np.pad(self.slip, ((0, 0), (0, 1)))
        turn = np.radians(self.rake)
        return np.stack([self.slip * np.cos(turn), self.slip * np.sin(turn), np.zeros_like(self.slip)], axis=1)

    @property
    def corners(self):
        """[N, 4, 3]: upper left, upper right, lower right, lower left, north, east and down [m]; or [N, 3, 3] of
        triangles."""
        return corners_of(self.cells) if self.triangles is None else self.triangles

    def outline(self):
        """Edges that cells do not share [m], [n, 2, 3] each: upper ones, and all others."""
        return free_edges(self.corners, self.shape) if self.triangles is None else free_sides(self.triangles)

    def level(self, depth):
        """Where cells are at a depth [m]: [n, 2, 3]."""
        if self.triangles is not None:
            return level_of(self.triangles, depth)
        corners = self.corners
        top, bottom = corners[:, 0, 2], corners[:, 3, 2]
        there = (top <= depth) & (depth <= bottom)
        share = ((depth - top[there]) / (bottom - top)[there])[:, None]
        lines = np.stack([corners[there, k] + share * (corners[there, 3 - k] - corners[there, k]) for k in (0, 1)],
                         axis=1)
        return np.stack([lines[0, 0], lines[-1, 1]])[None] if self.shape and len(lines) else lines

    def write(self, file):
        """Cells and slip, as the program elastic reads them."""
        file["slip"] = self.vectors
        if self.triangles is None:
            file["cells"] = self.cells
            return
        corners = self.triangles
        file["vertices"], file["triangles"] = corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
        file["hanging_wall"] = normals(corners)


def _rake(mesh, n):
    return np.asarray(mesh.get("rake", np.zeros(n)), float).reshape(-1)


def window_of(run, times, begin, end):
    """Begin and end [s] within the times of the rows of /fields, by default all of them."""
    begin, end = times[0] if begin is None else begin, times[-1] if end is None else end
    if not times[0] <= begin < end <= times[-1] * (1 + 1e-12):
        raise OutputError(f"{run.path}: /fields is from {written(times[0])} to {written(times[-1])}, expected a "
                          "window within")
    return begin, end


def slip_at(times, data, time):
    """A field of a file at a time [s], linear between its rows, of which no more than two are read."""
    row = int(np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2))
    share = min((time - times[row]) / (times[row + 1] - times[row]), 1.0)
    low, high = data[row], data[row + 1].astype(float)
    return low + share * (high - low)


def slip_of_run(run, begin=None, end=None, field="displacement"):
    """What slipped between two times [s] of a run, linear between the entries of /fields; by default displacement,
    relative to the far field."""
    run.require_fault("a map of the ground")
    parameters = run.parameters
    missing = [name for name in ("shear_modulus", "poisson_ratio") if name not in parameters]
    if missing:
        raise OutputError(f"{run.path}: attribute {missing[0]} of /parameters is missing; expected a file of SlipStep "
                          "0.3 or later")
    if parameters.get("kernel") == "full_space":
        raise OutputError(NO_GROUND.format(run.path))
    with run.open() as file:
        times, data = run.stored(file, field)
        if len(times) < 2:
            raise OutputError(f"{run.path}: /fields/{field} has {len(times)} rows, expected two or more")
        begin, end = window_of(run, times, begin, end)
        components = (2,) if run.has_vectors(field) else ()
        first, last = (slip_at(times, data, time).reshape(-1, *components) for time in (begin, end))
    cells, shape = cells_of(run.path, run.mesh, parameters)
    what = ("slip" if field == "slip" else "slip less that of the far field"
            if np.any(run.mesh.get("loading_rate", 0.0)) else "slip")
    return Source(run.path, cells, _rake(run.mesh, len(cells)), last - first, parameters["shear_modulus"],
                  parameters["poisson_ratio"], f"{what} from {written(begin)} to {written(end)}", shape,
                  triangles_of(run.mesh))


def slip_of_event(catalogue, number):
    """What slipped in an event of a catalogue, counted from 0."""
    if not 0 <= number < catalogue.count:
        raise OutputError(f"{catalogue.path}: there is no event {number + 1}, expected one from 1 to {catalogue.count}")
    if catalogue.attributes.get("kernel") == "full_space":
        raise OutputError(NO_GROUND.format(catalogue.path))
    if catalogue.has_vectors:
        slip = np.stack([catalogue.map(f"slip_{part}")[number].reshape(-1) for part in ("along_strike", "up_dip")],
                        axis=-1)
    else:
        slip = catalogue.map("slip")[number].reshape(-1) * catalogue.event["direction"][number]
    cells, shape = cells_of(catalogue.path, catalogue.mesh, catalogue.attributes)
    return Source(catalogue.path, cells, _rake(catalogue.mesh, len(cells)), slip, catalogue.attributes["shear_modulus"],
                  catalogue.attributes.get("poisson_ratio", 0.25),
                  f"event {number + 1}, M {catalogue.event['magnitude'][number]:.2f}, "
                  f"at {written(catalogue.event['onset'][number])}", shape, triangles_of(catalogue.mesh))


def slip_of_input(path):
    """Slip on rectangles or triangles in a file that `elastic` reads, as slipstep convert writes them; the rock is that
    of the attributes shear_modulus [Pa] and poisson_ratio, by default that of `elastic`."""
    with h5py.File(path) as file:
        try:
            slip = file["slip"][:, :2]
            triangles = file["vertices"][()][file["triangles"][()].astype(int)] if "triangles" in file else None
            cells = file["cells"][()] if triangles is None else np.pad(triangles.mean(axis=1), ((0, 0), (0, 4)))
            if len(slip) != len(cells) or triangles is None and cells.shape[1] != 7:
                raise OutputError(f"{path}: /slip has {len(slip)} rows and there are {len(cells)} cells, expected as "
                                  "many, with seven numbers")
        except (KeyError, ValueError, IndexError) as error:
            raise OutputError(f"{path}: {error.args[0]}; expected /cells [N, 7] or /vertices and /triangles, and "
                              "/slip [N, 3]") from None
        rock = [float(file.attrs.get(name, value))
                for name, value in (("shear_modulus", 30e9), ("poisson_ratio", 0.25))]
    return Source(path, cells, np.zeros(len(cells)), slip, *rock, "slip of the file", None, triangles)


class Elastic:
    """Displacement and stress by a source, on so many processes."""

    def __init__(self, source, ranks=1):
        self.source, self.ranks, self.program = source, ranks, find_program("elastic")
        if not self.program:
            raise OutputError("the program elastic is not there: build SlipStep, or set SLIPSTEP_BUILD")

    def _run(self, points, *options):
        with tempfile.TemporaryDirectory() as folder:
            given, taken = os.path.join(folder, "in.h5"), os.path.join(folder, "out.h5")
            with h5py.File(given, "w") as file:
                self.source.write(file)
                file["points"] = points
            command = ["mpirun", "-n", str(self.ranks)] if self.ranks > 1 else []
            command += [self.program, "-elastic_input", given, "-elastic_output", taken, "-elastic_poisson_ratio",
                        repr(float(self.source.poisson_ratio)), "-elastic_shear_modulus",
                        repr(float(self.source.shear_modulus)), *options]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                raise OutputError(f"elastic failed: {done.stderr.strip() or done.returncode}")
            with h5py.File(taken) as file:
                return {name: data[()] for name, data in file.items()}

    def displacement(self, points):
        """[n, 3] north, east and down [m] at points [n, 3] [m]."""
        return self._run(points)["displacement"]

    def tractions(self, cells, rake):
        """Changes [Pa] on cells [N, 7] of rakes [N], at their centres: of the shear stress that drives slip along the
        rake, [N], and of normal stress, positive in compression, [N]. Frame and signs are those of src/geometry.md."""
        xx, yy, zz, xy, xz, yz = self._run(cells[:, :3], "-elastic_stress")["stress"].T
        stress = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        along, down = directions(cells)
        turn = np.radians(rake)[:, None]
        slip = np.cos(turn) * along - np.sin(turn) * down
        normal = np.cross(along, -down)  # into the hanging wall
        pull = np.einsum("ijn,nj->ni", stress, normal)
        return np.einsum("ni,ni->n", pull, slip), -np.einsum("ni,ni->n", pull, normal)

    def coulomb(self, points, receiver, friction):
        """Change of Coulomb stress [n] on planes of a strike, dip and rake [deg], of the shear stress along the rake,
        and of normal stress, positive in compression [Pa]."""
        traction = self._run(points, "-elastic_receiver",
                             ",".join(repr(float(angle)) for angle in receiver))["traction"]
        shear, normal = -traction[:, 0], traction[:, 2]
        return shear - friction * normal, shear, normal


def look_vector(azimuth, incidence):
    """From the ground to a satellite, north, east and down: azimuth of where it is, clockwise from north, and incidence
    from the vertical [deg]."""
    azimuth, incidence = np.radians(azimuth), np.radians(incidence)
    return np.array([np.sin(incidence) * np.cos(azimuth), np.sin(incidence) * np.sin(azimuth), -np.cos(incidence)])
