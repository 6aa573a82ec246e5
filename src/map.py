#!/usr/bin/env python3
"""The rooms of src/, which of them may call which, and the picture of them.

    src/map.py                 draws src/map.svg anew from the sources
    src/map.py --lines         lines of code by room

ORDER is the one place where the order of the rooms is written: a room may call and include those above it in the list,
no others. tests/python/test_layers.py holds the build to it (by its symbol tables) and the picture to the sources.
"""
import argparse
import collections
import glob
import html
import os
import re
import sys

SRC = os.path.dirname(os.path.abspath(__file__))

# room, what it holds in a few words, and its place in the picture: row from the bottom, and which part of the row
ORDER = [
    ("core", "rules on arrays: friction, cone, steps, controllers; for every room above", 0, (0, 1)),
    ("sys", "errors, logging, HDF5, composed data; for every room above", 1, (0, 1)),
    ("elasticity", "dislocations in closed form", 2, (.3, .7)),
    ("device", "a graphics card", 2, (.76, .94)),
    ("mat/common", "dense helpers, memory, notes", 3, (.06, .94)),
    ("mat/grid", "FFT, Toeplitz, circulants", 4, (.06, .48)),
    ("mat/cells", "irregular cells, clusters", 4, (.52, .94)),
    ("mat/hmatrix", "hierarchical stiffness", 5, (.52, .94)),
    ("mat/viscosity", "square roots: exact, spectral, Lanczos", 6, (.06, .48)),
    ("mat/stage", "stage operator, preconditioner", 7, (.06, .41)),
    ("mat/interface", "K and H by name", 8, (.06, .94)),
    ("elastic", "the medium", 11, (.44, .6)),
    ("snes", "solvers of the constraint", 9, (.02, .25)),
    ("ts", "the integrators", 10, (.02, .25)),
    ("policy", "networks in files", 9, (.63, .96)),
    ("adapt", "step-size controllers, observations", 10, (.63, .96)),
    ("models", "circuit, sliding mode", 11, (.02, .25)),
    ("mesh", "cells of a fault", 11, (.28, .42)),
    ("fluid", "diffusion in the cells", 12, (.02, .25)),
    ("run/output", "the output of any run", 11, (.63, .96)),
    ("fault/setup", "parameters, features, names", 12, (.28, .62)),
    ("fault/loads", "loads, friction of the cells", 13, (.28, .62)),
    ("fault/state", "layout, what is known of a state", 14, (.28, .62)),
    ("fault/medium", "cells' fields, K and H", 15, (.68, .98)),
    ("fault/stage", "constraint, balance, kicks", 16, (.28, .62)),
    ("fault/observe", "sums over the cells", 17, (.28, .62)),
    ("fault/steps", "the TS of a fault", 18, (.42, .64)),
    ("run/file", "output, fields, ParaView", 19, (.02, .3)),
    ("run/catalogue", "events", 20, (.02, .3)),
    ("run/stations", "points of fault and ground", 20, (.28, .54)),
    ("run/watch", "progress, warnings, errors", 20, (.58, .88)),
    ("run", "a fault's life, options, observers", 21, (.02, .98)),
    ("run/checkpoint", "saving and stopping", 22, (.02, .98)),
    ("package", "has every room register its types", 23, (0, 1)),
]
ROOMS = [room for room, *_ in ORDER]
# Headers that are not named after their room; the others are slip<room>.h, without slashes, and slipfault<part>.h.
HEADERS = {"slipcompat.h": "core", "slipbuild.h": "core", "sliph5.h": "sys", "slipclock.h": "ts", "slipbathe.h": "ts",
           "slipstate.h": "sys", "slipwork.h": "sys", "slipmat.h": "mat/common", "slipcells.h": "mat/cells",
           "slipstep.h": "package", "rooms.h": "package",
           "slipblas.h": "sys", "slipdipping.h": "elasticity", "sliptriangle.h": "elasticity",
           "sliptrianglelanes.h": "elasticity", "slipgmsh.h": "mesh",
           "sliplanes.h": "mat/grid", "slipwaves.h": "elasticity", "slipwavespace.h": "elastic",
           "slipdeviceopencl.h": "device", "sliploops.h": "device", "slipformulas.h": "core",
           "slipoutput.h": "run/output", "sliprun.h": "run/file",
           "sliprunfiles.h": "run/file", "slipfaultloads.h": "fault/setup"}
EVERYWHERE = ("core", "sys", "package")  # bars in the picture, without arrows: all rooms may use the first two


