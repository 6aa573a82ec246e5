#!/usr/bin/env python3
"""The site: it is built without a warning, its links and pictures are there, each option has one row, and code blocks
of pages parse and name what exists."""

import glob
import html
import importlib.util
import os
import re
import subprocess
import sys
import tempfile
import unittest

from scripts import BUILD, SOURCE

LACKING = [package for module, package in (("sphinx", "python3-sphinx"), ("myst_parser", "python3-myst-parser"),
                                           ("sphinx_rtd_theme", "python3-sphinx-rtd-theme"))
           if not importlib.util.find_spec(module)]


class Site(unittest.TestCase):
    @unittest.skipIf(LACKING, f"packages are not installed: {' '.join(LACKING)}")
    def test_built(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, os.path.join(SOURCE, "src", "site", "build.py"), "--build", BUILD,
                                   "--output", folder], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            root = os.path.join(folder, "html")
            pages = {path: self.read(path) for path in glob.glob(os.path.join(root, "**", "*.html"), recursive=True)}
            self.assertGreater(len(pages), 50)
            ids = {path: set(re.findall(r'\bid="([^"]+)"', text)) for path, text in pages.items()}
            missing = []
            for path, text in pages.items():
                for link in re.findall(r'(?:href|src)="([^"]+)"', text):
                    link = html.unescape(link)
                    if re.match(r"\w+:|//", link):
                        continue
                    target, _, part = link.split("?")[0].partition("#")
                    full = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
                    if (not os.path.exists(full) or part and full in ids and part not in ids[full]
                        and os.path.basename(path) not in ("search.html", "genindex.html")):
                        missing.append(f"{os.path.relpath(path, root)}: {link}")
            self.assertEqual(sorted(set(missing)), [])
            outside = {link for text in pages.values()
                       for link in re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="(https?:[^"]+)"', text)}
            self.assertEqual(outside, set(), "the site needs the network")
            features = self.read(os.path.join(folder, "source", "reference", "features.md"))
            self.assertRegex(features, r"(?m)^\| -fault\\_opening yes \| only with \| -fault\\_slip\\_components 2 \|")
            options = self.read(os.path.join(folder, "source", "reference", "options.md"))
            rows = re.findall(r"(?m)^\| `(-\w+)` \|", options)
            self.assertEqual(sorted(rows), sorted(set(rows)))
            self.assertTrue({"-fault_nx", "-ts_bathe_error", "-train_output", "-evaluate_quick",
                             "-circuit_output"} <= set(rows), rows)

    @staticmethod
    def read(path):
        with open(path, encoding="utf-8") as file:
            return file.read()

    def test_code_blocks(self):
        """Those of the shell are its language, and scripts and programs that they call are there."""
        wrong = []
        pages = [path for path in glob.glob(os.path.join(SOURCE, "**", "*.md"), recursive=True)
                 if not os.path.relpath(path, SOURCE).startswith("build")]
        for path in pages:
            for block in re.findall(r"(?ms)^ *```sh\n(.*?)^ *```", self.read(path)):
                where = os.path.relpath(path, SOURCE)
                if subprocess.run(["bash", "-n"], input=block, capture_output=True, text=True).returncode:
                    wrong.append(f"{where}: not of the shell: {block[:60]}")
                for word in re.findall(
                    r"(?<![\w/.~-])((?:examples|output|training|tests|src)/[\w./-]+\.(?:py|sh|opts)|build/bin/\w+)",
                    block):
                    full = os.path.join(BUILD, word[6:]) if word.startswith("build/") else os.path.join(SOURCE, word)
                    if not os.path.exists(full):
                        wrong.append(f"{where}: {word}")
        self.assertEqual(sorted(set(wrong)), [])


if __name__ == "__main__":
    unittest.main()
