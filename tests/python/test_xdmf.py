#!/usr/bin/env python3
"""FILE.xdmf2 beside -fault_output: well formed at every moment, with the cells where they are, the fields by name,
times and values of the HDF5 file. Read here as the format says, and by ParaView's own reader (vtkXdmfReader, of
Debian's python3-paraview) where it is."""
import os
import shutil
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

from scripts import FAULT, TWO_PLANES, FaultTest

import h5py
import numpy as np

from slipstep.results.files import open_file

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
except ImportError:
    vtkXdmfReader = None

GRID = ["-fault_nx", "6", "-fault_nz", "5", "-fault_depth_top", "1000", "-ts_max_time", "4"]
FIELDS = {"slip_rate", "slip", "displacement", "traction"}


def item(folder, node, part=()):
    """The array of a DataItem, or of slices of it. No more is read: entries that kept views of whole fields, of a run
    that goes on, took 23 GB."""
    children = list(node)
    if node.get("ItemType") == "HyperSlab":
        start, stride, count = item(folder, children[0]).astype(int)
        data = item(folder, children[1], tuple(slice(a, a + b * c, b) for a, b, c in zip(start, stride, count)))
    elif node.get("Format") == "XML":
        data = np.array(node.text.split(), dtype=float)
    else:
        name, path = node.text.strip().split(":")
        with open_file(os.path.join(folder, name), "") as file:
            # a run that goes on has more meanwhile
            data = file[path][part or slice(int(node.get("Dimensions").split()[0]))]
        assert (data.dtype.kind == {"Int": "i", "Float": "f"}[node.get("NumberType")]
                and data.dtype.itemsize == int(node.get("Precision")))
    return data if part else data.reshape([int(n) for n in node.get("Dimensions").split()])


def by_format(path):
    """Times, and for each corners of cells [N, 4, 3] and a dict of fields [N]."""
    folder = os.path.dirname(path)
    root = ElementTree.parse(path).getroot()
    assert root.tag == "Xdmf"
    times, entries = [], []
    for grid in root.find("Domain/Grid[@CollectionType='Temporal']").findall("Grid"):
        times.append(float(grid.find("Time").get("Value")))
        cells = item(folder, grid.find("Topology/DataItem"))
        assert (grid.find("Topology").get("TopologyType") == "Quadrilateral"
                and int(grid.find("Topology").get("NumberOfElements")) == len(cells))
        corners = item(folder, grid.find("Geometry/DataItem"))[cells]
        assert all(node.get("Center") == "Cell" for node in grid.findall("Attribute"))
        entries.append((corners, {node.get("Name"): item(folder, node.find("DataItem")).reshape(-1)
                                  for node in grid.findall("Attribute")}))
    return np.array(times), entries


def by_vtk(path):
    reader = vtkXdmfReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    entries = []
    for now in times:
        reader.UpdateTimeStep(now)
        grid = reader.GetOutputDataObject(0)
        while grid.IsA("vtkMultiBlockDataSet"):
            grid = grid.GetBlock(0)
        assert all(grid.GetCellType(e) == 9 for e in range(grid.GetNumberOfCells()))  # VTK_QUAD
        points = vtk_to_numpy(grid.GetPoints().GetData())
        cells = np.array([[grid.GetCell(e).GetPointId(k) for k in range(4)] for e in range(grid.GetNumberOfCells())])
        data = grid.GetCellData()
        entries.append((points[cells], {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k))
                                        for k in range(data.GetNumberOfArrays())}))
    return np.array(times), entries


READERS = [by_format] + ([by_vtk] if vtkXdmfReader else [])


