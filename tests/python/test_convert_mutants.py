#!/usr/bin/env python3
"""Damaged files of other programs: each is read, or refused by one line, and what is read has cells that are cells.
MUTANTS=1500 tries more of each kind."""

import json
import os
import random
import unittest
import warnings

from test_convert_sources import COULOMB, SourcesTest, at, param_text, srf_text
import h5py
import numpy as np

from slipstep.errors import Error
from slipstep.formats import said
from slipstep.formats.readers import READERS
from test_convert_faults import DFN, HBI, INTERACT, MSH, PARAMS, PYQUAKE
from test_convert_fsp import double, single
from test_convert_maps import feature

COUNT = int(os.environ.get("MUTANTS", 60))
WORDS = ("0", "-1", "1e308", "nan", "inf", "x", "999", "-99", "1e-300", "")
LETTERS = "0123456789.-eE xnan%#\n"


def mutant(text, chance):
    """The text cut, or with a letter, word, line or piece changed."""
    lines, way = text.splitlines(True), chance.randrange(7)
    i, j = (chance.randrange(len(lines)) for _ in range(2))
    at = chance.randrange(len(text))
    if way == 0:
        return text[:at]
    if way == 1:
        return text[:at] + chance.choice(LETTERS) + text[at + 1:]
    if way == 2:
        return "".join(lines[:i] + lines[i + 1:])
    if way == 3:
        return "".join(lines[:i + 1] + lines[i:])
    if way == 4 and lines[i].split():
        words = lines[i].split()
        words[chance.randrange(len(words))] = chance.choice(WORDS)
        return "".join(lines[:i] + [" ".join(words) + "\n"] + lines[i + 1:])
    if way == 5:
        lines[i], lines[j] = lines[j], lines[i]
        return "".join(lines)
    return text[:at] + text[at + chance.randrange(40):]


def column(text, name, value, head, rows):
    """The text with a further column: the first line that has the words of the head gets a name, lines after it that
    begin with so many numbers a value."""
    lines, found = [], False
    for line in text.splitlines():
        numbers = sum(word.replace(".", "").replace("-", "").replace("+", "").replace("e", "").isdigit()
                      for word in line.split()[:rows])
        named = not found and head in line
        lines.append(f"{line} {name}" if named else f"{line} {value}" if found and numbers == rows else line)
        found |= named
    return "\n".join(lines) + "\n"


