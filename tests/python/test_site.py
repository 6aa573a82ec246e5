#!/usr/bin/env python3
"""The site: it is built without a warning, its links and pictures are there, each option has one row, and code blocks
of pages parse and name what exists. A browser, where one is installed, opens it and the report of a run as a phone
does."""

import glob
import html
import importlib.util
import os
import re
import subprocess
import sys
import tempfile
import unittest

from browser import BROWSER, complaints
from scripts import BUILD, SOURCE, FaultTest

LACKING = [package for module, package in (("sphinx", "python3-sphinx"), ("myst_parser", "python3-myst-parser"),
                                           ("sphinx_rtd_theme", "python3-sphinx-rtd-theme"))
           if not importlib.util.find_spec(module)]


@unittest.skipIf(LACKING, f"packages are not installed: {' '.join(LACKING)}")
class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        done = subprocess.run([sys.executable, os.path.join(SOURCE, "src", "site", "build.py"), "--build", BUILD,
                               "--output", cls.folder.name], capture_output=True, text=True)
        if done.returncode:
            raise AssertionError(done.stdout + done.stderr)

    def test_built(self):
        root = os.path.join(self.folder.name, "html")
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
        features = self.read(os.path.join(self.folder.name, "source", "reference", "features.md"))
        self.assertRegex(features, r"(?m)^\| -fault\\_opening yes \| only with \| -fault\\_slip\\_components 2 \|")
        options = self.read(os.path.join(self.folder.name, "source", "reference", "options.md"))
        rows = re.findall(r"(?m)^\| `(-\w+)` \|", options)
        self.assertEqual(sorted(rows), sorted(set(rows)))
        self.assertTrue({"-fault_nx", "-ts_bathe_error", "-train_output", "-evaluate_quick",
                         "-circuit_output"} <= set(rows), rows)

    @unittest.skipUnless(BROWSER, "no browser is installed (Debian's chromium)")
    def test_on_a_phone(self):
        root = os.path.join(self.folder.name, "html")
        pages = sorted(os.path.relpath(path, root)
                       for path in glob.glob(os.path.join(root, "**", "*.html"), recursive=True))
        self.assertEqual(complaints(root, pages), [])

    def test_how_to_has_groups(self):
        """Each page of the how-to is in a section of its index."""
        index = self.read(os.path.join(self.folder.name, "source", "howto", "index.md"))
        trees = re.findall(r"(?ms)^## ([^\n]+)\n(?:(?!^## ).)*?^```\{toctree\}\n:hidden:\n\n(.*?)^```", index)
        self.assertEqual([title for title, _ in trees],
                         ["Start", "Faults and meshes", "Physics", "Running", "Results", "Own code", "Policies"])
        entries = [entry for _, tree in trees for entry in tree.split()]
        pages = glob.glob(os.path.join(self.folder.name, "source", "howto", "*.md"))
        names = {os.path.basename(page)[:-len(".md")] for page in pages} - {"index"}
        self.assertEqual(sorted(entries), sorted("/howto/" + name for name in names))

    @staticmethod
    def read(path):
        with open(path, encoding="utf-8") as file:
            return file.read()


class Pages(unittest.TestCase):
    def test_code_blocks(self):
        """Those of the shell are its language, and scripts and programs that they call are there."""
        wrong = []
        pages = [path for path in glob.glob(os.path.join(SOURCE, "**", "*.md"), recursive=True)
                 if not os.path.relpath(path, SOURCE).startswith("build")]
        for path in pages:
            for block in re.findall(r"(?ms)^ *```sh\n(.*?)^ *```", Site.read(path)):
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


@unittest.skipUnless(BROWSER, "no browser is installed (Debian's chromium)")
class Browser(FaultTest):
    def test_what_is_wrong_is_found(self):
        pages = {"good.html": '<a href="bad.html">there</a>',
                 "bad.html": '<img src="none.png"><a href="none.html">gone</a><div style="width: 700px">wide</div>'
                             '<script>console.log("said")</script>'}
        for name, text in pages.items():
            self.put(name, "<!doctype html><title>page</title><body>" + text)
        self.assertEqual(complaints(self.folder.name, ["good.html"]), [])
        found = "\n".join(complaints(self.folder.name, ["bad.html"]))
        for word in ("no picture none.png", "broken link /none.html", "wider than 400 pixels: DIV", 'console: "said"'):
            self.assertIn(word, found)

    def test_report_on_a_phone(self):
        self.fault("-fault_nx", 8, "-fault_nz", 8, "-fault_output", "run.h5", "-fault_catalogue", "events.h5")
        done = subprocess.run([sys.executable, os.path.join(BUILD, "bin", "slipstep"), "report", "run.h5",
                               "--catalogue", "events.h5", "-o", "report.html"],
                              cwd=self.folder.name, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(complaints(self.folder.name, ["report.html"]), [])


if __name__ == "__main__":
    unittest.main()
