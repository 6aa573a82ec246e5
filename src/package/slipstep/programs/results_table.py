"""Write the tables of RESULTS.md from the file of evaluate, so that none of their numbers is typed.

    slipstep results-table output/study.h5 [--page output/RESULTS.md]

The page keeps its text; what stands between <!-- table NAME --> and <!-- end NAME --> is replaced.
"""

import argparse
import os
import re

import numpy as np
from ..errors import OutputError
from ..results.files import replacing
from ..results.study import Study, cheapest

DEFAULT, PUBLISHED = ("embedded", "trapezoidal"), ("doubling", "implicit")
TREATMENTS = (DEFAULT, ("doubling", "trapezoidal"), ("embedded", "implicit"), PUBLISHED)
MEASURES = (("final_error",), ("history_error",), ("final_error", "history_error"))
NO = "–"
SWEEP = "_alpha"  # in the names of the sweep's policies


def markdown(heads, rows):
    """A table; without rows it says so."""
    if not rows:
        return "No such runs in the file."
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def number(value, digits=3):
    """Significant digits without an exponent where that is readable."""
    if value is None or not np.isfinite(value):
        return NO
    size = abs(value)
    if size == 0 or 1e-3 <= size < 10**digits - 0.5:
        return f"{value:.{digits}g}"
    return f"{value:.0f}" if 1 <= size < 1e6 else f"{value:.1e}"


def percent(value):
    return NO if value is None or not np.isfinite(value) else f"{number(100 * value, 2)} %"


def mean_percent(errors):
    """Arithmetic mean of errors."""
    return percent(float(np.mean(errors))) if len(errors) else NO


def mean(values):
    """Geometric mean of ratios."""
    values = [value for value in values if np.isfinite(value) and value > 0]
    return float(np.exp(np.mean(np.log(values)))) if values else np.nan


def describe(cell):
    """How a classical run was made."""
    if cell["controller"] == "none":
        return f"{cell['steps']} constant steps, {cell['reaction']}"
    return f"{cell['controller']}, {cell['error']}, {cell['reaction']}, tolerance x {cell['tolerance']:g}"


# ---- equal accuracy ----

def classical(study, case):
    """Every classical run of a case, whatever its estimate, reaction and tolerance."""
    return [cell for cell in study.cells if cell.case == case and not cell.learned]


def tolerances(cells, controller):
    """How many tolerances a controller ran with."""
    return len({cell["tolerance"] for cell in cells if cell["controller"] == controller})


def swept(study, case):
    """Was each controller that is swept anywhere swept here? Else equal accuracy has no known cost."""
    cases = {cell.case for cell in study.cells}
    wanted = [name for name in ("heuristic", "pi", "dsp", "basic")
              if any(tolerances(classical(study, other), name) >= 4 for other in cases)]
    return bool(wanted) and all(tolerances(classical(study, case), name) >= 4 for name in wanted)


def advantage(study, cell, measures):
    """(solves of the cheapest classical run with at most the policy's errors over its own, that run), or None."""
    best = cheapest(classical(study, cell.case), {measure: cell.error(measure) for measure in measures})
    return (best["solves"] / cell["solves"], best) if best is not None else (np.nan, None)


def bound(study, cell, best):
    """"≤ " where no cheaper classical run was made at all: then the ratio may be smaller still."""
    return "≤ " if best is not None and best["solves"] <= min(c["solves"] for c in classical(study, cell.case)
                                                              if c.converged) else ""


def policy_cells(study, name, treatment, problem="fault"):
    return study.select(policy=name, problem=problem, error=treatment[0], reaction=treatment[1])


