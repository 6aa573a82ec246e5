#!/usr/bin/env python3
"""Damaged files of other programs: each is read, or refused by one line, and what is read has cells that are cells. MUTANTS=1500 tries more of each kind."""

import os
import random
import unittest
import warnings

from test_convert_sources import COULOMB, SourcesTest, at, param_text, srf_text
import numpy as np

from slipstep.errors import Error
from slipstep.formats import said
from slipstep.formats.readers import READERS
from test_convert_faults import DFN, HBI, INTERACT, MSH, PARAMS, PYQUAKE
from test_convert_fsp import double, single

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


class Mutants(SourcesTest):
    def test_all(self):
        self.put("params.dat", PARAMS)
        self.put("rows.dat", "".join(f"{30 + k} 0.01 0.02 0.1 0.6 {12 + k} 25 1e-9 0 0\n" for k in range(2)))
        self.put("fault.msh", MSH)
        whole = {"fsp": (single()[0], double()[0]), "param": (param_text()[0],), "srf": (srf_text()[0], srf_text("1.0", False)[0]), "interact": (INTERACT,), "quake-dfn": (DFN,),
                 "coulomb": (COULOMB.format(names="rt.lat reverse", one="0.0 0.8", two="1.5 0.0"),), "hbi": (HBI.replace("examples/", ""),), "pyquake3d": (PYQUAKE.replace("params", "rows"),)}
        self.assertEqual(set(whole), set(READERS))
        for kind, texts in whole.items():
            chance, read = random.Random(5), 0
            for number in range(COUNT):
                text = mutant(chance.choice(texts), chance)
                with self.subTest(kind=kind, number=number), warnings.catch_warnings():
                    warnings.simplefilter("error")
                    path = self.put("mutant.txt", text)
                    try:
                        model = READERS[kind][1](path, at, None, **({"unit": "m"} if kind == "interact" else {}))
                        list(said.lines(model))
                    except Error as error:
                        self.assertNotIn("\n", str(error))
                        continue
                    read += 1
                    self.assertTrue(np.isfinite(model.cells).all() and (model.area > 0).all())
            self.assertTrue(0 < read < COUNT, kind)


if __name__ == "__main__":
    unittest.main(verbosity=2)
