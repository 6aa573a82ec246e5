#!/usr/bin/env python3
"""The documentation's site: pages of the tree, and a reference that is made from -help, manual pages and docstrings, by
Sphinx.

    cmake --build build --target site                          into build/site/html
    src/site/build.py --build build --output build/site        the same by hand

Pages stay beside what they describe; PARTS says which belong to which part of the site. Links between pages lead to
pages, links to other files of the tree to the repository. Warnings are errors. Sphinx, MyST and the theme of Read the
Docs are needed (Debian's python3-sphinx, python3-myst-parser, python3-sphinx-rtd-theme).
"""

import argparse
import glob
import os
import re
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.path.normpath(os.path.join(HERE, "..", ".."))
PACKAGE = os.path.join(SOURCE, "src", "package", "slipstep")
sys.path[:0] = [os.path.join(SOURCE, "src"), os.path.dirname(PACKAGE)]
from slipstep.modules import need

need("sphinx", "myst_parser", "sphinx_rtd_theme")
import reference
from helptext import parse, printed

REPOSITORY = "https://github.com/slipstep/slipstep/blob/main/"
# folder of the site: (title, what it answers, sources in their order; patterns take the rest by name)
PARTS = {
    "tutorials": ("Tutorials", "You are new: which commands take you to a first result? Each tutorial is a lesson from "
                  "start to end, and each command is run by a test.",
                  ["examples/tutorials/first_run.md", "examples/tutorials/my_fault.md", "examples/tutorials/century.md",
                   "examples/tutorials/own_cycles.md", "examples/tutorials/benchmark.md",
                   "examples/tutorials/my_policy.md", "examples/tutorials/my_model.md"]),
    "howto": ("How-to", "You have a task: which options and files does it take? One page each.",
              ["examples/README.md", "examples/howto/*.md", "output/howto/*.md", "training/howto/*.md"]),
    "explanation": ("Explanation", "You want to know why: which equations are solved, how, how accurately, and what do "
                    "learned steps do?",
                    ["src/physics.md", "src/numerics.md", "src/accuracy.md", "src/geometry.md",
                     "training/learned_steps.md"]),
    "reference": ("Reference", "You know what you look for: options, files, functions. Made from the programs and "
                  "the sources.", ["output/README.md", "training/policy_file.md"]),
    "development": ("Development", "You change SlipStep, or want to know how its numbers came about.",
                    ["CONTRIBUTING.md", "src/README.md", "src/recipes.md", "tests/benchmarks/README.md",
                     "output/RESULTS.md", "training/README.md", "training/trials.md", "training/policies/README.md",
                     "CHANGELOG.md"]),
}
NAMES = {"output/README.md": "files", "examples/README.md": "index", "src/README.md": "map",
         "tests/benchmarks/README.md": "measured", "output/RESULTS.md": "results",
         "training/README.md": "training", "training/policies/README.md": "policies", "CONTRIBUTING.md": "contributing",
         "CHANGELOG.md": "changelog"}
# scripts that users start, whose --help the reference shows as it does that of programs, but for the study's
SCRIPTS = ["examples/make_fault.py", "examples/make_mesh.py", "examples/convert_mesh.py",
           "training/study/import_sb3.py"]
STUDY = ("plot-study", "results-table")
# what the reference shows of the package
MODULES = ("", "running", "fields", "wells", "results", "results.result", "results.run", "results.catalogue",
           "results.events", "results.fields", "geometry.surface", "studies.study", "studies.plan", "numbers.report",
           "numbers.source", "numbers.rupture", "numbers.stress", "numbers.cycle", "results.magnitudes", "errors",
           "petsc")
PROGRAMS = {"fault": "The fault", "sliding_mode": "The sliding mode", "circuit": "The circuit",
            "oscillator": "The oscillator", "train": "Training", "evaluate": "Evaluation of controllers"}


def pages():
    """Source -> page of the site without its ending, in order."""
    found = {"README.md": "index"}
    for part, (_, _, patterns) in PARTS.items():
        for pattern in patterns:
            for path in sorted(glob.glob(os.path.join(SOURCE, pattern))):
                source = os.path.relpath(path, SOURCE)
                found.setdefault(source, f"{part}/{NAMES.get(source, os.path.splitext(os.path.basename(source))[0])}")
    return found


