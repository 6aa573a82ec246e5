#!/usr/bin/env python3
"""Tutorials: their commands run in their order in an empty folder, and print the lines that the page shows, with
numbers to 1 %; other processors and versions of PETSc round otherwise, which decides ties between steps. Blocks of C,
Python and options are saved under the name that stands behind their language. "sh skip": what another test runs; "text
varies": sequences of events, whose numbers depend on rounding."""

import glob
import os
import re
import subprocess
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

from scripts import BUILD, SOURCE

NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


def blocks(path):
    with open(path, encoding="utf-8") as file:
        return re.findall(r"(?ms)^```(\w+)(?: (\S+))?\n(.*?)^```$", file.read())


def close(shown, printed, varies):
    """Two lines with the same words and, unless they vary, numbers to 1 %."""
    if NUMBER.sub("#", shown).split() != NUMBER.sub("#", printed).split():
        return False
    if varies:
        return True
    pairs = zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(printed)))
    return all(abs(a - b) <= 0.01 * abs(a) + 1e-12 or (a == round(a) and abs(a - b) <= 1) for a, b in pairs)


def run(page):
    """What is wrong, a line each."""
    wrong, printed = [], ""
    with tempfile.TemporaryDirectory() as folder:
        for name in ("examples", "training", "src", "CMakeLists.txt"):
            os.symlink(os.path.join(SOURCE, name), os.path.join(folder, name))
        os.symlink(BUILD, os.path.join(folder, "build"))
        os.mkdir(os.path.join(folder, "output"))
        bin = os.path.join(folder, "bin")
        os.mkdir(bin)
        os.symlink(os.environ.get("SLIPSTEP_PYTHON", "/usr/bin/python3"), os.path.join(bin, "python3"))
        environment = dict(os.environ, PATH=bin + os.pathsep + os.environ["PATH"])
        before = None
        for language, word, text in blocks(page):
            if language == "sh" and word != "skip":
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=folder, env=environment,
                                      capture_output=True, text=True)
                printed = done.stdout + done.stderr
                if done.returncode:
                    wrong.append(f"{text}\nends with {done.returncode}: {printed[-1500:]}")
                    break
            elif language == "text" and before != "sh skip":
                wrong += [f"not printed: {line}; there is "
                          f"{[other for other in printed.splitlines() if other[:8] == line[:8]]}" for line
                          in text.splitlines() if line.strip() and not any(close(line, other, word == "varies")
                                                                           for other in printed.splitlines())]
            elif language in ("c", "python", "opts") and word:
                with open(os.path.join(folder, word), "w", encoding="utf-8") as file:
                    file.write(text)
            before = f"{language} {word}".strip()
    return [f"{os.path.basename(page)}: {line}" for line in wrong]


class Tutorials(unittest.TestCase):
    maxDiff = None

    def test_all(self):
        pages = sorted(glob.glob(os.path.join(SOURCE, "examples", "tutorials", "*.md")))
        self.assertEqual(len(pages), 7)
        with ThreadPoolExecutor(2) as pool:
            self.assertEqual([line for found in pool.map(run, pages) for line in found], [])


if __name__ == "__main__":
    unittest.main()