class Mutants(SourcesTest):
    def whole(self):
        """Files of each kind, and those beside them."""
        self.put("params.dat", PARAMS)
        self.put("rows.dat", "".join(f"{30 + k} 0.01 0.02 0.1 0.6 {12 + k} 25 1e-9 0 0\n" for k in range(2)))
        self.put("fault.msh", MSH)
        return {"fsp": (single()[0], double()[0]), "param": (param_text()[0],),
                "srf": (srf_text()[0], srf_text("1.0", False)[0]), "interact": (INTERACT,), "quake-dfn": (DFN,),
                 "coulomb": (COULOMB.format(names="rt.lat reverse", one="0.0 0.8", two="1.5 0.0"),),
                "hbi": (HBI.replace("examples/", ""),), "pyquake3d": (PYQUAKE.replace("params", "rows"),),
                "traces": (json.dumps({"type": "FeatureCollection",
                                       "features": [feature([[0, 0, 0], [5e3, 2e3, 0]], dip=60, upper_depth=1,
                                                            lower_depth=9, rake=90, name="one")]}, indent=1),),
                "depths": ("".join(f"{-70 + i / 10} {-23 + j / 10} {-10 - i}\n" for i in range(4) for j in range(3)),),
                "mesh": (MSH,)}

    def read(self, kind, path):
        return READERS[kind][1](path, at, None, **({"unit": "m"} if kind == "interact" else {"unit": "km"}
                                                   if kind == "mesh" and not h5py.is_hdf5(path) else {}))

    def test_what_no_reader_knows(self):
        """A key and a column that no reader can know are named among what it has not used, and change nothing else."""
        whole = {kind: texts[0] for kind, texts in self.whole().items()}
        more = {"fsp": ((whole["fsp"].replace("% Invs :  Nx ", "% Zork :  Quux = 12.5 km\n% Invs :  Nx "),
                         "key.* Quux"),
                        (column(whole["fsp"], "QUUX", 7, "LAT      LON", 8), "column.* QUUX")),
                "param": ((whole["param"].replace("#Lon.  Lat.", "#Quux = 12.5\n#Lon.  Lat."), '"#Quux = 12.5"'),
                          (column(whole["param"], "Quux", 7, "t_rup", 11), "column Quux"),
                          (column(whole["param"], "", 7, "t_rup", 11), "1 column after the first 11")),
                "srf": ((whole["srf"].replace("2.0\n", "2.0\n# Quux= 12.5\n", 1), "2 lines of comments"),
                        (whole["srf"].replace(" 12.0 9.0\n", " 12.0 9.0 12.5\n"),
                         "more numbers than the format has in 1 lines"),
                        (whole["srf"].replace(" 9.0e+10 0.0000 0.05 3.00000e+05 2.70000e+00", " 9.0e+10 0.0000 0.05 0 "
                                              "2.70000e+00"),
                         "S velocities and densities, which 1 of 12 points do not have")),
                "interact": ((column("#\n" + whole["interact"], "", 7, "#", 8), "1 column after the first 8"),),
                "quake-dfn": ((column(whole["quake-dfn"], "Quux", 7, "Ctr_X", 18), "column quux"),
                              (whole["quake-dfn"].replace("2.0e6\n", "2.0e6\t7\n"), "1 column after the first 7")),
                "coulomb": ((whole["coulomb"].replace("FRIC=", "QUUX=  12.5\nFRIC="), "keys .*QUUX"),),
                "hbi": ((whole["hbi"] + "quux 12.5\n", "key.* quux"), (whole["hbi"] + "quux\n", "key.* quux")),
                "traces": ((whole["traces"].replace('"name"', '"quux": 12.5, "name"'), "property quux"),),
                "depths": ((column("#\n" + whole["depths"], "", 7, "#", 3), "1 column after the first 3"),),
                "mesh": (),
                "pyquake3d": ((whole["pyquake3d"] + "Quux: 12.5\n", "key Quux"),
                              (whole["pyquake3d"] + "Quux\n", "key Quux")),}
        self.assertEqual(set(more), set(READERS))
        self.hdf5("mesh.h5", units={"cells": "m"}, cells=np.array([[0, 0, 1e3, 2e3, 1e3]]), quux=7.0)
        self.assertEqual(self.read("mesh", self.path("mesh.h5")).dropped, ["dataset quux"])
        for kind, cases in more.items():
            if not cases:
                continue
            plain = self.read(kind, self.put("plain.txt", whole[kind]))
            for text, said in cases:
                with self.subTest(kind=kind, said=said):
                    model = self.read(kind, self.put("more.txt", text))
                    self.assertRegex("\n".join(model.dropped), said)
                    self.assertNotRegex("\n".join(plain.dropped), said)
                    np.testing.assert_array_equal(model.cells, plain.cells)
        self.put("params.dat", column(PARAMS, "quux", 0, "dc", 3))
        self.assertIn("column quux", self.read("hbi", self.put("plain.txt", whole["hbi"])).dropped)
        self.put("params.dat", column(PARAMS, "", 7, "dc", 3))
        self.assertIn("1 column after the first 3", self.read("hbi", self.path("plain.txt")).dropped)
        self.put("params.dat", PARAMS + "1 2 3\n")
        with self.assertRaisesRegex(Error, "params.dat, line 14: 13 rows"):
            self.read("hbi", self.path("plain.txt"))
        self.put("rows.dat", "".join(f"{30 + k} 0.01 0.02 0.1 0.6 {12 + k} 25 1e-9 0 0 7\n" for k in range(2)))
        self.assertIn("1 column after the first 10",
                      self.read("pyquake3d", self.put("plain.txt", whole["pyquake3d"])).dropped)

    def test_all(self):
        whole = self.whole()
        self.assertEqual(set(whole), set(READERS))
        for kind, texts in whole.items():
            chance, read = random.Random(5), 0
            for number in range(COUNT):
                text = mutant(chance.choice(texts), chance)
                with self.subTest(kind=kind, number=number), warnings.catch_warnings():
                    warnings.simplefilter("error")
                    path = self.put("mutant" + (".txt" if kind != "mesh" else ".msh"), text)
                    try:
                        model = self.read(kind, path)
                        list(said.lines(model))
                    except Error as error:
                        self.assertNotIn("\n", str(error))
                        continue
                    read += 1
                    self.assertTrue(np.isfinite(model.cells).all() and (model.area > 0).all())
            self.assertTrue(0 < read < COUNT, kind)


if __name__ == "__main__":
    unittest.main(verbosity=2)