class Site:
    def __init__(self, build, output):
        self.build, self.output = build, output
        self.source = os.path.join(output, "source")
        self.known = pages()
        self.assets = {}

    def write(self, page, text):
        path = os.path.join(self.source, page + ".md")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def link(self, target, source, page):
        """A link of a source as its page has it."""
        if re.match(r"\w+:", target) or target.startswith("#"):
            return target
        path, _, heading = target.partition("#")
        full = os.path.normpath(os.path.join(os.path.dirname(source), path))
        here = os.path.dirname(page)
        if full in self.known:
            return os.path.relpath(self.known[full] + ".md", here or ".") + ("#" + heading if heading else "")
        if re.search(r"\.(png|svg|gif|mp4)$", full):
            self.assets[full] = "_assets/" + full.replace("/", "_")
            return os.path.relpath(self.assets[full], here or ".")
        return REPOSITORY + full

    def convert(self, source, page):
        """Links rewritten outside of code."""
        with open(os.path.join(SOURCE, source), encoding="utf-8") as file:
            text = file.read()
        out, code = [], False
        for line in text.splitlines(True):
            if line.startswith("```"):
                code = not code
                # without the name of a file
                line = re.sub(r"^```(\w+).*", lambda m: "```" + {"opts": "text"}.get(m[1], m[1]), line)
            elif not code:
                line = re.sub(r"(\]\()([^)\s]+)(\))", lambda m: m[1] + self.link(m[2], source, page) + m[3], line)
            out.append(line)
        return "".join(out)

    def groups(self, page, text):
        """The text with a table of contents in each section: a page belongs to the first one that links to it."""
        folder, seen = os.path.dirname(page), {page}
        head, *sections = re.split(r"(?m)^(?=## )", text)
        for number, section in enumerate(sections):
            links = [os.path.normpath(os.path.join(folder, link))
                     for link in re.findall(r"\]\(([^)#\s]+)\.md[^)]*\)", section)]
            entries = [link for link in dict.fromkeys(links) if link.startswith(folder + "/") and link not in seen]
            if entries and not section.startswith("## Gallery"):
                seen.update(entries)
                sections[number] = (section.rstrip("\n") + "\n\n```{toctree}\n:hidden:\n\n"
                                    + "".join(f"/{entry}\n" for entry in entries) + "```\n\n")
        return head + "".join(sections)

    def copy_pages(self):
        for source, page in self.known.items():
            text = self.convert(source, page)
            if page == "index":
                text += ("\n```{toctree}\n:hidden:\n:maxdepth: 2\n\n" + "".join(f"{part}/index\n" for part in PARTS)
                         + "```\n")
            elif page.endswith("/index"):
                text = self.groups(page, text)
            self.write(page, text)
        for full, asset in self.assets.items():
            os.makedirs(os.path.join(self.source, "_assets"), exist_ok=True)
            shutil.copy(os.path.join(SOURCE, full), os.path.join(self.source, asset))

    def write_indices(self):
        for part, (title, question, _) in PARTS.items():
            if f"{part}/index" in self.known.values():  # has a page of its own
                continue
            entries = [page.split("/", 1)[1] for page in self.known.values() if page.startswith(part + "/")]
            if part == "reference":
                entries = ["options", "features", "scripts", *entries, "functions", "python"]
            self.write(f"{part}/index", f"# {title}\n\n{question}\n\n```{{toctree}}\n:maxdepth: 1\n\n"
                       + "\n".join(entries) + "\n```\n")

    def write_options(self):
        """Every option of ours once, under the program that has it first; options that several programs share are of
        the fault."""
        seen, lines = set(), ["# Options", "", "Made from what the programs print on `-help`. Times take units, as "
                              "`90s`, `10min`, `12h`, `20d` and `100y`; `-options_file F` reads options of a file, and "
                              "later options override earlier ones. Options of PETSc itself are in its own "
                              "[manual](https://petsc.org/release/manualpages/). [Choose options](../howto/options.md) "
                              "says more about those of the fault.", ""]
        for name, title in PROGRAMS.items():
            intro, sections = parse(printed(os.path.join(self.build, "bin", name)))
            lines += [f"## {title}: `{name}`", "", "```text", *intro.split("\n")[1:], "```", ""]
            for section, options in sections:
                rows = []
                for row in options:
                    if row[0] not in seen:
                        seen.add(row[0])
                        rows.append(row)
                if rows:
                    lines += [f"### {section.removesuffix(' options')} ({name})", "", "| option | default | meaning |",
                              "|---|---|---|"]
                    lines += [f"| `{option}` | {f'`{default}`' if default else ''} | {cell(text)} |"
                              for option, default, text in rows] + [""]
        self.write("reference/options", "\n".join(lines))
        return seen

    def write_features(self):
        """What goes with what: the table of src/fault/setup/features.c, as fault prints it."""
        done = subprocess.run([os.path.join(self.build, "bin", "fault"), "-fault_features"], capture_output=True,
                              text=True, check=True, env={**os.environ, "OMPI_MCA_ess_singleton_isolated": "1"})
        *rules, rest = done.stdout.strip().split("\n")
        lines = ["# What goes with what", "", "Printed by `fault -fault_features`. What does not go together is "
                 "refused before anything is computed, by the sentence of its row; all else does, and a test runs "
                 "every pair. Options that only have no effect beside others are named by a warning.", "",
                 "| feature | | other | but for | refused by |", "|---|---|---|---|---|"]
        lines += ["| " + " | ".join(cell(part) for part in rule.split(" | ")) + " |" for rule in rules]
        lines += ["", "Named by no row, and with all others: " + cell(rest.split(": ", 1)[1]) + ".", ""]
        self.write("reference/features", "\n".join(lines))

    def write_scripts(self):
        """What each script prints on --help."""
        lines = ["# Scripts", "", "What the scripts in Python print on `--help`.", ""]
        programs = [os.path.basename(path)[:-len(".py")].replace("_", "-")
                    for path in sorted(glob.glob(os.path.join(PACKAGE, "programs", "[a-z]*.py")))]
        programs = [name for name in programs if name not in STUDY]
        for title, words in [(f"slipstep {name}", ["src/package/program.py", name])
                             for name in programs] + [(script, [script]) for script in SCRIPTS]:
            done = subprocess.run([sys.executable, os.path.join(SOURCE, words[0]), *words[1:], "--help"],
                                  capture_output=True, text=True, check=True, env={**os.environ, "COLUMNS": "140"})
            lines += [f"## `{title}`", "", "```text", done.stdout.strip(), "```", ""]
        self.write("reference/scripts", "\n".join(lines))

    def write_functions(self):
        """A section for each header, a heading for each function."""
        tree = reference.check(SOURCE)
        headers = {}
        for name, page in sorted(tree.pages.items()):
            declared = tree.declared.get(name)
            header = os.path.basename(declared[0]) if declared else "types and plain functions"
            headers.setdefault(header, []).append((name, page))
        entries = []
        for header, found in sorted(headers.items()):
            slug = header.replace(".h", "").replace(" ", "_")
            entries.append(slug)
            lines = [f"# {'`' + header + '`' if header.endswith('.h') else header.capitalize()}", ""]
            for name, page in found:
                summary = page.summary or ""
                lines += [f"## {name}", "", cell(summary), ""]
                if page.prototype:
                    lines += ["```c", page.prototype.strip() + ";", "```", ""]
                body = [text[2:] if text.startswith("  ") else text for text in page.lines[1:]]
                lines += ["```text", *body, "```", ""]
            self.write(f"reference/functions/{slug}", "\n".join(lines))
        self.write("reference/functions", "# Functions\n\nThe manual pages of all public functions and types, by "
                   "header.\n\n```{toctree}\n:maxdepth: 1\n\n"
                   + "\n".join(f"functions/{slug}" for slug in entries) + "\n```\n")

    def write_python(self):
        """Docstrings of the package, read without importing it."""
        import ast
        lines = ["# Python", "", "Docstrings of the package `slipstep`; [how to use it](../howto/python.md).", ""]
        for module in MODULES:
            path = os.path.join(PACKAGE, *module.split("."))
            with open(os.path.join(path, "__init__.py") if os.path.isdir(path) else path + ".py",
                      encoding="utf-8") as file:
                tree = ast.parse(file.read())
            lines += [f"## {'.'.join(filter(None, ('slipstep', module)))}", "", "```text",
                      ast.get_docstring(tree) or "", "```", ""]
            for node in tree.body:
                lines += self.described(node, "")
        self.write("reference/python", "\n".join(lines))

    def described(self, node, owner):
        import ast
        if (not isinstance(node, (ast.ClassDef, ast.FunctionDef)) or node.name.startswith("_")
            or not ast.get_docstring(node)):
            return []
        signature = "" if isinstance(node, ast.ClassDef) else f"({ast.unparse(node.args)})"
        lines = [f"{'####' if owner else '###'} `{owner}{node.name}{signature}`", "", "```text",
                 ast.get_docstring(node), "```", ""]
        if isinstance(node, ast.ClassDef):
            for inner in node.body:
                lines += self.described(inner, node.name + ".")
        return lines

    def run(self):
        shutil.rmtree(self.source, ignore_errors=True)
        os.makedirs(self.source)
        self.copy_pages()
        self.write_indices()
        self.write_options()
        self.write_features()
        self.write_scripts()
        self.write_functions()
        self.write_python()
        shutil.copy(os.path.join(HERE, "conf.py"), self.source)
        os.makedirs(os.path.join(self.source, "_static"))
        shutil.copy(os.path.join(HERE, "site.css"), os.path.join(self.source, "_static"))
        html = os.path.join(self.output, "html")
        shutil.rmtree(html, ignore_errors=True)
        done = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-j", "2", "-d",
                               os.path.join(self.output, "doctrees"), "-b", "html", self.source, html])
        if done.returncode:
            sys.exit("src/site/build.py: Sphinx found errors or warnings, see above")
        print(f"Site: {os.path.join(html, 'index.html')}")


def cell(text):
    """Plain text within a table of Markdown."""
    return re.sub(r"([|*_<>\[\]])", r"\\\1", text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--build", required=True, metavar="DIR", help="a build with its programs")
    parser.add_argument("--output", required=True, metavar="DIR", help="folder for the site")
    options = parser.parse_args()
    Site(os.path.abspath(options.build), os.path.abspath(options.output)).run()


if __name__ == "__main__":
    main()
