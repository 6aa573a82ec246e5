#!/usr/bin/env python3
"""src/reference.py: the tree's manual pages are complete; each kind of broken page is refused with file, line and what
is missing; what is written has a page for every public function."""
import glob
import os
import re
import subprocess
import sys
import unittest

from scripts import SOURCE, ScriptTest

SCRIPT = os.path.join(SOURCE, "src", "reference.py")
HEADER = """/* A library. */
#pragma once
/* What is rubbed. */
typedef struct _p_SlipBlock *SlipBlock;
PETSC_EXTERN PetscErrorCode SlipBlockPush(SlipBlock block, PetscReal force, PetscInt n, PetscReal *slip);
"""
PAGE = """/* A file. */
/*@
  SlipBlockPush - push a block and look how far it slips

  Collective

  Input Parameters:
+ block - the block
. force - the force [N]
- n     - how often

  Output Parameter:
. slip - how far it went [m]

  Options Database Keys:
+ -block_force <1>   - the same [N]
. -block_often <3>   - the same
- -block_dry         - without water

  Level: beginner

  Errors: PETSC_ERR_ARG_OUTOFRANGE for n < 1

.seealso: SlipBlock, VecCreate()
@*/
PetscErrorCode SlipBlockPush(SlipBlock block, PetscReal force, PetscInt n, PetscReal *slip)
{
  PetscCheck(n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "n is %d", (int)n);
  return 0;
}
"""
# what is changed in the page, and what the error must say
BROKEN = [
    ("SlipBlockPush - push a block and look how far it slips", "SlipBlockPush", "has no summary"),
    ("  Collective\n\n", "", "collective"),
    (". force - the force [N]\n", "", "the parameter force is not described"),
    ("- n     - how often\n", ". n     - how often\n- speed - how fast [m/s]\n",
     "describes speed, which is no parameter"),
    ("the force [N]", "the force [n]", "force has no unit"),
    ("how far it went [m]", "how far it went", "slip has no unit"),
    ("  Level: beginner\n", "", "no \"Level:"),
    ("  Level: beginner\n", "  Level: guru\n", "no \"Level:"),
    ("  Errors: PETSC_ERR_ARG_OUTOFRANGE for n < 1\n", "", "raises errors, but has no section"),
    (".seealso: SlipBlock, VecCreate()\n", "", "no \".seealso:\""),
    ("SlipBlock, VecCreate()", "SlipBlockPull()", "see also SlipBlockPull, which does not exist"),
    ("push a block and", "push as SlipBlockPull() and", "mentions SlipBlockPull(), which does not exist"),
    # what a formatter does to lists
    ("the same [N]\n. -block_often <3>   - the same\n", "the same [N] . -block_often <3> - the\nsame\n",
     "a list marker in the middle of a line"),
    ("push a block and look how far it slips", "push a block and look\nhow far it slips",
     "in column 0 is no list item"),
    ("+ block - the block\n. force - the force [N]", "  block - the block\n. force - the force [N]",
     "under Input Parameter is no list item"),
    ("+ block", ". block", 'markers "..-"'),
    (". slip -", "- slip -", 'markers "-"'),
    ("@*/\nPetscErrorCode SlipBlockPush", "@*/\nPetscErrorCode SlipBlockShove", "its page is above SlipBlockShove()"),
    ("/*@", "/*", "is public, but has no manual page"),
    ("@*/", "*/", "a manual page is not closed"),
]


class Reference(ScriptTest):
    def check(self, page, header=HEADER, *arguments):
        for folder, name, text in (("include", "slipblock.h", header), ("src/sys", "block.c", page)):
            os.makedirs(self.path(folder), exist_ok=True)
            with open(os.path.join(self.path(folder), name), "w", encoding="utf-8") as f:
                f.write(text)
        return subprocess.run([sys.executable, SCRIPT, "--source", self.folder.name, *arguments], capture_output=True,
                              text=True)

    def test_the_tree_is_complete(self):
        run = subprocess.run([sys.executable, SCRIPT, "--output", self.path("out"), "--petsc",
                              os.environ.get("SLIPSTEP_PETSC", "")], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        written = {os.path.splitext(os.path.basename(p))[0] for p in glob.glob(self.path("out/*.html"))}
        public = set()
        for path in glob.glob(os.path.join(SOURCE, "include",
                                           "*.h")) + [os.path.join(SOURCE, "training", "sliptrain.h")]:
            with open(path, encoding="utf-8") as f:
                text = re.sub(r"/\*.*?\*/", "", f.read(), flags=re.S)
            public |= set(re.findall(r"^PETSC_EXTERN[\w\s*]*?(\w+)\(", text, re.M))
        self.assertGreater(len(public), 100)  # the search itself found the headers
        self.assertEqual(public - written, set())
        index = self.content("out/index.html")
        for name in public:
            self.assertIn(f'href="{name}.html"', index)

    def test_a_good_page_passes(self):
        run = self.check(PAGE)
        self.assertEqual((run.returncode, run.stderr), (0, ""))

    def test_broken_pages_fail(self):
        for old, new, message in BROKEN:
            with self.subTest(message):
                self.assertEqual(PAGE.count(old), 1)
                run = self.check(PAGE.replace(old, new))
                self.assertEqual(run.returncode, 1)
                self.assertIn(message, run.stderr)
                self.assertRegex(run.stderr, r"(?m)^(src/sys/block\.c|include/slipblock\.h):\d+: ")

    def test_pure_functions_have_comments(self):
        for comment, code in (("/* Twice x */\n", 0), ("", 1), ("/* Twice x */\n\n", 1)):
            with self.subTest(comment):
                os.makedirs(self.path("src/core"), exist_ok=True)
                self.put("src/core/twice.c",
                         "/* A file. */\n#include <slipcore.h>\n\nstatic double Same(double x)\n{\n  "
                         "return x;\n}\n\n" + comment + "double SlipTwice(double x)\n{\n  return 2 * Same(x);\n}\n")
                run = self.check(PAGE)
                self.assertEqual(run.returncode, code)
                self.assertEqual("src/core/twice.c:" in run.stderr and "SlipTwice has no comment" in run.stderr,
                                 bool(code))

    def test_types_have_comments(self):
        run = self.check(PAGE, HEADER.replace("/* What is rubbed. */\n", ""))
        self.assertEqual(run.returncode, 1)
        self.assertIn("include/slipblock.h:3: the type SlipBlock has no comment", run.stderr)

    def test_names_are_looked_up_in_the_headers_given(self):
        os.makedirs(self.path("petsc"))
        self.put("petsc/petscvec.h", "PETSC_EXTERN PetscErrorCode VecCreate(MPI_Comm, Vec *);\n")
        self.assertEqual(self.check(PAGE, HEADER, "--petsc", self.path("petsc")).returncode, 0)
        run = self.check(PAGE.replace("VecCreate", "VecCreat"), HEADER, "--petsc", self.path("petsc"))
        self.assertIn("see also VecCreat, which does not exist", run.stderr)


if __name__ == "__main__":
    unittest.main()
