#!/usr/bin/env python3
"""The version of include/slipsys.h is that of the build, of CITATION.cff and of the latest section of CHANGELOG.md,
whose dates agree."""
import os
import re
import unittest

from scripts import BUILD, SOURCE



def read(*path):
    with open(os.path.join(*path), encoding="utf-8") as f:
        return f.read()


class Version(unittest.TestCase):
    def setUp(self):
        header = read(SOURCE, "include", "slipsys.h")
        self.version = ".".join(re.search(rf"#define SLIPSTEP_VERSION_{part} (\d+)", header)[1]
                                for part in ("MAJOR", "MINOR", "PATCH"))

    def test_the_build(self):
        self.assertEqual(re.search(r"^Version: (.*)$", read(BUILD, "slipstep.pc"), re.M)[1], self.version)
        self.assertTrue(os.path.exists(os.path.join(BUILD, "lib", f"libslipstep.so.{self.version}")))

    def test_citation_and_changelog(self):
        citation = read(SOURCE, "CITATION.cff")
        released = re.search(r"^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)$", read(SOURCE, "CHANGELOG.md"), re.M)
        self.assertEqual(released[1], self.version)
        self.assertEqual(re.search(r"^version: (.*)$", citation, re.M)[1], self.version)
        self.assertEqual(re.search(r"^date-released: (.*)$", citation, re.M)[1], released[2])

    def test_nothing_else_names_a_version(self):
        """CMake takes it from the header."""
        self.assertIn("project(slipstep VERSION ${", read(SOURCE, "CMakeLists.txt"))


if __name__ == "__main__":
    unittest.main()