def equal_accuracy(study):
    """A row a policy, over all meshes and sizes with a sweep, for the default integrator."""
    rows = []
    for name in study.policies("fault"):
        cells = [cell for cell in policy_cells(study, name, DEFAULT) if swept(study, cell.case)]
        good = [cell for cell in cells if cell.converged]
        row = [f"`{name}`", f"{len(good)} of {len(cells)}"]
        if not good:
            rows.append(row + [NO] * 6)
            continue
        row.append(f"{min(c['solves'] for c in good)} to {max(c['solves'] for c in good)}")
        for measures in MEASURES:
            found = [(cell, *advantage(study, cell, measures)) for cell in good]
            known = [ratio for _, ratio, _ in found if np.isfinite(ratio)]
            mark = "≤ " if any(bound(study, cell, best) for cell, _, best in found) else ""
            spread = f" ({number(min(known), 2)} to {number(max(known), 2)})" if known else ""
            if len(measures) == 1:
                row.append(percent(float(np.mean([cell.error(measures[0]) for cell in good]))))
            row.append(f"**{mark}{number(mean(known), 2)}**{spread}")
        rows.append(row)
    return markdown(["policy", "converged", "its solves", "error of final slip (mean)",
                     "best classical / its solves at that error", "largest error over time (mean)", "at that error",
                     "at both errors"], [row[:8] for row in rows])


def equal_accuracy_cells(study):
    """Every policy but those of the sweep of alphas, fault and mesh: what the best classical run was."""
    rows = []
    for name in study.policies("fault"):
        if SWEEP in name:
            continue
        for cell in sorted(policy_cells(study, name, DEFAULT), key=lambda c: (c["size_km"], c["mesh"])):
            if not swept(study, cell.case):
                continue
            row = [f"`{name}`", f"{cell['size_km']:g} km, {cell['mesh']}²"]
            if not cell.converged:
                rows.append(row + ["failed"] + [NO] * 8)
                continue
            row.append(cell["solves"])
            for measures in MEASURES:
                ratio, best = advantage(study, cell, measures)
                if len(measures) == 1:
                    row.append(percent(cell.error(measures[0])))
                row += [bound(study, cell, best) + number(ratio, 2), f"{best['solves']}: {describe(best)}"
                        if best is not None else NO]
            rows.append(row)
    return markdown(["policy", "fault", "solves", "error of final slip", "ratio", "best classical run",
                     "largest error over time", "ratio", "best classical run", "ratio at both", "best classical run"],
                    rows)


def equal_accuracy_small(study):
    """Sliding mode and circuit by the L2 error of their history."""
    rows = []
    for problem in ("sliding_mode", "circuit"):
        for name in study.policies(problem):
            for cell in policy_cells(study, name, DEFAULT, problem):
                if not cell.converged:
                    rows.append([problem, f"`{name}`", "failed", NO, NO, NO])
                    continue
                ratio, best = advantage(study, cell, ("history_error",))
                rows.append([problem, f"`{name}`", cell["solves"], number(cell["history_error"], 2),
                             bound(study, cell, best) + number(ratio, 2),
                             f"{best['solves']}: {describe(best)}" if best is not None else NO])
    return markdown(["problem", "policy", "solves", "L2 error", "best classical / its solves", "best classical run"],
                    rows)


# ---- beside the published figures ----

# Riley et al. (2025): {size: (mean, range)} of heuristic/rl in run time, of pi/rl, mean slip error of rl.
STUDY_RATIOS = {3.0: ("11.0", "4 to 19.45"), 5.0: ("18", "10 to 35")}
STUDY_PI = "12.8 (5 to 30)"
STUDY_ERRORS = {3.0: "9.85 %", 5.0: "7.42 %"}
STUDY_STEPS = {"heuristic": {25: 163, 50: 230, 75: 330, 100: 401}, "rl": {25: 16, 50: 20, 75: 22, 100: 23}}
STUDY_SMALL = {
    "sliding_mode": {"pi": ("1.0", "1.9e-4"), "heuristic": ("0.90", "1.7e-4"), "tqc": ("0.44", "2.9e-4"),
                     "td3": ("0.43", "2.7e-4")},
    "circuit": {"pi": ("0.10", "0.38 %"), "heuristic": ("0.13", "0.44 %"), "tqc": ("0.01", "19.6 %"),
                "td3": ("1.0", "27.2 %")},
}