def read(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def code_of(text):
    """Without comments and strings."""
    return re.sub(r'/\*.*?\*/|"(?:\\.|[^"\\\n])*"', " ", text, flags=re.S)


def header_room(name):
    """The room of one of our headers, None for those of others."""
    base = os.path.basename(name)
    rooms = {"slip" + room.replace("/", "") + ".h": room for room in ROOMS}
    return HEADERS.get(base) or rooms.get(base) or ("fault/setup" if base.startswith("slipfault") else None)


class Sources:
    """Which file defines, calls and includes what."""

    def __init__(self, src=SRC):
        self.files = {}  # "ts/bathe.c" -> its room
        self.lines, self.includes = collections.Counter(), []  # includes: (file, header)
        self.calls = collections.defaultdict(set)  # (file, file) -> names
        defined, used = {}, {}
        for path in sorted(glob.glob(f"{src}/**/*.c", recursive=True)):
            file = os.path.relpath(path, src)
            text = read(path)
            self.files[file] = os.path.dirname(file)
            self.lines[os.path.dirname(file)] += text.count("\n")
            self.includes += [(file, name) for name in re.findall(r'#include\s+[<"]([^>"]+)[>"]', text)]
            code = code_of(text)
            for match in re.finditer(
                r"^(?!static|typedef|extern|return|#)\w[\w \t*]*?\b(\w+)(\(|(?:\[[^\]]*\])*\s*(?:=|;|,))", code, re.M):
                if match[2] != "(" or re.match(r"[^;{]*\)\s*\{", code[match.end() - 1:]):
                    for name in re.findall(r"\w+", match[0])[-1:] if match[2][0] != "," else re.findall(
                        r"\w+", code[match.start():code.index(";", match.start())])[1:]:
                        defined[name] = file
            used[file] = set(re.findall(r"\b\w+\b", code))
        for file, names in used.items():
            for name in names & set(defined):
                if defined[name] != file:
                    self.calls[file, defined[name]].add(name)

    def room_calls(self):
        """(room, room) -> names called"""
        rooms = collections.defaultdict(set)
        for (a, b), names in self.calls.items():
            if self.files[a] != self.files[b]:
                rooms[self.files[a], self.files[b]] |= names
        return rooms


def upward(calls, room_of):
    """Lines about calls (file, file) -> names that run upward in ORDER."""
    found = []
    for (a, b), names in sorted(calls.items()):
        if ROOMS.index(room_of(a)) < ROOMS.index(room_of(b)):
            found.append(f"{a} calls {', '.join(sorted(names))} of {b}, which is above it")
    return found


def upward_includes(includes, room_of):
    found = []
    for file, name in includes:
        room = header_room(name)
        if room and ROOMS.index(room_of(file)) < ROOMS.index(room):
            found.append(f"{file} includes {name} of {room}, which is above it")
        if not room and (name.startswith("slipstep/") or re.match(r"slip\w+\.h$", name)):
            found.append(f"{file} includes {name}, which is of no room")
    return found


def circles(calls):
    """Lists of files each of which needs, by way of others, itself (Tarjan's strongly connected components)."""
    follow = collections.defaultdict(list)
    for a, b in calls:
        follow[a].append(b)
    index, low, stack, found = {}, {}, [], []

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in follow[v]:
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            circle = stack[stack.index(v):]
            del stack[stack.index(v):]
            if len(circle) > 1:
                found.append(sorted(circle))

    sys.setrecursionlimit(10000)
    for v in sorted(follow):
        if v not in index:
            visit(v)
    return sorted(found)


def reduced(edges):
    """Without the edges that a path of others implies."""
    follow = collections.defaultdict(set)
    for a, b in edges:
        follow[a].add(b)

    def reaches(a, b, seen):
        return any(c == b or c not in seen and reaches(c, b, seen | {c}) for c in follow[a])

    return sorted((a, b) for a, b in edges if not any(c != b and reaches(c, b, {c}) for c in follow[a]))


# ---- the picture ----

WIDTH, ROW, HEIGHT, MARGIN = 860, 66, 42, 14


def box(row, part):
    """x, y, width, height; the rooms of mat leave space for the frame around them"""
    top = MARGIN + ROW * (max(r for _, _, r, _ in ORDER) + 1 - row) + (26 if row < 9 else 0) + (20 if row < 3 else 0)
    return MARGIN + part[0] * WIDTH, top, (part[1] - part[0]) * WIDTH, HEIGHT


def free_part(places, a, b):
    """The widest part of the overlap of two boxes, sideways, with no other box between them; None where there is
    none"""
    (xa, ya, wa, ha), (xb, yb, wb, _) = places[a], places[b]
    parts = [(max(xa, xb), min(xa + wa, xb + wb))]
    for room, (x, y, w, h) in places.items():
        if room not in (a, b) and ya + ha <= y and y + h <= yb:
            parts = [part for left, right in parts for part in ((left, min(right, x)), (max(left, x + w), right))]
    parts = [(left, right) for left, right in parts if right - left > 20]
    return max(parts, key=lambda part: part[1] - part[0]) if parts else None


def svg(sources):
    """The rooms as boxes, bottom to top, with arrows to those that they call; arrows that others imply are left out."""
    present = [entry for entry in ORDER if sources.lines[entry[0]]]
    places = {room: box(row, part) for room, _, row, part in present}
    outer = lambda room: "mat" if room.startswith("mat/") else room
    down = [(a, b) for a, b in sources.room_calls() if ROOMS.index(a) > ROOMS.index(b) and a not in EVERYWHERE
            and b not in EVERYWHERE]
    wings = reduced([(a, b) for a, b in down if a.startswith("mat/") and b.startswith("mat/")])
    rooms = reduced({(outer(a), outer(b)) for a, b in down if outer(a) != outer(b)})
    inside = [places[room] for room in places if room.startswith("mat/")]
    top, bottom = min(b[1] for b in inside) - 24, max(b[1] + b[3] for b in inside) + 12
    places["mat"] = MARGIN + .02 * WIDTH, top, .96 * WIDTH, bottom - top
    height = max(b[1] + b[3] for b in places.values()) + MARGIN
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH + 2 * MARGIN} {height:.0f}" '
           f'width="{WIDTH + 2 * MARGIN}" '
           f'height="{height:.0f}" font-family="Helvetica, Arial, sans-serif" font-size="13">',
           '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
           '<path d="M0,0 L8,4 L0,8 z" fill="#456"/></marker></defs>',
           '<rect width="100%" height="100%" fill="white"/>']

    def rectangle(place, fill, dash=""):
        x, y, w, h = place
        out.append(f'<rect x="{x:.0f}" y="{y:.0f}" width="{w:.0f}" height="{h:.0f}" rx="5" fill="{fill}" '
                   f'stroke="#456"{dash}/>')

    def write(x, y, text, more=""):
        out.append(f'<text x="{x:.0f}" y="{y:.0f}"{more}>{html.escape(text)}</text>')

    x, y, w, h = box(max(r for _, _, r, _ in ORDER) + 1, (0, 1))
    rectangle((x, y, w, h), "white", ' stroke-dasharray="5 4"')
    write(x + w / 2, y + h / 2 + 5, "programs: examples, training, your own; they see public headers only",
          ' text-anchor="middle"')
    rectangle(places["mat"], "#f3f6f9")
    write(places["mat"][0] + 10, places["mat"][1] + 17, "mat", ' font-weight="bold"')
    for room, words, _, _ in present:
        x, y, w, h = places[room]
        rectangle(places[room], "#e3e9ef" if room in EVERYWHERE else "#fff6dc" if not room.startswith("mat/")
                  else "white")
        write(x + 9, y + 17, room, ' font-weight="bold"')
        write(x + 9, y + 34, words, ' font-size="12"')
        write(x + w - 8, y + 17, f"{max(round(sources.lines[room], -2), 100):,} lines",
              ' class="lines" text-anchor="end" font-size="11" fill="#567"')
    # Arrows run straight down where they can, those between the same sides each at a place of its own.
    arrows = rooms + wings
    parts = {edge: free_part(places, *edge) for edge in arrows}
    for a, b in arrows:
        (xa, ya, wa, ha), (xb, yb, wb, _) = places[a], places[b]
        if parts[a, b]:
            lanes = [e for e in arrows if parts[e] == parts[a, b] and (e[0] == a or e[1] == b)]
            left, right = parts[a, b]
            start = end = left + (right - left) * (lanes.index((a, b)) + 1) / (len(lanes) + 1)
            high, low = ya + ha, yb - 1
        elif ya == yb:  # neighbours
            start, end = (xa + wa, xb - 1) if xa < xb else (xa, xb + wb + 1)
            high = low = ya + ha / 2
        else:
            start, end = (xa + wa - 30, xb + 30) if xa < xb else (xa + 30, xb + wb - 30)
            high, low = ya + ha, yb - 1
        out.append(f'<path d="M{start:.0f},{high:.0f} L{end:.0f},{low:.0f}" stroke="#456" stroke-width="1.3" '
                   'fill="none" '
                   f'marker-end="url(#tip)"><title>{a} calls {b}</title></path>')
    return "\n".join(out + ["</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--lines", action="store_true", help="lines of code by room only")
    parser.add_argument("--output", default=os.path.join(SRC, "map.svg"), help="where to draw")
    args = parser.parse_args()
    sources = Sources()
    if args.lines:
        for room in ROOMS:
            print(f"{sources.lines[room]:6d}  {room}")
        print(f"{sum(sources.lines.values()):6d}  in all")
        return 0
    with open(args.output, "w", encoding="utf-8") as f:
        f.write(svg(sources))
    return 0


if __name__ == "__main__":
    sys.exit(main())
