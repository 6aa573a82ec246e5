#!/usr/bin/env python3
"""The order of the rooms (ORDER of src/map.py) holds: by the symbol tables of the build's object files nothing calls
upward and no files need each other in a circle, and the wings of training keep the order of its page; by the sources no
include runs upward, training and examples include public headers only, and core knows no object of PETSc. The picture
src/map.svg shows the sources as they are. The modules of the Python package have an order and no circles."""
import ast
import collections
import glob
import os
import re
import subprocess
import sys
import unittest

from scripts import BUILD, SOURCE, ScriptTest

sys.path.insert(0, os.path.join(SOURCE, "src"))
import map as rooms

# What is not mended yet, as regular expressions of the lines found. It must be empty when version 0.2.0 is released.
PENDING = []
# What pure functions may use of other libraries: the C library's, and PETSc's for memory and errors.
OBJECTS = re.compile(r"^(Vec|Mat|IS|DM|KSP|PC|SNES|TS|PetscObject|PetscOptions|PetscViewer|PetscContainer|MPI_|H5)")


# The modules of the package from the bottom to the top: each imports those of lines above its own and of its own
# folder, and Python's package itself all.
PACKAGE = os.path.join(SOURCE, "src", "package", "slipstep")
PYTHON = (("errors",), ("modules", "times"), ("checks",), ("results", "fields", "wells"), ("geometry", "running"),
          ("formats", "petsc", "numbers"), ("plots",), ("studies",), ("programs",), ("__main__",), ("",))
HEAVY = {"matplotlib": ("plots", "programs"), "petsc4py": ("petsc",)}  # what only some import

LIBRARY = os.path.join(BUILD, "CMakeFiles", "slipstep.dir", "src"), os.path.join(SOURCE, "src")
TRAINING = os.path.join(BUILD, "training", "CMakeFiles", "sliptrain.dir"), os.path.join(SOURCE, "training")


def symbols(folder, source):
    """calls: (file, file) -> names, and undefined: file -> names, of the object files below a folder of the build.
    Those of files that have moved stay there, and are left out."""
    defined, undefined = {}, {}
    objects = sorted(glob.glob(os.path.join(folder, "**", "*.c.o"), recursive=True))
    objects = [path for path in objects
               if os.path.exists(os.path.join(source, os.path.relpath(path, folder)[:-len(".o")]))]
    if not objects:
        raise FileNotFoundError(f"no object files below {folder}: build first")
    listing = subprocess.run(["nm", "-A", *objects], capture_output=True, text=True, check=True).stdout
    for line in listing.splitlines():
        path, entry = line.split(":", 1)
        file = os.path.relpath(path, folder)[:-len(".o")]
        *_, kind, name = entry.split()
        if kind == "U":
            undefined.setdefault(file, set()).add(name)
        elif kind in "TDBRCVW":
            defined[name] = file
    calls = collections.defaultdict(set)
    for file, names in undefined.items():
        for name in names & set(defined):
            if defined[name] != file:
                calls[file, defined[name]].add(name)
    return calls, undefined


def modules(folder):
    """Name of each module of a package -> its syntax tree; a folder is the module of its __init__.py, the package
    itself "".
    """
    found = {}
    for path in glob.glob(os.path.join(folder, "**", "*.py"), recursive=True):
        words = os.path.relpath(path, folder)[:-len(".py")].split(os.sep)
        found[".".join(words[:-1] if words[-1] == "__init__" else words)] = ast.parse(rooms.read(path))
    return found


