#!/usr/bin/env python3
"""The API reference, from the manual pages in the sources: one HTML page for each public function and type, and an
index by room.

    cmake --build build --target reference        into build/reference/
    src/reference.py [--source DIR] [--output DIR] [--petsc INCLUDE]

Pages are PETSc's: comments between slash-star-@ and @-star-slash above a function, and slash-star-MC ... M-star-slash
for the types that options choose. Everything declared with PETSC_EXTERN in include/*.h and training/sliptrain.h must
have one. Of the functions of src/core, which are collective on nothing and raise nothing, a comment right above
each is enough. The exit code is 1, with a line "file:line: what is wrong" for each, where a page is missing or
malformed: check_page() has the rules. --output "" checks only.
"""
import argparse
import glob
import html
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
LISTS = ("Input Parameter", "Output Parameter", "Input/Output Parameter", "Options Database Key")
# Names of other libraries, where --petsc does not give the headers to look them up in.
FOREIGN = re.compile(r"(Petsc|PETSC|TS|SNES|KSP|PC|Mat|MAT|Vec|VEC|IS|DM|MPI_)\w*$")
# How a description says its unit: in brackets, or in words; a state has those of its system. [n] is a shape, not a
# unit.
UNIT = re.compile(
    r"dimensionless|\bstates?\b|\bunits?\b|_unit\b|\bseconds\b|\bbytes\b|"
    r"\[[^\]]*(?<![\w])(1|m|mm|km|s|deg|Pa|kg|J|N|W|V|T\*|1/s|%)(?![\w*])[^\]]*\]")


