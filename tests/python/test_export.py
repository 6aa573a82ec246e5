#!/usr/bin/env python3
"""What a catalogue and a run give to others: QuakeML, the columns of CSEP, a moment-rate function, a report."""

import csv
import datetime
import os
import re
import unittest
import xml.etree.ElementTree as ElementTree
from unittest import mock

from scripts import FaultTest, PictureTest

import h5py
import numpy as np
from slipstep.times import written

BED = "{http://quakeml.org/xmlns/bed/1.2}"
SCHEMA = os.environ.get("SLIPSTEP_QUAKEML_SCHEMA", "")  # QuakeML-1.2.xsd or .rng, which is not ours to copy
RUN = ("-fault_nx", 6, "-fault_nz", 4, "-fault_strike", 90, "-fault_dip", 60, "-fault_output", "run.h5",
       "-fault_catalogue", "events.h5", "-fault_catalogue_maps",
       "-fault_friction_slip", 0.01, "-fault_density", 99, "-fault_output_fields", "slip,slip_rate")


class Export(FaultTest, PictureTest):
    def setUp(self):
        super().setUp()
        self.said = self.fault(*RUN)
        with h5py.File(self.path("events.h5")) as file:
            self.event = {name: data[()] for name, data in file.items() if isinstance(data, h5py.Dataset)}

    def test_quakeml_and_csep(self):
        """The hypocentre in both: north and east of the origin by degrees of a sphere of 6371 km."""
        self.plot("catalogue_quakeml", self.path("events.h5"), self.path("events.xml"), "--origin", "10", "60",
                  "--start", "1999-12-31T23:00:00")
        root = ElementTree.parse(self.path("events.xml")).getroot()
        self.assertEqual(root.tag, "{http://quakeml.org/xmlns/quakeml/1.2}quakeml")
        ids = [element.get("publicID") for element in root.iter() if element.get("publicID")]
        self.assertEqual(len(ids), len(set(ids)))
        for name in ids:
            self.assertRegex(name, r"^(smi|quakeml):[\w\d][\w\d\-\.\*\(\)_~']{2,}/"
                             r"[\w\d\-\.\*\(\)_~'][\w\d\-\.\*\(\)\+\?_~'=,;#/&]*$")
        events = root.findall(f"{BED}eventParameters/{BED}event")
        self.assertEqual(len(events), len(self.event["onset"]))

        def number(path):
            return float(events[0].find("/".join(BED + tag for tag in (*path.split("/"), "value"))).text)

        self.assertAlmostEqual(number("origin/latitude"), 60 + np.degrees(self.event["x"][0] / 6371e3), delta=1e-9)
        self.assertAlmostEqual(number("origin/longitude"), 10 + np.degrees(self.event["y"][0] / 6371e3) / 0.5,
                               delta=1e-9)
        self.assertAlmostEqual(number("origin/depth"), self.event["z"][0], delta=1e-6)
        self.assertEqual(number("magnitude/mag"), self.event["magnitude"][0])
        self.assertEqual(number("focalMechanism/momentTensor/scalarMoment"), self.event["moment"][0])
        self.assertEqual([number(f"focalMechanism/nodalPlanes/nodalPlane1/{angle}")
                          for angle in ("strike", "dip", "rake")], [90, 60, self.event["rake"][0]])
        when = events[0].find(f"{BED}origin/{BED}time/{BED}value").text
        self.assertAlmostEqual((datetime.datetime.fromisoformat(when[:-1])
                                - datetime.datetime(1999, 12, 31, 23)).total_seconds(), self.event["onset"][0],
                               delta=1e-6)
        for element in root.iter(f"{BED}preferredOriginID"):
            self.assertIn(element.text, ids)
        if SCHEMA:
            from lxml import etree
            schema = (etree.RelaxNG if SCHEMA.endswith(".rng") else etree.XMLSchema)(etree.parse(SCHEMA))
            self.assertTrue(schema.validate(etree.parse(self.path("events.xml"))), schema.error_log)
        self.plot("catalogue_csv", self.path("events.h5"), self.path("events.csv"), "--csep", "--origin", "10", "60")
        with open(self.path("events.csv"), encoding="utf-8") as file:
            row = next(csv.DictReader(file))
        self.assertEqual(list(row), ["lon", "lat", "M", "time_string", "depth", "catalog_id", "event_id"])
        self.assertAlmostEqual(float(row["lat"]), number("origin/latitude"), delta=1e-6)
        self.assertAlmostEqual(float(row["depth"]), self.event["z"][0] / 1e3, delta=1e-4)
        datetime.datetime.strptime(row["time_string"], "%Y-%m-%dT%H:%M:%S.%f")
        self.refused("catalogue_quakeml", "--origin is missing", self.path("events.h5"), self.path("no.xml"), code=2)
        self.refused("catalogue_quakeml", "years after --start", self.path("events.h5"), self.path("no.xml"),
                     "--origin", "0", "0", "--start", "9999-12-31T23:59:59.999999")
        self.assertFalse(os.path.exists(self.path("no.xml")))

    def test_false_origin(self):
        """A mesh in coordinates of a map projection: the point of --origin is asked for, and then its events are
        there."""
        self.hdf5("utm.h5", units={"cells": "m"},
                  cells=[[3.9e6 + 500 * (k % 6 + 0.5), 4e5, 750 * (k // 6 + 0.5), 500, 750] for k in range(24)])
        self.fault("-fault_mesh", "utm.h5", "-fault_friction_slip", 0.01, "-fault_catalogue", "utm_events.h5")
        north, east = self.get("utm_events.h5", "x")[0] - 3.9e6, self.get("utm_events.h5", "y")[0] - 4e5
        for module, target, more in (("catalogue_quakeml", "utm.xml", ()), ("catalogue_csv", "utm.csv", ("--csep",))):
            self.refused(module, "the mesh is 3922 km from x = y = 0, .* near 3901500 400000, as --origin-at "
                         "NORTH EAST", self.path("utm_events.h5"), self.path(target), *more,
                         "--origin", "13.9", "35.24")
            self.refused(module, "the mesh is 4951 km from the point of --origin, --origin-at 400000 3900000: .* near "
                         "3901500 400000", self.path("utm_events.h5"), self.path(target), *more,
                         "--origin", "13.9", "35.24", "--origin-at", "400000", "3900000")  # east before north
            self.assertFalse(os.path.exists(self.path(target)))
            self.plot(module, self.path("utm_events.h5"), self.path(target), *more, "--origin", "13.9", "35.24",
                      "--origin-at", "3900000", "400000")
        with open(self.path("utm.csv"), encoding="utf-8") as file:
            row = next(csv.DictReader(file))
        self.assertAlmostEqual(float(row["lat"]), 35.24 + np.degrees(north / 6371e3), delta=1e-6)
        self.assertAlmostEqual(float(row["lon"]), 13.9 + np.degrees(east / 6371e3) / np.cos(np.radians(35.24)),
                               delta=1e-6)

    def test_moment_rate(self):
        """The moment is the event's, to what a straight line of the logarithm of rates leaves in the steps of its ends.
        Trapezoids of the rates over n steps of a pulse of half a sine are off by pi^2/(12 n^2), 0.2 % for the twenty of
        an event; steps differ in length by some three times, which lets the longest weigh ten times as much: 2 %."""
        out = self.plot("moment_rate", self.path("run.h5"), "--catalogue", self.path("events.h5"))
        self.look(self.path("run_moment_rate.png"))
        with open(self.path("run_moment_rate.csv"), encoding="utf-8") as file:
            rows = np.array([[float(value) for value in row.values()] for row in csv.DictReader(file)])
        largest = np.argmax(self.event["moment"])
        self.assertAlmostEqual(np.trapz(rows[:, 1], rows[:, 0]) / self.event["moment"][largest] if hasattr(np, "trapz")
                               else np.trapezoid(rows[:, 1], rows[:, 0]) / self.event["moment"][largest], 1, delta=0.02)
        self.assertAlmostEqual(rows[-1, 2] / self.event["moment"][largest], 1, delta=1e-3)
        self.assertAlmostEqual(rows[-1, 0], self.event["end"][largest] - self.event["onset"][largest], delta=1e-9)
        self.assertAlmostEqual(float(re.search(r"M ([\d.]+)", out)[1]), self.event["magnitude"][largest], delta=0.02)

    def test_report(self):
        """One file that asks for no other, with the options, the warning of the run and its pictures."""
        self.assertIn("warning", self.said)  # the density is that of no rock
        self.plot("report", self.path("run.h5"), "--catalogue", self.path("events.h5"), "-o", self.path("r.html"))
        text = self.content("r.html")
        self.assertEqual(re.findall(r"(?:src|href)=\"(?!data:image/png;base64,)", text), [])
        self.assertLess(len(text), 2e6)
        self.assertGreaterEqual(text.count("<img"), 4)
        warning = re.search(r"warning: (.*)", self.said)[1]
        for part in ("-fault_friction_slip", "<code>0.01</code>", warning[:60], "final mean slip"):
            self.assertIn(part, text)
        with h5py.File(self.path("run.h5")) as file:
            self.assertIn(f"{file['result'].attrs['accepted']}", text)
            self.assertIn(warning, np.bytes_(file["run"].attrs["warnings"]).decode())
        self.assertNotIn("goes on at the end", text)
        with h5py.File(self.path("events.h5"), "r+") as file:
            file["goes_on"][-1] = 1
            since, magnitude = file["onset"][-1], file["magnitude"][-1]
        with mock.patch("slipstep.programs.report.pictures", lambda run, events: []):
            self.plot("report", self.path("run.h5"), "--catalogue", self.path("events.h5"), "-o", self.path("r.html"))
        self.assertIn(f"The last event goes on at the end of the run: M {magnitude:.2f} so far, since "
                      f"{written(since)}", self.content("r.html"))


if __name__ == "__main__":
    unittest.main()
