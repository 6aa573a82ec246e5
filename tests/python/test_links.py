#!/usr/bin/env python3
"""Pages (every *.md under git): links lead to files and headings that exist; options, functions and files that are
named exist in the sources; defaults are those of -help alone; in the map's walk a function is in the file of its row.
The README stays short."""
import glob
import os
import re
import subprocess
import unittest

from scripts import BUILD, SOURCE, ScriptTest

# options of the library and its programs; what follows must occur in the sources, with its dash or without its first
# word
OPTION = re.compile(r"-(fault|ts_bathe|ts_adapt_rl|ts_adapt_pi|ts_adapt_heuristic|train|evaluate|"
                    r"mat_slip|pc_slip|snes_slip|sliding_mode|circuit|oscillator)_(\w+)")
# words of options that are put together from parts, and names that end in "_" because a list follows
PARTS = re.compile(r"_$")



def read(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def pages(source=SOURCE):
    found = []
    for path in glob.glob(os.path.join(source, "**", "*.md"), recursive=True):
        first = os.path.relpath(path, source).split(os.sep)[0]
        if not first.startswith("build"):
            found.append(path)
    return sorted(found)


def without_code(text):
    """Code blocks and spans blanked, so that what looks like a link there is none."""
    text = re.sub(r"^```.*?^```", lambda m: re.sub(r"[^\n]", " ", m[0]), text, flags=re.M | re.S)
    return re.sub(r"`[^`\n]*`", lambda m: " " * len(m[0]), text)


def anchor(heading):
    """As GitHub makes them: lower case, punctuation out, blanks to hyphens."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")


def anchors(path):
    return {anchor(h) for h in re.findall(r"^#{1,6} +(.*)$", re.sub(r"^```.*?^```", "", read(path), flags=re.M | re.S),
                                          re.M)}


def broken_links(path):
    text, found = without_code(read(path)), []
    for match in re.finditer(r"\]\(([^)\s]+)\)", text):
        target = match[1]
        if re.match(r"\w+:", target):
            continue
        file, _, heading = target.partition("#")
        full = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
        where = f"{os.path.relpath(path, SOURCE)}:{text.count(chr(10), 0, match.start()) + 1}: {target}"
        if not os.path.exists(full):
            found.append(where + ": no such file")
        elif heading and not (full.endswith(".md") and heading in anchors(full)):
            found.append(where + ": no such heading")
    return found


def sources():
    texts = {}
    for folder in ("src", "include", "training", "examples", "tests", "output"):
        for end in ("c", "h", "py", "sh", "opts"):
            for path in glob.glob(os.path.join(SOURCE, folder, "**", "*." + end), recursive=True):
                texts[os.path.relpath(path, SOURCE)] = read(path)
    return texts


class Links(ScriptTest):
    @classmethod
    def setUpClass(cls):
        cls.texts = sources()
        cls.code = "\n".join(text for name, text in cls.texts.items() if name.endswith((".c", ".h")))

    def test_links_lead_somewhere(self):
        self.assertGreater(len(pages()), 7)
        self.assertEqual([line for path in pages() for line in broken_links(path)], [])

    def test_broken_links_are_found(self):
        path = self.path("page.md")
        with open(path, "w", encoding="utf-8") as f:
            f.write("# A page, or `two`\n[a](page.md#a-page-or-two) [b](#a-page-or-two) [c](none.md) [d](#none) "
                    "`[e](none)`\n```\n[f](none)\n# none\n```\n")
        self.assertEqual([line.split(": ", 1)[1] for line in broken_links(path)],
                         ["none.md: no such file", "#none: no such heading"])

    def test_options_exist(self):
        found = []
        for path in pages():
            for match in OPTION.finditer(read(path)):
                name = match[0]
                if PARTS.search(name):
                    continue
                # options of tables are written without their first word
                if f'"{name}"' not in self.code and f'"{match[2]}"' not in self.code and name + " " not in self.code:
                    found.append(f"{os.path.relpath(path, SOURCE)}: {name}")
        self.assertEqual(sorted(set(found)), [])

    def test_defaults_are_of_help_alone(self):
        """No page repeats the default of an option of ours in a table, and no default is NaN, which ends runs from
        PETSc 3.22 on."""
        known = {}
        for program in ("fault", "train"):
            run = subprocess.run([os.path.join(BUILD, "bin", program), "-help", program], capture_output=True,
                                 text=True, cwd=self.folder.name)
            known.update(re.findall(r"^ *(-\w+):? <(?:now )?([^ :>]*)(?: : [^>]*)?>", run.stdout, re.M))
        self.assertGreater(len(known), 100)
        self.assertEqual([name for name, value in known.items() if value.lower().rstrip(".") == "nan"], [])
        found = []
        for path in pages():
            for table in re.findall(r"(?m)^\| option \|.*\| default \|\n((?:\|.*\n)+)", read(path)):
                names = re.findall(r"`(-\w+)", "\n".join(row.split("|")[1] for row in table.splitlines()))
                found += [f"{os.path.relpath(path, SOURCE)}: {name}" for name in names if name in known]
        self.assertEqual(found, [])

    def test_functions_and_files_exist(self):
        found = []
        for path in pages():
            text = re.sub(r"^```.*?^```", "", read(path), flags=re.M | re.S)
            for name in re.findall(
                r"`((?:Slip|TSBathe|TSAdaptRL|TSAdaptCreate_|MatSlip|MatCreateSlip|SNESSlip|SNESSetSlip)\w*)\(\)`",
                text):
                if not re.search(rf"\b{name}\(", self.code) and not name.endswith("_NAME"):
                    found.append(f"{os.path.relpath(path, SOURCE)}: {name}()")
            for name in re.findall(
                r"`((?:src|include|training|tests|examples|output)/[\w./-]+\.(?:c|h|py|sh|opts|md|h5))`", text):
                if (not os.path.exists(os.path.join(SOURCE, name)) and "NAME" not in name
                    and not name.startswith("output/")):
                    found.append(f"{os.path.relpath(path, SOURCE)}: {name}")
        self.assertEqual(sorted(set(found)), [])

    def test_the_walk_is_true(self):
        """In a row of the map's walk each function is defined in the file that is named last before it."""
        rows = re.findall(r"^\|[^|]*\|([^|]*\(\w[\w/]*\.c\)[^|]*)\|$", read(os.path.join(SOURCE, "src", "README.md")),
                          re.M)
        self.assertGreater(len(rows), 8)
        found = []
        for row in rows:
            file = None
            for link, function in re.findall(r"\]\(([\w/]+\.c)\)|`(\w+)\(\)`", row):
                if link:
                    file = link
                elif not re.search(rf"^(?:static )?[A-Za-z][\w *]*\b{function}\([^;]*?\)\s*\{{",
                                   self.texts.get("src/" + file, ""), re.M):
                    found.append(f"{function}() is not defined in src/{file}")
        self.assertEqual(found, [])

    def test_the_workflow_runs_the_commands_of_the_front_page(self):
        """In containers of the systems that tests/setup.sh installs on."""
        workflow = read(os.path.join(SOURCE, ".github", "workflows", "ci.yml"))
        commands = re.findall(r"^ +run: (\S+\.sh)$", workflow, re.M)
        self.assertEqual(commands, re.findall(r"^(\S+\.sh) +#", read(os.path.join(SOURCE, "README.md")), re.M))
        self.assertTrue(all(os.access(os.path.join(SOURCE, command), os.X_OK) for command in commands), commands)
        systems = re.search(r'SLIPSTEP_SYSTEMS="([^"]*)"', read(os.path.join(SOURCE, "tests", "setup.sh")))[1]
        images = re.findall(r'"([\w:.]+)"', re.search(r"^ +system: (\[.*\])$", workflow, re.M)[1])
        self.assertEqual([image.replace(":", " ") for image in images], systems.split(", "))

    def test_the_front_page_is_short(self):
        self.assertLessEqual(read(os.path.join(SOURCE, "README.md")).count("\n"), 150)


if __name__ == "__main__":
    unittest.main()