class Tree:
    """What the sources declare, define and document."""

    def __init__(self, source):
        self.source, self.errors = source, []
        self.declared = {}  # function -> (file, line) of public headers
        self.types = {}  # type -> (file, line, comment, declaration)
        self.pages = {}  # function or type -> Page
        self.defined = set()  # every function and macro of the sources, also private ones
        for path in sorted(glob.glob(f"{source}/include/*.h") + glob.glob(f"{source}/training/sliptrain.h")):
            self.read_header(path)
        for path in sorted(glob.glob(f"{source}/include/**/*.h", recursive=True)):
            text = read(path)
            self.defined |= set(re.findall(r"\b(\w+)\(", text)) | set(re.findall(r"#define\s+(\w+)", text))
        for path in sorted(glob.glob(f"{source}/src/**/*.c", recursive=True)
                           + glob.glob(f"{source}/training/**/*.c", recursive=True)):
            self.read_source(path)
        core = f"{source}/include/slipcore.h"
        if os.path.exists(core):
            self.read_pure(core, read(core), blank_comments(read(core)))

    def error(self, path, line, text):
        self.errors.append(f"{os.path.relpath(path, self.source)}:{line}: {text}")

    def read_header(self, path):
        text = read(path)
        code = blank_comments(text)
        for match in re.finditer(r"^PETSC_EXTERN\s+[\w\s*]*?\b(\w+)\(", code, re.M):
            self.declared[match[1]] = path, line_of(text, match.start()), code[match.start() + len("PETSC_EXTERN"):]
        for match in re.finditer(r"^[ ]*typedef\s+(?:(?:enum|struct)\s*\{[^}]*\}\s*(\w+)|[\w\s*]*?\b(\w+);|"
                                 r"[\w\s*]*?\(?\*?(\w+)\)?\([^;]*\));?", code, re.M | re.S):
            name = match[1] or match[2] or match[3]
            before = re.search(r"/\*((?:(?!\*/).)*)\*/\s*\Z", text[:match.start()], re.S)
            after = re.match(r"[ ]*/\*(.*?)\*/", text[match.end():], re.S)
            inside = re.findall(r"/\*(.*?)\*/", text[match.start():match.end()], re.S)
            # the comment above, behind, or of every field
            gap = before and before.group(0).rstrip(" ").count("\n", before.group(0).rfind("*/")) > 1
            comment = before[1] if before and not gap else after[1] if after else "; ".join(inside)
            first = text.index("#pragma once") if "#pragma once" in text else 0
            if before and before.end() <= first:
                comment = ""
            if not comment.strip() and os.path.basename(path) != "slipcompat.h":
                self.error(path, line_of(text, match.start()), f"the type {name} has no comment above it")
            self.types[name] = path, line_of(text, match.start()), comment, text[match.start():match.end()]

    def read_source(self, path):
        text = read(path)
        code = blank_comments(text)
        for match in re.finditer(r"^(?!typedef|#)[\w][\w\s*]*?\b(\w+)\(", code, re.M):
            self.defined.add(match[1])
        for match in re.finditer(r"/\*(@C?|MC|E|S)[ ]*\n(.*?)(?:@|M|E|S)\*/[ ]*\n", text, re.S):
            page = Page(path, line_of(text, match.start()), match[1], match[2])
            if match[1].startswith("@"):
                page.read_prototype(code[match.end():])
                if page.name in self.declared:
                    page.read_parameters(self.declared[page.name][2])
            if page.name in self.pages:
                self.error(path, page.line, f"{page.name} has a second page")
            self.pages[page.name] = page
        if os.path.basename(os.path.dirname(path)) == "core":
            self.read_pure(path, text, code)
        for match in re.finditer(r"/\*(@C?|MC)(?![\s\S]*?(?:@|M)\*/)", text):
            self.error(path, line_of(text, match.start()), "a manual page is not closed")

    def read_pure(self, path, text, code):
        """Functions of core: a comment right above each is the page of those that are public."""
        inline = "(?:static inline )?" if path.endswith(".h") else ""
        for match in re.finditer("^" + inline + r"(?!static|typedef|extern|return)\w[\w\s*]*?\b(\w+)\(", code, re.M):
            end = closing(code, match.end() - 1, "(", ")")
            hidden = not inline and match[1] not in self.declared
            if not re.match(r"\s*\{", code[end + 1:]) or match[1] in self.pages:
                continue
            comment = re.search(r"/\*((?:(?!\*/).)*)\*/\n\Z", text[:match.start()], re.S)
            page = Page(path, line_of(text, match.start()), "core", "")
            page.name = match[1]
            words = (re.sub(r"^\s*(?:" + match[1] + r" - )?", "", comment[1]) if comment
                     and not comment[1].startswith(" ----") else "")
            sentence = re.split(r"(?<=[.;:?])\s|\n\s*\n", words.strip())[0]
            page.summary, page.lines = re.sub(r"\s+", " ", sentence), [""] + words.split("\n")
            page.read_prototype(code[match.start():])
            if not page.summary:
                self.error(path, page.line, f"{page.name} has no comment right above it")
            if not hidden:
                self.pages[page.name] = page


class Page:
    """One manual page: name, summary, parameters and paragraphs, and of a function its prototype and body."""

    def __init__(self, path, line, kind, text):
        self.path, self.line, self.kind, self.text = path, line, kind, text
        self.lines = text.rstrip().split("\n")
        first = re.match(r"\s+(\w+)\s+-\s+(.*)", self.lines[0] if self.lines else "")
        self.name, self.summary = (first[1], first[2]) if first else ("", "")
        self.parameters, self.prototype, self.body = [], "", ""
        self.items = {}  # section -> [(names, description, line)]
        self.seealso = ""

    def read_prototype(self, code):
        match = re.match(r"\s*((?:[\w*]+[\s*]+)+?(\w+)\s*\()", code)
        if not match:
            return
        end = closing(code, match.end() - 1, "(", ")")
        self.function = match[2]
        start = code.find("{", end)
        if start >= 0 and not code[end + 1:start].strip():
            self.body = code[start:closing(code, start, "{", "}") + 1]
        self.read_parameters(code)

    def read_parameters(self, code):
        """From a prototype; the public header's names are those that count."""
        opening = code.index("(")
        end = closing(code, opening, "(", ")")
        self.prototype = re.sub(r"\s+", " ", code[:end + 1].strip())
        self.parameters = []
        for declaration in split_commas(code[opening + 1:end]):
            declaration = declaration.strip()
            if declaration in ("void", ""):
                continue
            pointer = re.search(r"\(\s*\*+\s*(\w+)\s*\)\s*\(", declaration)
            name = (pointer[1] if pointer else "..." if declaration == "..."
                    else re.findall(r"\w+", re.sub(r"\[.*", "", declaration))[-1])
            self.parameters.append((name, declaration))