def imported(name, tree, known, package="slipstep"):
    """Modules of the package that a module imports, wherever it does so, and the first words of others'."""
    is_folder = name == "" or any(other.startswith(name + ".") for other in known)
    ours, others = set(), set()

    def add(full, names=()):
        """A module, or names of it, which may be modules themselves."""
        parts = {full if other not in known else other
                 for other in ([f"{full}.{n}".lstrip(".") for n in names] or [full])}
        ours.update(part for part in parts if part in known and part != name)

    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            up = name.split(".") if name else []
            up = up[:len(up) - node.level + is_folder]
            add(".".join(filter(None, [*up, node.module or ""])), [alias.name for alias in node.names])
        elif isinstance(node, ast.ImportFrom) and node.module.split(".")[0] == package:
            add(node.module.partition(".")[2], [alias.name for alias in node.names])
        elif isinstance(node, ast.ImportFrom):
            others.add(node.module.split(".")[0])
        elif isinstance(node, ast.Import):
            for alias in node.names:
                first, _, rest = alias.name.partition(".")
                add(rest) if first == package else others.add(first)
    return ours, others


def sources_of(folder):
    """Files of C and Python, those of builds left out"""
    return [os.path.relpath(path, folder) for top in ("src", "include", "examples", "training", "tests")
            for end in ("c", "h", "py")
            for path in sorted(glob.glob(os.path.join(folder, top, "**", f"*.{end}"), recursive=True))]


def too_long(texts):
    """What of {name: text} is longer than the house has it"""
    found = []
    for name, text in texts.items():
        lines, begin = text.split("\n"), 0
        if len(lines) > 601:
            found.append(f"{name} has {len(lines) - 1} lines")
        for k, line in enumerate(lines, 1):
            begin = k if line == "{" else begin
            if line == "}" and name.endswith(".c") and k - begin > 101:
                found.append(f"{name}: the function from line {begin} has {k - begin - 1} lines")
            if len(line) > 120:
                found.append(f"{name}: line {k} has {len(line)} columns")
    return found