def main_sweep(study):
    """Name and members of the sweep over alpha that trained with TQC and has most members."""
    for name, members in study.sweeps().items():
        if any(cell.get("policy_algorithm") == "tqc" for cell in study.select(policy=tuple(members.values()))):
            return name, members
    return None, {}


def sweep_cells(study, size, treatment, alphas=(0.0, np.inf)):
    """Cells of the main sweep with alpha in a range."""
    _, members = main_sweep(study)
    return [cell for alpha, name in members.items() if alphas[0] <= alpha <= alphas[1]
            for cell in policy_cells(study, name, treatment) if cell["size_km"] == size]


def ratios(study, cells, controller, quantity):
    """Cost of a classical controller at the reference tolerance over each policy's, same treatment."""
    out = []
    for cell in cells:
        other = study.one(problem="fault", size_km=cell["size_km"], mesh=cell["mesh"], controller=controller,
                          tolerance=1.0, error=cell["error"], reaction=cell["reaction"])
        if cell.converged and other is not None and other.converged and cell[quantity] > 0:
            out.append(other[quantity] / cell[quantity])
    return [ratio for ratio in out if np.isfinite(ratio)]


def errors_of(study, cells, controller):
    """Errors of a classical controller at the reference tolerance on the faults and meshes of policies' cells."""
    found = {cell.case: study.one(problem="fault", size_km=cell["size_km"], mesh=cell["mesh"], controller=controller,
                                  tolerance=1.0, error=cell["error"], reaction=cell["reaction"]) for cell in cells}
    return [other.error() for other in found.values() if other is not None and other.converged]


def spread(values):
    return f"{number(float(np.mean(values)))} ({number(min(values))} to {number(max(values))})" if values else NO


def published(study):
    """Speed-ups at the reference tolerance, each with its error."""
    rows = []
    for size in study.axis("size_km", problem="fault"):
        for treatment in (PUBLISHED, DEFAULT):
            cells = sweep_cells(study, size, treatment)
            done = [cell for cell in cells if cell.converged]
            if not cells:
                continue
            same = treatment == PUBLISHED
            rows.append([f"{size:g} km", ", ".join(treatment), f"{len(done)} of {len(cells)}",
                         spread(ratios(study, cells, "heuristic", "attempts")),
                         spread(ratios(study, cells, "heuristic", "solves")),
                         spread(ratios(study, cells, "heuristic", "cpu")),
                         " ".join(f"({text})" if k else text for k, text in enumerate(STUDY_RATIOS.get(size, (NO,))))
                         if same else NO, spread(ratios(study, cells, "pi", "cpu")),
                         STUDY_PI if same and size == 3.0 else NO, mean_percent([cell.error() for cell in done]),
                         STUDY_ERRORS.get(size, NO) if same else NO, mean_percent(errors_of(study, cells, "heuristic")),
                         mean_percent(errors_of(study, cells, "pi"))])
    return markdown(["fault", "estimate, reaction", "converged", "heuristic/rl, attempts", "heuristic/rl, solves",
                     "heuristic/rl, processor time", "study", "pi/rl, processor time",
                     "study", "slip error of rl", "study", "of heuristic", "of pi"], rows)


def requirements(study):
    """Mean error of alphas 1 to 8 with the default integrator; failures and guard rails over the whole sweep."""
    rows = []
    for size in study.axis("size_km", problem="fault"):
        for treatment in (DEFAULT, PUBLISHED):
            cells = sweep_cells(study, size, treatment)
            middle = [cell.error() for cell in sweep_cells(study, size, treatment, (1, 8)) if cell.converged]
            if cells:
                rows.append([f"{size:g} km", ", ".join(treatment), len(cells),
                             sum(not cell.converged for cell in cells), sum(cell["guarded"] > 0 for cell in cells),
                             mean_percent(middle), percent(max(middle)) if middle else NO])
    return markdown(["fault", "estimate, reaction", "cells of the sweep", "failed", "guard rails stepped in",
                     "slip error, alpha 1 to 8 (mean)", "(largest)"], rows)