def read(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def line_of(text, offset):
    return text.count("\n", 0, offset) + 1


def blank_comments(text):
    """The code alone, every character at its place."""
    return re.sub(r'/\*.*?\*/|"(?:\\.|[^"\\\n])*"', lambda m: re.sub(r"[^\n]", " ", m[0]) if m[0][0] == "/" else m[0],
                  text, flags=re.S)


def closing(code, start, opening, close):
    depth = 0
    for k in range(start, len(code)):
        depth += (code[k] == opening) - (code[k] == close)
        if not depth:
            return k
    return len(code)


def split_commas(text):
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([") - (character in ")]")
        if character == "," and not depth:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def check_lists(tree, page):
    """Fills page.items; the markers are +, . and - in column 0, continued by indented lines."""
    section = None
    for k, text in enumerate(page.lines):
        line = page.line + 1 + k
        heading = re.match(r"\s+([A-Z][\w/ ]*?)s?(?: \([^)]*\))?:\s*$", text)
        item = re.match(r"([+.-])\s+(\S.*?)\s+-\s+(\S.*)", text)
        if heading:
            section = heading[1] if heading[1] in LISTS + ("Reference",) else None
            if section:
                page.items.setdefault(section, [])
        elif text.startswith(".seealso"):
            section, page.seealso = None, text[len(".seealso"):].lstrip(":")
        elif re.match(r"\.v[be]$", text):
            section = None
        elif item:
            if section is None:
                tree.error(page.path, line, f"{page.name}: a list item outside of a list of parameters or options")
                continue
            page.items[section].append([item[2], item[3], line, item[1]])
        elif text and not text[0].isspace():
            tree.error(page.path, line,
                       f"{page.name}: \"{text[:40]}\" in column 0 is no list item \"+ name - meaning\": has a "
                       "formatter joined lines?")
        elif not text.strip():
            if section and page.items[section]:
                section = None
        elif section and page.items[section]:
            page.items[section][-1][1] += " " + text.strip()
        elif section:
            tree.error(page.path, line,
                       f"{page.name}: \"{text.strip()[:40]}\" under {section} is no list item in column 0")
        elif page.seealso and not text.startswith("."):
            page.seealso += " " + text.strip()
        if re.search(r"\S\s+[.+-]\s+-\w[\w<> .-]*\s+-\s|\S\s+\.\s+\w+\s+-\s", text):
            tree.error(page.path, line,
                       f"{page.name}: a list marker in the middle of a line: a formatter has joined lines")
    for name, items in page.items.items():
        markers = "".join(item[3] for item in items)
        wanted = "." if len(items) == 1 else "+" + "." * (len(items) - 2) + "-"
        if not items:
            tree.error(page.path, page.line, f"{page.name}: nothing under {name}")
        elif markers != wanted:
            tree.error(page.path, items[0][2],
                       f"{page.name}: the list under {name} has the markers \"{markers}\", expected \"{wanted}\"")


def check_parameters(tree, page):
    described = {}
    for section in LISTS[:3]:
        for names, text, line, _ in page.items.get(section, []):
            for name in re.split(r"\s*,\s*(?!\.\.)", names):
                described[name.strip("`")] = text, line
    for name, declaration in page.parameters:
        if name not in described:
            tree.error(page.path, page.line, f"{page.name}: the parameter {name} is not described")
        elif re.search(r"\bPetscReal\b", declaration) and "(" not in declaration:
            if not UNIT.search(described[name][0]):
                tree.error(page.path, described[name][1],
                           f"{page.name}: {name} has no unit, for example [m], and is not called dimensionless")
    for name, (_, line) in described.items():
        if name not in [n for n, _ in page.parameters]:
            tree.error(page.path, line, f"{page.name}: describes {name}, which is no parameter")


def check_page(tree, page, known):
    """Every rule for a page; known: names of functions and types, ours and PETSc's, that it may refer to."""
    where = page.path, page.line
    if page.kind == "core":
        return
    if not page.summary:
        tree.error(*where, f"{page.name or 'a page'} has no summary \"Name - what it does\" in its first line")
        return
    check_lists(tree, page)
    if page.kind.startswith("@"):
        if not page.prototype:
            tree.error(*where, f"{page.name}: no function follows its page")
            return
        if page.function != page.name:
            tree.error(*where, f"{page.name}: its page is above {page.function}()")
        if not re.search(r"^\s+(Collective|Logically collective|Not collective)\b", page.text, re.M | re.I):
            tree.error(*where, f"{page.name}: no line says whether it is collective (Collective, Logically collective, "
                       "Not collective)")
        check_parameters(tree, page)
        if re.search(r"\b(PetscCheck|SETERRQ|PetscCheckFalse)\s*\(",
                     page.body) and not re.search(r"^\s+Errors?:", page.text, re.M):
            tree.error(*where, f"{page.name} raises errors, but has no section \"Errors:\"")
    if not re.search(r"^\s+Level: (beginner|intermediate|advanced|developer)\s*$", page.text, re.M):
        tree.error(*where, f"{page.name}: no \"Level: beginner\" (intermediate, advanced, developer)")
    if not page.seealso.strip():
        tree.error(*where, f"{page.name}: no \".seealso:\"")
    for name in re.findall(r"[\w-]+", page.seealso):
        if name[0] != "-" and not known(name):
            tree.error(*where, f"{page.name}: see also {name}, which does not exist")
    for name in set(re.findall(r"\b((?:Slip|TSBathe|TSAdaptRL|MatSlip|MatCreateSlip|SNESSlip)\w*)\(\)", page.text)):
        if not known(name):
            tree.error(*where, f"{page.name}: mentions {name}(), which does not exist")


def check(source, petsc=None):
    """The tree with its list of errors."""
    tree = Tree(source)
    foreign = set()
    for path in glob.glob(f"{petsc}/**/*.h", recursive=True) if petsc else []:
        with open(path, encoding="utf-8", errors="replace") as f:
            foreign |= set(re.findall(r"\w+", f.read()))

    def known(name):
        if name in tree.defined or name in tree.types or name in tree.pages:
            return True
        return name in foreign if foreign else bool(FOREIGN.match(name)) and "Slip" not in name and "SLIP" not in name

    for name, page in tree.pages.items():
        check_page(tree, page, known)
    for name, (path, line, _) in tree.declared.items():
        if name not in tree.pages:
            tree.error(path, line, f"{name}() is public, but has no manual page")
    return tree


STYLE = """body { font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222 }
pre { background: #f4f4f4; padding: .6em; overflow-x: auto }
code { font-size: 95% } a { color: #05a; text-decoration: none }
td { vertical-align: top; padding: .15em .8em .15em 0 } h2 { border-bottom: 1px solid #ccc; margin-top: 1.6em }"""


def write_page(folder, name, title, body):
    with open(os.path.join(folder, name + ".html"), "w", encoding="utf-8") as f:
        f.write(f"<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{title}</title>\n"
                f"<style>{STYLE}</style>\n{body}\n</html>\n")


def link(tree, text):
    """Text with every name that has a page of its own as a link."""
    def named(match):
        name = match[0]
        return f'<a href="{name}.html">{name}</a>' if name in tree.pages or name in tree.types else name
    return re.sub(r"\w+", named, html.escape(text.replace("`", "")))


def page_html(tree, page):
    out = ["<p><a href=\"index.html\">SlipStep's "
           f"reference</a></p><h1>{page.name}</h1><p>{link(tree, page.summary)}</p>"]
    if page.prototype:
        header = tree.declared.get(page.name)
        include = f"#include &lt;{os.path.basename(header[0])}&gt;\n" if header else ""
        prototype = page.prototype
        out.append(f"<pre>{include}{link(tree, prototype)};</pre><p>")
    mode = None  # what is open: a table, or preformatted text
    for text in page.lines[1:]:
        heading = re.match(r"\s+([A-Z][\w/ ]*(?: \([^)]*\))?:)\s*$", text)
        item = re.match(r"[+.-]\s+(\S.*?)\s+-\s+(\S.*)", text)
        if mode == "table" and not item and (not text.strip() or heading or text.startswith(".")):
            out.append("</td></tr></table>")
            mode = None
        if text.startswith(".vb"):
            out.append("<pre>")
            mode = "pre"
        elif text.startswith(".ve"):
            out.append("</pre>")
            mode = None
        elif text.startswith(".seealso"):
            out.append("<h2>See also</h2><p>" + link(tree, text.split(":", 1)[-1]))
        elif mode == "pre":
            out.append(html.escape(text))
        elif heading:
            out.append(f"<h2>{heading[1].rstrip(':')}</h2><p>")
        elif item:
            out.append(("</td></tr>" if mode == "table" else "<table>")
                       + f"<tr><td><code>{html.escape(item[1])}</code></td><td>{link(tree, item[2])}")
            mode = "table"
        elif text.strip():
            out.append(link(tree, text.strip()))
        else:
            out.append("</p><p>")
    where = os.path.relpath(page.path, tree.source)
    return "\n".join(out) + f"</p><hr><p>{html.escape(where)}</p>"


def write(tree, folder):
    """One page each, and an index by room."""
    os.makedirs(folder, exist_ok=True)
    for old in glob.glob(os.path.join(folder, "*.html")):
        os.remove(old)
    rooms = {}
    for name, page in sorted(tree.pages.items()):
        write_page(folder, name, name, page_html(tree, page))
        room = "src/core" if page.kind == "core" else os.path.relpath(os.path.dirname(page.path), tree.source)
        rooms.setdefault(room, []).append((name, page.summary))
    types = []
    for name, (path, _, comment, declaration) in sorted(tree.types.items()):
        comment = re.sub(r"\s+", " ", comment).strip()
        types.append((name, comment[:120] + ("..." if len(comment) > 120 else "")))
        write_page(folder, name, name,
                   f"<p><a href=\"index.html\">SlipStep's reference</a></p><h1>{name}</h1><p>{link(tree, comment)}</p>"
                   f"<pre>#include &lt;{os.path.basename(path)}&gt;\n\n{link(tree, declaration)}</pre>")
    body = ["<h1>SlipStep's reference</h1>"]
    for room in sorted(rooms) + ["Types"]:
        body.append(f"<h2>{room}</h2><table>")
        for name, summary in rooms.get(room, types):
            body.append("<tr><td><a "
                        f"href=\"{name}.html\">{name}</a></td><td>{html.escape(summary.replace('`', ''))}</td></tr>")
        body.append("</table>")
    write_page(folder, "index", "SlipStep's reference", "\n".join(body))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--source", default=os.path.dirname(HERE), help="top of the source tree")
    parser.add_argument("--output", default="", help="folder of the pages; empty: only check")
    parser.add_argument("--petsc", default="", help="folders of PETSc's headers, where see-also names are looked up")
    args = parser.parse_args()
    tree = check(args.source, args.petsc)
    for text in tree.errors:
        print(text, file=sys.stderr)
    print(f"{len(tree.pages)} manual pages and {len(tree.types)} types, {len(tree.errors)} errors")
    if not tree.errors and args.output:
        write(tree, args.output)
        print(f"written to {os.path.join(args.output, 'index.html')}")
    return 1 if tree.errors else 0


if __name__ == "__main__":
    sys.exit(main())
