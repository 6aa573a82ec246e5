#!/usr/bin/env python3
"""The lists of options by which programs tell a known name from a mistyped one hold what the sources read, no less and
no more."""
import glob
import os
import re
import subprocess
import unittest

from scripts import BUILD, SOURCE, ScriptTest

OURS = ("slip", "fault", "ts_adams", "ts_rkc", "ts_bathe", "ts_adapt_heuristic", "ts_adapt_pi", "ts_adapt_rl",
        "snes_slip", "mat_slip", "pc_slipstage", "circuit",
        "sliding_mode", "oscillator", "elastic", "train", "evaluate")
TEXT = r'((?:"[^"]*"\s*)+)'


def text(match):
    return "".join(re.findall(r'"([^"]*)"', match))


def declared(code):
    """Full names that the sources declare"""
    found = set()
    table = re.search(r"SlipLibrary\[\] = \{(.*?)\n\};", code["src/sys/optionnames.c"], re.S)[1]
    pairs = [(prefix, text(names)) for prefix, names in re.findall(r'\{"(\w+)",\s*' + TEXT + r"\}", table)]
    for path, content in code.items():
        pairs += [(prefix, text(names)) for prefix, names in re.findall(r'SlipDeclareOptions\("(\w+)",\s*' + TEXT,
                                                                        content)]
        if re.search(r'SlipDeclareOptions\("\w+", names\)', content) and path.startswith("training"):
            prefix = re.search(r'SlipDeclareOptions\("(\w+)", names\)', content)[1]
            pairs.append((prefix, text(re.search(r"char names\[\] =\s*" + TEXT, content)[1])))
        pairs += [(m[1], m[2]) for m in re.finditer(r'Program program = \{\s*"\w+",\s*help,\s*"(\w+)",\s*"([^"]*)"',
                                                    content)]
    names = re.search(r"PetscStrncpy\(\s*names,\s*" + TEXT, code["src/fault/setup/faultnames.c"])[1]
    pairs.append(("fault_", text(names)))
    pairs.append(("fault_", " ".join(fault_table(code))))
    numbers = re.findall(r'\{"-(\w+)"', code["src/sys/solveroptions.c"])
    found |= {name for name in numbers if any(name.startswith(prefix) for prefix in re.findall(r'\{"(\w+)",', table))}
    for prefix, names in pairs:
        found |= {prefix + name for name in names.split()}
    return found


def fault_table(code):
    # numbers, choices; switches; rows that a header has
    rows = "".join(code[name] for name in ("src/fault/setup/parameters.c", "src/fault/setup/choices.c",
                                           "include/slipstep/private/slipfaultregional.h"))
    return re.findall(r'(?:\[FAULT_\w+\]\s*=[\s\\]*\{[\s\\]*|^  \{)"(\w+)"', rows, re.M)


def read(code):
    """Full names of options in the sources that have one of our prefixes"""
    pattern = re.compile(r'"-((?:' + "|".join(OURS) + r')_?\w+)"')
    found = {name for content in code.values() for name in pattern.findall(content) if not name.endswith("_")}
    found |= {"fault_" + name for name in fault_table(code)}
    # PETSc reads those of solvers that have a prefix of their own
    for content in code.values():
        for prefix in re.findall(r'KSPAppendOptionsPrefix\([^;]*"(\w+_)"\)', content):
            found |= {prefix + "ksp_*", prefix + "pc_*"}
    # put together in smallmodel.h
    return found | {f"{model}_output{end}" for model in ("circuit", "sliding_mode") for end in ("", "_overwrite")}


class Options(ScriptTest):
    @classmethod
    def setUpClass(cls):
        cls.code = {}
        for folder in ("src", "examples", "training", "include"):
            for path in glob.glob(os.path.join(SOURCE, folder, "**", "*.[ch]"), recursive=True):
                with open(path, encoding="utf-8") as file:
                    cls.code[os.path.relpath(path, SOURCE)] = file.read()

    def test_help_needs_nothing_else(self):
        """Every program prints its help and ends well, whatever a run of it needs; packagers make manual pages from
        that."""
        programs = sorted(os.listdir(os.path.join(BUILD, "bin")))
        self.assertGreater(len(programs), 8)
        for program in programs:
            with self.subTest(program=program):
                done = subprocess.run([os.path.join(BUILD, "bin", program), "--help" if program == "slipstep"
                                       else "-help"], capture_output=True, text=True, timeout=120)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(program, done.stdout)

    def test_lists_hold_what_is_read(self):
        known = declared(self.code)
        self.assertGreater(len(known), 150)
        self.assertEqual(sorted(read(self.code) - known), [], "read, but not declared: a program would refuse it")
        self.assertEqual(sorted(known - read(self.code)), [], "declared, but nobody reads it")

    def test_every_prefix_is_in_the_list(self):
        """What our objects read begins with one of the prefixes above: others would not be looked at by the test
        before."""
        call = re.compile(
            r'PetscOptions(?:Bool|EList|Enum|FList|Int|IntArray|Real|RealArray|String|Viewer)\(\s*"-(\w+)"')
        names = {name for content in self.code.values() for name in call.findall(content)}
        self.assertGreater(len(names), 50)
        petsc = set(re.findall(r'\{"-(\w+)"', self.code["src/sys/solveroptions.c"])) - declared(self.code)
        self.assertEqual(sorted(name for name in names - petsc if not name.startswith(OURS)), [])

    def test_every_list_is_found(self):
        """The patterns above find the declarations of every prefix."""
        for prefix in OURS:
            self.assertTrue(any(name.startswith(prefix) for name in declared(self.code)), prefix)


if __name__ == "__main__":
    unittest.main()