def accepted_steps(study):
    """Accepted steps of the 3 km fault beside the published ones."""
    rows = []
    _, members = main_sweep(study)
    for mesh in study.axis("mesh", problem="fault", size_km=3.0):
        case = {"problem": "fault", "size_km": 3.0, "mesh": mesh}
        row = [f"{mesh} x {mesh}"]
        for controller, treatment in (("heuristic", PUBLISHED), ("heuristic", DEFAULT), ("rl", PUBLISHED),
                                      ("rl", DEFAULT)):
            if controller == "rl":
                cell = study.one(policy=members.get(2.0), error=treatment[0], reaction=treatment[1],
                                 **case) if 2.0 in members else None
            else:
                cell = study.one(controller=controller, tolerance=1.0, error=treatment[0], reaction=treatment[1],
                                 **case)
            row.append(NO if cell is None else "failed" if not cell.converged
                       else f"{cell['accepted']} ({percent(cell.error())})")
            if treatment == PUBLISHED:
                row.append(STUDY_STEPS[controller].get(mesh, NO))
        rows.append(row)
    return markdown(["3 km fault", "heuristic, doubling, implicit", "study", "heuristic, default",
                     "rl alpha 2, doubling, implicit", "study", "rl alpha 2, default"], rows)


def small(study):
    """Sliding mode and circuit at the reference tolerance beside the published figures."""
    rows = []
    for problem, theirs in STUDY_SMALL.items():
        for treatment in (DEFAULT, PUBLISHED):
            cells = [c for c in study.select(problem=problem, error=treatment[0], reaction=treatment[1])
                     if c.learned or (c["tolerance"] == 1 and c["controller"] in ("pi", "heuristic", "dsp"))]
            slowest = max((c["wall_min"] for c in cells if c.converged), default=np.nan)
            for cell in cells:
                key = cell.get("policy_algorithm") if cell.learned else cell["controller"]
                runtime, error = theirs.get(key, (NO, NO)) if treatment == PUBLISHED else (NO, NO)
                if not cell.converged:
                    rows.append([problem, ", ".join(treatment), f"`{cell.name}`", "failed", NO, runtime, NO, error])
                    continue
                scale = "" if problem == "sliding_mode" else " %"
                value = cell["l2_error"] * (100 if scale else 1)
                rows.append([problem, ", ".join(treatment), f"`{cell.name}`" if cell.learned else cell.name,
                             cell["solves"], number(cell["wall_min"] / slowest, 2), runtime, number(value, 2) + scale,
                             error])
    return markdown(["problem", "estimate, reaction", "controller", "solves", "run time / slowest", "study", "L2 error",
                     "study"], rows)


def cost(study):
    """What a solve costs at the reference tolerance, default integrator, without the sweep of alphas."""
    rows = []
    for case in sorted({cell.case for cell in study.select(problem="fault", tolerance=1.0)}):
        for cell in study.select(problem="fault", tolerance=1.0, error=DEFAULT[0], reaction=DEFAULT[1], converged=1):
            if cell.case == case and SWEEP not in cell.name:
                rows.append([case.replace("_", " "), f"`{cell.name}`" if cell.learned else cell.name, cell["solves"],
                             number(cell["newton_iterations"] / cell["solves"], 2),
                             number(cell["linear_iterations"] / cell["solves"], 2),
                             number(1e3 * cell["cpu"] / cell["solves"], 2), number(cell["wall"], 2),
                             number(cell["wall_min"], 2) + " to " + number(cell["wall_max"], 2)])
    return markdown(["case", "controller", "solves", "Newton iterations a solve", "linear iterations a solve",
                     "processor time a solve (ms)", "wall time (s, median)", "range"], rows)