class Xdmf(FaultTest):
    @staticmethod
    def numbers(fields, cells):
        """Of each entry and cell: a field of two components is two."""
        found = {}
        for key, data in fields.items():
            data = data.reshape(len(data), cells, -1)
            names = (key,) if data.shape[-1] == 1 else (f"{key}_along_strike", f"{key}_up_dip")
            found.update((name, data[..., k]) for k, name in enumerate(names))
        return found

    def compare(self, xdmf, h5, centre, size, least=10, readers=READERS):
        """centre [N, 3] with depths downwards, size [N, 2]. The number of entries"""
        for read in readers:
            times, entries = read(self.path(xdmf))
            with open_file(self.path(h5), "") as file:  # after the text, as it may grow
                want = self.numbers({key: data[...] for key, data in file["fields"].items()
                                     if "CLASS" not in data.attrs}, len(centre))
                expected = file["fields/time"][...]
            self.assertGreaterEqual(len(times), least)
            np.testing.assert_array_equal(times, expected[: len(times)])
            for k, (corners, fields) in enumerate(entries):
                self.assertEqual(set(fields), set(want))
                for key, values in fields.items():
                    np.testing.assert_array_equal(values, want[key][k], f"{key} {k}")
                # corners are sums of numbers of up to 1e4 m, in double precision or, by vtk, in single
                np.testing.assert_allclose(corners.mean(axis=1), centre * [1, 1, -1], rtol=0, atol=1e-3)
                np.testing.assert_allclose(corners[:, 2] - corners[:, 0],
                                           np.column_stack([size[:, 0], 0 * size[:, 0], -size[:, 1]]), rtol=0,
                                           atol=2e-3)
                # the first edge is along strike
                np.testing.assert_allclose(corners[:, 1, 2], corners[:, 0, 2], rtol=0, atol=0)
        return len(times)

    def grid(self):
        z, x = np.meshgrid(1000 + 600 * (np.arange(5) + 0.5), 500 * (np.arange(6) + 0.5), indexing="ij")
        return np.column_stack([x.ravel(), 0 * x.ravel(), z.ravel()]), np.tile([500.0, 600.0], (30, 1))

    def test_grid(self):
        for name, options in (("a.h5", []),
                              ("of & two.h5", ["-fault_output_precision", "single", "-fault_output_compression", "5"]),
                              ("fewer.h5",
                               ["-fault_output_fields", "slip,traction", "-fault_output_time_interval", "0.3"])):
            self.fault(*GRID, "-fault_output", name, *options)
            self.compare(name + ".xdmf2", name, *self.grid())
        self.assertEqual(sorted(os.listdir(self.folder.name)),
                         sorted(n + e for n in ("a.h5", "of & two.h5", "fewer.h5") for e in ("", ".xdmf2")))

    def test_vectors(self):
        """Two components of slip, on a grid and on a mesh: a number for each."""
        vectors = ["-fault_slip_components", "2", "-fault_rake", "30", "-ts_max_time", "3", "-fault_output_fields",
                   "slip,traction,state"]
        self.fault(*GRID, *vectors, "-fault_output", "a.h5")
        self.compare("a.h5.xdmf2", "a.h5", *self.grid())
        self.make_mesh("mesh", "uniform --cells 4 3")
        cells = self.get("mesh", "cells")
        self.fault("-fault_mesh", "mesh", *vectors, "-fault_output", "b.h5")
        self.compare("b.h5.xdmf2", "b.h5", cells[:, :3], cells[:, 3:])

    def test_mesh_on_ranks(self):
        self.make_mesh("mesh", TWO_PLANES)
        cells = self.get("mesh", "cells")
        for ranks in (1, 2):
            self.fault("-fault_mesh", "mesh", "-ts_max_time", "3", "-fault_output", f"{ranks}.h5", ranks=ranks)
            self.compare(f"{ranks}.h5.xdmf2", f"{ranks}.h5", cells[:, :3], cells[:, 3:])

    def test_planes_of_any_direction(self):
        """A grid that dips, one plane, a listric fault and segments: each cell goes from its upper corner along the
        strike and down the dip, as the words of geometry.md have it; rows and segments meet in their corners, which
        asks for no formula of directions."""
        load = ["-fault_friction_law", "rate_and_state", "-fault_normal_stress", "50e6",
                "-fault_normal_stress_gradient", "0", "-fault_rake", "90",
                "-fault_loading_rate", "1e-9", "-fault_friction_slip", "0.05", "-ts_max_time", "1e6"]
        self.fault(*load, "-fault_nx", 4, "-fault_nz", 3, "-fault_length_x", 2000, "-fault_length_z", 1500,
                   "-fault_strike", 110, "-fault_dip", 35, "-fault_depth_top", 700, "-fault_output", "grid.h5")
        s, d = (part.ravel() for part in np.meshgrid((np.arange(4) + 0.5) * 500, (np.arange(3) + 0.5) * 500))
        turn, dip = np.radians(110), np.radians(35)
        centres = np.column_stack([s * np.cos(turn) - d * np.cos(dip) * np.sin(turn),
                                   s * np.sin(turn) + d * np.cos(dip) * np.cos(turn), 700 + d * np.sin(dip)])
        self.oriented("grid", np.column_stack([centres, np.tile([500, 500, 110, 35], (12, 1))]))
        for kind, options in (("dipping", "--strike 200 --dip 50"), ("listric", "--strike 310 --dip 75"),
                              ("segmented", "--strikes 0 40 20 --dip 60")):
            self.make_mesh("mesh", f"{kind} --cells 4 3 --size 4000 2000 {options}")
            cells = self.get("mesh", "cells")
            self.fault(*load, "-fault_mesh", "mesh", "-fault_output", f"{kind}.h5")
            corners = self.oriented(kind, cells).reshape(-1, 3, 4, 4, 3)  # segment, row, column, corner
            np.testing.assert_allclose(corners[:, :-1, :, 3, 2], corners[:, 1:, :, 0, 2], atol=1e-3)
            np.testing.assert_allclose(corners[:, :, :-1, 1:3], corners[:, :, 1:, [0, 3]], atol=1e-3)
            if kind != "segmented":
                np.testing.assert_allclose(corners[:, :-1, :, [3, 2]], corners[:, 1:, :, [0, 1]], atol=1e-3)
            meet = [np.linalg.norm(corners[:-1, :, -1, 1 + k] - corners[1:, :, 0, 3 * k], axis=2) for k in (0, 1)]
            # of each row the upper or the lower corner is on the bend
            np.testing.assert_allclose(np.minimum(*meet), 0, atol=1e-3)

    def oriented(self, name, cells):
        """Corners of the last entry [N, 4, 3], which are those of cells [N, 7]; to 1e-3 m: vtk has single precision."""
        turn, dip = np.radians(cells[:, 5]), np.radians(cells[:, 6])
        along = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
        # z is upward here
        down = np.column_stack([-np.sin(turn) * np.cos(dip), np.cos(turn) * np.cos(dip), -np.sin(dip)])
        for read in READERS:
            _, entries = read(self.path(f"{name}.h5.xdmf2"))
            corners, fields = entries[-1]
            self.assertIn("slip", fields)
            np.testing.assert_allclose(corners.mean(axis=1), cells[:, :3] * [1, 1, -1], rtol=0, atol=1e-3)
            for a, b, side in ((0, 1, cells[:, 3:4] * along), (3, 2, cells[:, 3:4] * along),
                               (0, 3, cells[:, 4:5] * down)):
                np.testing.assert_allclose(corners[:, b] - corners[:, a], side, rtol=0, atol=2e-3)
        return corners

    def test_while_it_goes(self):
        """At every moment FILE.part.xdmf2 can be read, with FILE.part; it grows; a kill leaves both, and a restart goes
        on. Plain readers, as that of vtk, are refused while a flush is written, a moment that comes ten times a second
        here. A reader, of which a look takes a time for each entry, keeps up with an entry every 500 steps; the run
        would end by itself after 4,000."""
        slow = [FAULT, *GRID[:-1], "1e4", "-ts_adapt_type", "none", "-ts_dt", "1e-3", "-fault_output", "a.h5",
                "-fault_output_interval", "500",
                "-ts_max_steps", "2000000", "-fault_checkpoint", "state", "-fault_checkpoint_interval", "0.2"]
        run = subprocess.Popen(slow, cwd=self.folder.name, stdout=subprocess.DEVNULL)
        self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        seen = []
        while len(set(seen)) < 4 or not os.path.exists(self.path("state.previous")):
            self.assertIsNone(run.poll())
            if os.path.exists(self.path("a.h5.part.xdmf2")):
                seen.append(self.compare("a.h5.part.xdmf2", "a.h5.part", *self.grid(), least=1, readers=[by_format]))
        run.kill()
        run.wait()
        self.assertEqual(seen, sorted(seen))
        self.assertGreaterEqual(len(set(seen)), 4)
        self.compare("a.h5.part.xdmf2", "a.h5.part", *self.grid(), least=seen[-1])
        self.assertFalse(os.path.exists(self.path("a.h5.xdmf2")))
        with open_file(self.path("a.h5.part"), "") as file:
            steps = len(file["steps/dt"]) + 1  # more than the checkpoint has
        self.fault(*slow[1:], "-fault_restart", "state", "-ts_max_steps", str(steps), code=3)
        n = self.compare("a.h5.xdmf2", "a.h5", *self.grid(), least=2)
        self.assertEqual(n, len(self.get("a.h5", "fields/time")))
        self.assertFalse(os.path.exists(self.path("a.h5.part.xdmf2")))

    def test_none(self):
        """Neither without fields nor where it is not wanted, or has a name that XDMF does not know."""
        self.assertIn("no c:d.h5.xdmf2 is written", self.fault(*GRID, "-fault_output", "c:d.h5"))
        self.fault(*GRID, "-fault_output", "a.h5", "-fault_output_xdmf", "no")
        self.fault(*GRID, "-fault_output", "b.h5", "-fault_output_fields", "")
        self.assertEqual(sorted(os.listdir(self.folder.name)), ["a.h5", "b.h5", "c:d.h5"])
        with h5py.File(self.path("a.h5")) as file:
            self.assertNotIn("xdmf", file)

    @unittest.skipUnless(shutil.which("pvpython"), "pvpython is missing: apt-get install python3-paraview (0.7 GB)")
    def test_paraview_chooses_the_reader(self):
        self.fault(*GRID, "-fault_output", "a.h5")
        self.put("open.py", "from paraview.simple import *\n"
                 f"print(sorted(OpenDataFile({self.path('a.h5.xdmf2')!r}).CellData.keys()))\n")
        done = subprocess.run(["pvpython", "--force-offscreen-rendering", self.path("open.py")], capture_output=True,
                              text=True)
        self.assertIn(str(sorted(FIELDS)), done.stdout, done.stderr)

    @unittest.skipUnless(vtkXdmfReader, "vtkXdmfReader is missing: apt-get install python3-paraview (0.7 GB)")
    def test_vtk_was_there(self):
        self.assertIn(by_vtk, READERS)


if __name__ == "__main__":
    unittest.main()
