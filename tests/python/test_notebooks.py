#!/usr/bin/env python3
"""The notebooks of examples/ run from end to end, in this process's kernel of Python; BP5's interval is that of the
published numbers."""

import importlib.util
import os
import re
import unittest
from concurrent.futures import ThreadPoolExecutor

from scripts import SOURCE
from test_from_python import environment

FOLDER = os.path.join(SOURCE, "examples", "notebooks")
NEEDED = {"nbclient": "python3-nbconvert", "ipykernel": "python3-ipykernel", "xarray": "python3-xarray",
          "pandas": "python3-pandas"}
LACKING = [package for module, package in NEEDED.items() if not importlib.util.find_spec(module)]


def execute(name):
    """Texts and kinds of the outputs."""
    import nbformat
    from nbclient import NotebookClient
    book = nbformat.read(os.path.join(FOLDER, name), 4)
    NotebookClient(book, timeout=900, kernel_name="python3", resources={"metadata": {"path": FOLDER}}).execute(
        env={**environment(), "SLIPSTEP_FAULT": os.path.join(
os.environ["SLIPSTEP_BUILD"], "bin", "fault"), "MPLBACKEND": "module://matplotlib_inline.backend_inline"})
    outputs = [output for cell in book.cells for output in cell.get("outputs", ())]
    text = "\n".join(output.get("text", "") + str(output.get("data", {}).get("text/plain", "")) for output in outputs)
    return text, [kind for output in outputs for kind
                  in output.get("data", {})], "".join(output.get("data", {}).get("text/html", "") for output in outputs)


@unittest.skipIf(LACKING, f"packages are not installed: {' '.join(LACKING)}")
class Notebooks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        names = sorted(name for name in os.listdir(FOLDER) if name.endswith(".ipynb"))
        with ThreadPoolExecutor(2) as pool:
            cls.found = dict(zip(names, pool.map(execute, names)))

    def test_they_have_pictures(self):
        self.assertEqual(len(self.found), 3)
        for name, (_, kinds, _) in self.found.items():
            self.assertIn("image/png", kinds, name)

    def test_film(self):
        self.assertIn("animation", self.found["first_rupture.ipynb"][2].lower())

    def test_century(self):
        """What was released is what was loaded, but for what is stored at the ends: at most a largest event, which
        slips by 0.9 m of the 4.7 m that 150 years load, a fifth."""
        released, loaded = map(float, re.search(r"released (\S+) N m, loaded (\S+) N m",
                                                self.found["century.ipynb"][0]).groups())
        self.assertAlmostEqual(released / loaded, 1, delta=0.2)

    def test_benchmark(self):
        """235.57 years by examples/seas_bp5.sh with the same cells and steps, so that only rounding differs; twice the
        cells give 235.81 and other codes 234.3, so that 0.2 years tell them apart."""
        self.assertAlmostEqual(float(re.search(r"first interval ([\d.]+) years", self.found["benchmark.ipynb"][0])[1]),
                               235.57, delta=0.2)

    def test_no_output_is_stored(self):
        """Outputs would be of another version."""
        import nbformat
        for name in self.found:
            for cell in nbformat.read(os.path.join(FOLDER, name), 4).cells:
                self.assertFalse(cell.get("outputs"), name)


if __name__ == "__main__":
    unittest.main()