def references(study):
    """The references and how far the run of half as many steps is from them."""
    rows = []
    for case, attributes in sorted(study.references.items(),
                                   key=lambda item: (item[1]["problem"], item[1]["size_km"], item[1]["mesh"])):
        final = f"{attributes['final']:.5f}" if attributes["problem"] == "fault" else NO
        known = attributes["steps"] > 0
        rows.append([case.replace("_", " "), attributes["kind"], attributes["steps"] if known else NO, final,
                     f"{abs(attributes['self_final']):.1e}" if known else NO, f"{attributes['self_max']:.1e}" if known
                     else NO])
    return markdown(["case", "kind", "steps", "final mean slip (m)", "half as many steps: at the end", "at most"], rows)


def processor_time(study, case, cells):
    """What all runs of a case took with its reference [s]; of very short ones the wall time."""
    runs = sum(cell["repetitions"] * (cell["cpu"] if cell["cpu"] > 0 else cell["wall"]) for cell in cells)
    return runs + study.references.get(case, {}).get("wall", 0)


def contents(study):
    """What was run, and what it took."""
    rows, total = [], {}
    for case in sorted({cell.case for cell in study.cells}, key=lambda name: (len(name), name)):
        cells = [cell for cell in study.cells if cell.case == case]
        failed = [cell for cell in cells if not cell.converged]
        time = processor_time(study, case, cells)
        part = "up to 50 x 50" if cells[0]["mesh"] <= 50 else "finer"
        total[part] = total.get(part, 0) + time
        swept_by = [f"{', '.join(key)}: {count}" for key in TREATMENTS
                    if (count := sum(not c.learned and not c["steps"] and c.treatment == key for c in cells))]
        rows.append([case.replace("_", " "), sum(cell.learned for cell in cells), "; ".join(swept_by),
                     sum(cell["steps"] > 0 for cell in cells), len(failed), sum(cell["guarded"] > 0 for cell in cells),
                     f"{time:.0f}"])
    rows += [[f"**all {name}**"] + [""] * 5 + [f"**{time:.0f}** ({number(time / 60)} min)"]
             for name, time in total.items()]
    return markdown(["case", "cells of policies", "cells of tolerance-driven controllers", "of constant steps",
                     "failed", "guard rails stepped in", "processor time of all runs, reference included (s)"], rows)


def failures(study):
    """Every cell that did not converge, and why."""
    rows = [[cell.case.replace("_", " "), f"`{cell.name}`", ", ".join(cell.treatment), f"{cell['tolerance']:g}",
             cell["reason"].replace("|", "\\|")]
            for cell in study.cells if not cell.converged]
    return markdown(["case", "controller", "estimate, reaction", "tolerance x", "reason"],
                    rows) if rows else "No cell failed."


TABLES = {"equal_accuracy": equal_accuracy, "equal_accuracy_small": equal_accuracy_small, "published": published,
          "requirements": requirements, "accepted_steps": accepted_steps, "small": small,
          "equal_accuracy_cells": equal_accuracy_cells,
          "references": references, "cost": cost, "contents": contents, "failures": failures}


def fill(text, study, page):
    """The page with its tables replaced."""
    names = re.findall(r"<!-- table (\w+) -->", text)
    unknown = [name for name in names if name not in TABLES]
    if unknown or not names:
        raise OutputError(f"{page}: " + (f"unknown table {unknown[0]}" if unknown else "no <!-- table NAME --> in it")
                          + f", expected some of {', '.join(TABLES)}")
    for name in names:
        pattern = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end {name} -->)", re.S)
        if not pattern.search(text):
            raise OutputError(f"{page}: <!-- end {name} --> is missing")
        table = TABLES[name](study)
        text = pattern.sub(lambda match: match.group(1) + table + "\n" + match.group(2), text)
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("study", metavar="FILE", help="output file of evaluate")
    parser.add_argument("--page", metavar="MD", default=os.path.join("output", "RESULTS.md"),
                        help="page to fill, default RESULTS.md beside this script")
    options = parser.parse_args()
    study = Study(options.study)
    study.warn()
    with open(options.page, encoding="utf-8") as file:
        text = file.read()
    text = fill(text, study, options.page)
    with replacing(options.page) as part, open(part, "w", encoding="utf-8") as file:
        file.write(text)
    print(f"Tables: {options.page}")