class Layers(ScriptTest):
    def expect_none(self, found):
        left = [line for line in found if not any(re.search(p, line) for p in PENDING)]
        for line in sorted(set(found) - set(left)):
            print("pending:", line)
        self.assertEqual(left, [])

    def test_every_folder_is_a_room(self):
        sources = rooms.Sources()
        self.assertEqual(set(sources.files.values()) - set(rooms.ROOMS), set())
        self.assertEqual(len(rooms.ROOMS), len(set(rooms.ROOMS)))

    def test_every_file_has_a_name_of_its_own(self):
        """A stack trace and an editor's list say the name alone. PETSc's custom is a register.c for each class."""
        names = collections.Counter(os.path.basename(path) for top in ("src", "training")
                                    for path in glob.glob(os.path.join(SOURCE, top, "**", "*.c"), recursive=True))
        self.assertEqual([name for name, n in names.items() if n > 1 and name != "register.c"], [])

    def test_nobody_calls_upward(self):
        calls, _ = symbols(*LIBRARY)
        self.assertGreater(len(calls), 100)  # the tables were read
        self.expect_none(rooms.upward(calls, os.path.dirname))
        # what the picture is drawn from leaves out no call that the linker sees
        drawn = rooms.Sources().room_calls()
        pairs = {(os.path.dirname(a), os.path.dirname(b)) for a, b in calls}
        self.assertEqual({(a, b) for a, b in pairs if a != b} - set(drawn), set())

    def test_no_circles(self):
        for name, where in (("src", LIBRARY), ("training", TRAINING)):
            calls, _ = symbols(*where)
            self.expect_none([f"circle: {name}: " + ", ".join(circle) for circle in rooms.circles(calls)])

    def test_wings_of_training(self):
        """Each uses those to its left in the line "common < ..." of training/README.md, no other."""
        line = re.search(r"^ +(common <.*)$", rooms.read(os.path.join(SOURCE, "training", "README.md")), re.M)[1]
        level = {wing.strip(): k for k, group in enumerate(line.split("<")) for wing in group.split(",")}
        calls, _ = symbols(*TRAINING)
        found = []
        for (a, b), names in sorted(calls.items()):
            mine, other = (file.split("/")[0] for file in (a, b))
            if mine != other and level[mine] <= level[other]:
                found.append(f"training/{a} calls {', '.join(sorted(names))} of training/{b}, which is not below it")
        self.assertGreater(len(calls), 50)
        self.expect_none(found)

    def test_nobody_includes_upward(self):
        sources = rooms.Sources()
        self.assertGreater(len(sources.includes), 100)
        self.expect_none(rooms.upward_includes(sources.includes, sources.files.get))

    def test_headers_include_downward(self):
        found = []
        for path in glob.glob(os.path.join(SOURCE, "include", "**", "*.h"), recursive=True):
            name = os.path.relpath(path, os.path.join(SOURCE, "include"))
            room = rooms.header_room(name)
            self.assertIsNotNone(room, f"{name} is the header of no room")
            includes = [(name, other) for other in re.findall(r'#include\s+[<"]([^>"]+)[>"]', rooms.read(path))]
            found += rooms.upward_includes(includes, lambda file: room)
            if not name.startswith("slipstep/"):
                found += [f"{name} is public, but includes {other}" for _, other in includes
                          if other.startswith("slipstep/private")]
        self.expect_none(found)

    def test_programs_use_public_headers(self):
        found, files = [], []
        for folder in ("training", "examples", "tests/benchmarks", "tests/plugin"):
            for end in ("c", "h"):
                files += glob.glob(os.path.join(SOURCE, folder, "**", "*." + end), recursive=True)
        self.assertGreater(len(files), 40)
        for path in files:
            part = os.path.relpath(path, SOURCE)
            hidden = "private" if part.startswith(("training", "tests/benchmarks")) else "private|rooms"
            for name in re.findall(rf'#include\s+[<"](slipstep/(?:{hidden})[^>"]+)[>"]', rooms.read(path)):
                found.append(f"{part} includes {name}")
        self.expect_none(found)

    def test_core_is_pure(self):
        _, undefined = symbols(*LIBRARY)
        core = {file: names for file, names in undefined.items() if file.startswith("core/")}
        self.assertTrue(core)
        found = [f"pure: {file} uses {name}" for file, names in core.items() for name in names if OBJECTS.match(name)]
        headers = ("slipcore.h", "slipstep/rooms/slipcore.h", "slipstep/rooms/slipformulas.h")
        allowed = {"petscsys.h", "petscmath.h", "petscmacros.h", "slipcompat.h", *headers}
        for path in [*glob.glob(os.path.join(SOURCE, "src", "core", "*.c")),
                     *(os.path.join(SOURCE, "include", name) for name in headers)]:
            for name in re.findall(r"#include\s+[<\"]([^>\"]+)[>\"]", rooms.read(path)):
                ours = name.startswith("slip") or name.startswith("petsc")
                if ours and name not in allowed:
                    found.append(f"pure: {os.path.relpath(path, SOURCE)} includes {name}")
        self.expect_none(found)

    def python_faults(self, folder):
        """Lines on imports upward, circles, and heavy modules."""
        level = {part: k for k, parts in enumerate(PYTHON) for part in parts}
        trees, pairs, found = modules(folder), set(), []
        for name, tree in sorted(trees.items()):
            ours, others = imported(name, tree, trees)
            part = name.split(".")[0]
            self.assertIn(part, level, f"{name} is in no layer")
            pairs |= {(name, other) for other in ours}
            found += [f"{name or 'slipstep'} imports {other or 'slipstep'}, which is not below it" for other
                      in sorted(ours) if other.split(".")[0] != part and level[other.split(".")[0]] >= level[part]]
            found += [f"{name} imports {heavy}" for heavy, parts in HEAVY.items() if heavy in others
                      and part not in parts]
        return found + [f"circle: {', '.join(circle)}" for circle in rooms.circles(pairs)], pairs

    def test_modules_of_python(self):
        found, pairs = self.python_faults(PACKAGE)
        self.assertGreater(len(pairs), 100)
        self.expect_none(found)

    def test_python_faults_are_found(self):
        """A circle within a folder, one by an import within a function, an import upward, and a heavy one, each
        alone."""
        cases = (({"errors": "", "plots/a": "from .b import x", "plots/b": "from . import a"},
                  "^circle: plots.a, plots.b$"),
                 ({"running": "def f():\n    from . import petsc", "petsc": "from .running import f"},
                  "^running imports petsc, which is not below it|^circle: petsc, running$"),
                 ({"errors": "from slipstep.results import Run", "results/__init__": ""},
                  "^errors imports results, which is not below it$"),
                 ({"times": "import matplotlib.pyplot"}, "^times imports matplotlib$"),
                 ({"results/a": "from ..times import x", "times": ""}, None))
        for k, (files, expected) in enumerate(cases):
            for name, text in files.items():
                path = self.path(f"{k}/{name}.py")
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
            found, _ = self.python_faults(self.path(str(k)))
            self.assertEqual(bool(found), expected is not None, found)
            for line in found:
                self.assertRegex(line, expected)

    def test_import_is_light(self):
        """import slipstep brings neither NumPy nor HDF5, Matplotlib or PETSc; readers of results bring no
        Matplotlib."""
        for code, without in (("import slipstep", ("numpy", "h5py", "matplotlib", "petsc4py")),
                              ("import slipstep, slipstep.geometry.surface; slipstep.Result, slipstep.Run",
                               ("matplotlib", "petsc4py"))):
            done = subprocess.run([sys.executable, "-c", f"import sys\n{code}\nprint([name for name in {without!r} if "
                                   "name in sys.modules])"], capture_output=True, text=True,
                                  env=dict(os.environ, PYTHONPATH=os.path.dirname(PACKAGE)))
            self.assertEqual(done.stdout, "[]\n", done.stderr)

    def test_sizes(self):
        """Functions of C to 100 lines, files to 600, lines to 120 columns: a room is read a piece at a time."""
        self.assertEqual(too_long({name: open(os.path.join(SOURCE, name), encoding="utf-8").read()
                                   for name in sources_of(SOURCE)}), [])
        body = "int F(void)\n{\n" + "  g();\n" * 101 + "}\n"
        found = too_long({"a.c": body, "b.py": "x\n" * 601, "c.h": "/* " + "x" * 118 + " */\n",
                          "d.py": "x = 0\n# " + "y" * 119 + "\n"})
        self.assertEqual([line.split(" has ")[0] for line in found],
                         ["a.c: the function from line 2", "b.py", "c.h: line 1", "d.py: line 2"])

    def test_the_checks_find_what_they_look_for(self):
        self.assertEqual(rooms.circles({("a", "b"), ("b", "c"), ("c", "a"), ("c", "d")}), [["a", "b", "c"]])
        self.assertEqual(rooms.circles({("a", "b"), ("a", "c"), ("b", "c")}), [])
        room = {"x.c": "ts", "y.c": "snes"}.get
        self.assertEqual(rooms.upward({("x.c", "y.c"): {"F"}}, room), [])
        self.assertEqual(len(rooms.upward({("y.c", "x.c"): {"F"}}, room)), 1)
        self.assertEqual(rooms.upward_includes([("x.c", "slipsnes.h"), ("x.c", "petscts.h")], room), [])
        self.assertEqual(len(rooms.upward_includes([("y.c", "slipstep/private/slipts.h"), ("y.c", "slipnothing.h")],
                                                   room)), 2)
        self.assertEqual(rooms.reduced({("a", "b"), ("b", "c"), ("a", "c")}), [("a", "b"), ("b", "c")])

    def test_the_picture_is_true(self):
        kept = rooms.read(os.path.join(SOURCE, "src", "map.svg"))
        now = rooms.svg(rooms.Sources())
        lines = re.compile(r'(<text[^>]*class="lines"[^>]*>)([\d,]+) lines')
        hint = "draw the map anew: src/map.py"
        self.assertEqual(lines.sub(r"\1", kept), lines.sub(r"\1", now), hint)
        # lines change with every commit: a tenth, or fifty of a small room, are let pass
        for (_, old), (_, new) in zip(lines.findall(kept), lines.findall(now)):
            old, new = (int(n.replace(",", "")) for n in (old, new))
            self.assertLessEqual(abs(old - new), max(50, new // 10), hint)


if __name__ == "__main__":
    unittest.main()
