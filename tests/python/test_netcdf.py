#!/usr/bin/env python3
"""Files as other tools see them: every dimension of a run, its stations and a catalogue has a name, for xarray by both
of its engines and for ncdump; grids, meshes, triangles, vectors, several faults, two ranks, and a run that went on."""

import importlib.util
import shutil
import subprocess
import unittest

from scripts import FaultTest

import meshfiles
import h5py
import numpy as np

from slipstep import Catalogue

ENGINES = [engine for engine, module in (("netcdf4", "netCDF4"), ("h5netcdf", "h5netcdf"))
           if importlib.util.find_spec(module)]
XARRAY = importlib.util.find_spec("xarray") and ENGINES
GRID = ("-fault_nx", "4", "-fault_nz", "4", "-ts_max_time", "8", "-fault_output", "run.h5", "-fault_catalogue",
        "events.h5", "-fault_catalogue_maps", "-fault_stations",
        "500,500;1500,1500", "-fault_surface_stations", "0,100;500,500")


class NetcdfTest(FaultTest):
    def dimensions(self, name):
        """dataset: names of its dimensions, of all datasets of a file; each dimension has one name, and a scale of its
        length"""
        found = {}

        def visit(path, item):
            if isinstance(item, h5py.Dataset):
                for k, length in enumerate(item.shape):
                    if "CLASS" not in item.attrs:
                        self.assertEqual((len(item.dims[k]), item.dims[k][0].shape), (1, (length,)), (path, k))
                found[path] = ((path.split("/")[-1],) if "CLASS" in item.attrs
                               else tuple(item.dims[k][0].name.split("/")[-1] for k in range(item.ndim)))

        with h5py.File(self.path(name)) as file:
            file.visititems(visit)
        return found

    def columns(self, name, faults):
        """Datasets of the root have the rows of the events, but for the axis of faults, and readers count the
        events."""
        with h5py.File(self.path(name)) as file:
            events = len(file["onset"])
            self.assertEqual({key: len(data) for key, data in file.items() if isinstance(data, h5py.Dataset)
                              and len(data) != events},
                             {"fault_index": faults} if faults and faults != events else {})
        self.assertEqual(Catalogue(self.path(name)).count, events)

    def opened(self, name, group):
        import xarray
        sets = [xarray.open_dataset(self.path(name), group=group, engine=engine) for engine in ENGINES]
        for other in sets[1:]:
            xarray.testing.assert_equal(sets[0], other)
        for one in sets:
            self.addCleanup(one.close)
        return sets[0]

    def test_grid(self):
        """The same on two ranks, and where the second half of the run is another one's."""
        self.fault(*GRID, "-fault_checkpoint", "state.h5")
        of = self.dimensions("run.h5")
        self.assertEqual((of["fields/slip"], of["mesh/normal_stress"], of["series/moment_rate"], of["steps/dt"]),
                         (("time", "z", "x"), ("z", "x"), ("time", "fault_index"), ("time",)))
        self.assertEqual((of["stations/1/slip"], of["surface/0/displacement"]), (("time",), ("time", "component")))
        events = self.dimensions("events.h5")
        self.assertEqual((events["magnitude"], events["maps/slip"]), (("onset",), ("onset", "z", "x")))
        before = h5py.File(self.path("run.h5"))["fields/slip"][()]
        self.fault(*GRID, "-ts_max_time", "9", "-fault_restart", "state.h5", "-fault_checkpoint", "state.h5")
        self.assertEqual(self.dimensions("run.h5"), of)
        self.assertGreater(len(self.get("run.h5", "fields/slip")), len(before))
        if XARRAY:
            fields = self.opened("run.h5", "fields")
            self.assertEqual((fields.slip.dims, fields.slip.attrs["units"], fields.x.attrs["units"]),
                             (("time", "z", "x"), "m", "m"))
            np.testing.assert_array_equal(fields.slip[: len(before)], before)
            np.testing.assert_array_equal(fields.x, 750 * (np.arange(4) + 0.5))
            self.assertEqual(self.opened("events.h5", None).magnitude.dims, ("onset",))
            self.assertEqual(self.opened("run.h5", "stations/0").slip_rate.dims, ("time",))
        self.fault(*GRID, "-fault_output_overwrite", ranks=2)
        self.assertEqual(self.dimensions("run.h5"), of)

    def test_vectors(self):
        self.fault(*GRID[:-2], "-fault_slip_components", "2")
        of = self.dimensions("run.h5")
        self.assertEqual((of["fields/slip"], of["stations/0/slip"]),
                         (("time", "z", "x", "component"), ("time", "component")))
        self.assertEqual(self.dimensions("events.h5")["maps/slip"], ("onset", "z", "x", "component"))
        self.columns("events.h5", 0)

    def test_meshes(self):
        """Two faults of triangles, and rectangles: a number for each cell, and one for each fault."""
        vertices, triangles = meshfiles.joined(*(meshfiles.plane((2, 2), (500, 500), 0, 90, (0, y, 100))
                                                 for y in (0, 5000)))
        meshfiles.write_hdf5(self.path("triangles.h5"), vertices, triangles, fault=np.repeat([3, 8], 8))
        with h5py.File(self.path("cells.h5"), "w") as file:
            file["cells"] = [[250 + 500 * i, 0, 350, 500, 500] for i in range(3)]
            file["cells"].attrs["columns"] = "x y z length width"
        for mesh in ("triangles", "cells"):
            self.fault("-fault_mesh", f"{mesh}.h5", *GRID[4:8], "-fault_catalogue", "events.h5",
                       "-fault_catalogue_maps", "-fault_output_overwrite", "-fault_normal_stress", 1e6,
                       "-fault_normal_stress_gradient", 15e3, "-ts_max_time", 2)
            of, events = self.dimensions("run.h5"), self.dimensions("events.h5")
            self.assertEqual((of["fields/slip"], of["mesh/length"], of["series/moment_rate"]),
                             (("time", "cell"), ("cell",), ("time", "fault_index")))
            self.assertEqual((events["maps/slip"], events["mesh/x"]), (("onset", "cell"), ("cell",)))
            if mesh == "triangles":
                self.assertEqual((of["mesh/triangles"], of["mesh/vertices"]),
                                 (("cell", "component"), ("vertex", "component")))
                self.assertEqual(events["fault_moment"], ("onset", "fault_index"))
                self.columns("events.h5", 2)
            if XARRAY:
                self.assertEqual(self.opened("run.h5", "fields").slip.dims, ("time", "cell"))

    @unittest.skipUnless(shutil.which("ncdump"), "ncdump is not installed (Debian's package is netcdf-bin)")
    def test_ncdump(self):
        self.fault(*GRID[:10])
        text = subprocess.run(["ncdump", "-h", self.path("run.h5")], capture_output=True, text=True, check=True).stdout
        self.assertIn("double slip(time, z, x) ;", text)
        self.assertNotIn("phony", text)


if __name__ == "__main__":
    unittest.main()
