"""Draw every figure of the study from the file of evaluate.

    slipstep plot-study output/study.h5 [--figures output/figures] [--only history,steps]

What the file does not hold is shown as missing.
"""

import argparse
import os

import numpy as np
from ..plots.heat import Table, colours, draw_heat, error_of, error_ratio, ratio_to
from ..plots.panels import RED, REFERENCE, log_scale, plt, save, use_style
from ..results.study import CLASSICAL, Study, envelope, family

DEFAULT, PUBLISHED = ("embedded", "trapezoidal"), ("doubling", "implicit")
COLOURS = {"heuristic": "#e08a00", "pi": "#2c8a4b", "dsp": "#8a4fa3", "basic": "#8c6d46", "none": "#707070"}
BLUES = ("#0062a5", "#4aa3df", "#00a0a0", "#b0307a", "#1b2a6b", "#7a9a01", "#c0504d", "#555555")
# of policies outside sweeps
SINGLE = ("#b0307a", "#00a0a0", "#c0504d", "#d0b000", "#7a9a01", "#8c564b", "#1b2a6b", "#555555")
TREATMENTS = {DEFAULT: "-", ("doubling", "trapezoidal"): "--", ("embedded", "implicit"): ":", PUBLISHED: "-."}
MARKERS = {DEFAULT: "o", ("doubling", "trapezoidal"): "s", ("embedded", "implicit"): "^", PUBLISHED: "D"}


def empty(axes, text):
    """Axes without data say so."""
    axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes, color="#888888")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)


def short_names(names):
    """Without what all of them begin with, up to a word's end."""
    prefix = os.path.commonprefix(names) if len(names) > 1 else ""
    prefix = prefix[: max(prefix.rfind("_"), prefix.rfind("-")) + 1]
    return [name[len(prefix):] or name for name in names]


def shown_policies(study, problem):
    """Few policies for crowded panels: of sweeps that nearest to alpha = 2, and those outside, not transferred."""
    sweeps = study.sweeps(problem)
    chosen = [min(members, key=lambda alpha: abs(np.log(alpha / 2))) for members in sweeps.values()]
    middle = [members[alpha] for members, alpha in zip(sweeps.values(), chosen)]
    moved = [name for name, _ in transfers(study)]
    return [name for name in study.policies(problem)
            if name in middle or (family(name) not in sweeps and "@" not in name and name not in moved)]


def finest(study, size, wanted=50):
    """The mesh of a size to show in detail: the wanted one if it is there, or the finest."""
    meshes = study.axis("mesh", problem="fault", size_km=size)
    return wanted if wanted in meshes else meshes[-1] if meshes else None


def richest(study, size):
    """The mesh of a size with most runs, that of the complete sweep; the finest of several."""
    meshes = [cell["mesh"] for cell in study.select(problem="fault", size_km=size)]
    return max(sorted(set(meshes), reverse=True), key=meshes.count) if meshes else None


# ---- sliding mode and circuit: states and reaction against time ----

def small_runs(study, problem):
    """(label, colour, cell) of every controller at the reference tolerance, default integrator."""
    error, reaction = DEFAULT
    runs = []
    for controller in CLASSICAL[:3]:
        cell = study.one(problem=problem, controller=controller, tolerance=1.0, error=error, reaction=reaction)
        runs.append((controller, COLOURS[controller], cell))
    for colour, name in zip(BLUES, shown_policies(study, problem)):
        runs.append((name, colour, study.one(problem=problem, policy=name, error=error, reaction=reaction)))
    return [(label, colour, cell) for label, colour, cell in runs if cell is not None]


def figure_states(study, problem):
    """Each state and the reaction; every accepted step is marked."""
    runs, known = small_runs(study, problem), problem in study.references
    reference = study.reference(problem) if known else {}
    names = [name for name in reference if name != "time"] or ["state"]
    canvas, panels = plt.subplots(len(names), 1, figsize=(9, 2.2 * len(names) + 1), layout="constrained", sharex=True,
                                  squeeze=False)
    for axes, name in zip(panels[:, 0], names):
        if not known or not runs:
            empty(axes, f"no runs of {problem}")
            continue
        axes.plot(reference["time"], reference[name], color=REFERENCE, linewidth=3, alpha=0.7, label="reference")
        for label, colour, cell in runs:
            if not cell.converged:
                axes.plot([], [], color=colour, label=f"{label}: failed")
                continue
            series = cell.series()
            axes.plot(series["time"], series[name], color=colour, marker=".", markersize=3 if cell["accepted"] > 200
                      else 5, linewidth=0.8, label=f"{label}: {cell['solves']} solves, L2 error {cell['l2_error']:.2g}")
        axes.set_ylabel(name)
    panels[-1, 0].set_xlabel("time (s)")
    panels[0, 0].set_title(f"{problem}: states and reaction at the reference tolerance")
    panels[0, 0].legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return canvas


# ---- heat maps ----

def heat_figure(study, treatment, columns, title):
    """columns: (title, value, cmap, group): maps of one group share their colours. A row of maps for each size."""
    sizes, meshes, policies = study.axis("size_km",
                                         problem="fault"), study.axis("mesh", problem="fault"), study.policies("fault")
    height = 1.4 + max(len(sizes), 1) * (0.9 + 0.24 * max(len(policies), 2))
    canvas, panels = plt.subplots(max(len(sizes), 1), len(columns), figsize=(11.5, height), layout="constrained",
                                  squeeze=False)
    if not policies or not meshes:
        for axes in panels.flat:
            empty(axes, "no policies")
        return canvas
    tables = [[Table(policies, meshes).fill(study, size, treatment, value) for _, value, _, _ in columns]
              for size in sizes]
    norms = {group: colours([row[k] for row in tables for k in range(len(columns)) if columns[k][3] == group],
                            cmap.startswith("RdBu"))
             for _, _, cmap, group in columns}
    for i, size in enumerate(sizes):
        for k, (name, _, cmap, group) in enumerate(columns):
            draw_heat(panels[i, k], tables[i][k], norms[group], cmap, short_names(policies) if k == 0 else None,
                      f"{size:g} km: {name}")
    canvas.suptitle(title + "   (* guard rails stepped in, – not run)", fontsize=10)
    return canvas


def figure_ratios(study, treatment):
    columns = [("heuristic/rl, processor time", ratio_to("heuristic", "cpu"), "RdBu", 0),
               ("heuristic/rl, solves", ratio_to("heuristic", "solves"), "RdBu", 0),
               ("pi/rl, processor time", ratio_to("pi", "cpu"), "RdBu", 0),
               ("pi/rl, solves", ratio_to("pi", "solves"), "RdBu", 0)]
    return heat_figure(study, treatment, columns,
                       f"Cost ratios at the reference tolerance, {treatment[0]} estimate, {treatment[1]} "
                       "reaction; their errors are in the figure of errors")


def figure_errors(study, treatment):
    columns = [("final slip, error (%)", error_of("final_error"), "viridis", 0),
               ("history, largest (%)", error_of("history_error"), "viridis", 0),
               ("final slip, rl/heuristic", error_ratio("heuristic", "final_error"), "RdBu_r", 1),
               ("history, rl/heuristic", error_ratio("heuristic", "history_error"), "RdBu_r", 1)]
    return heat_figure(study, treatment, columns,
                       f"Errors of mean slip, {treatment[0]} estimate, {treatment[1]} reaction")


# ---- one fault in detail ----

def detail_runs(study, size, mesh, treatment=DEFAULT):
    """(label, colour, cell) of a few policies and of the classical controllers."""
    case = {"problem": "fault", "size_km": size, "mesh": mesh, "error": treatment[0], "reaction": treatment[1]}
    runs = [(name, colour, study.one(policy=name, **case))
            for colour, name in zip(BLUES, shown_policies(study, "fault")[:4])]
    runs += [(name, COLOURS[name], study.one(controller=name, tolerance=1.0, **case))
             for name in ("heuristic", "pi", "dsp")]
    return [run for run in runs if run[2] is not None]


def draw_attempts(axes, cell, colour):
    """Step of each attempt at its start: accepted, rejected by the controller, or failed to converge."""
    steps = cell.attempts()
    accepted, converged = steps["accepted"] > 0, steps["converged"] > 0
    axes.plot(steps["time"][accepted], steps["dt"][accepted], color=colour, marker=".", markersize=5, linewidth=0.8,
              drawstyle="steps-post")
    axes.plot(steps["time"][converged & ~accepted], steps["dt"][converged & ~accepted], linestyle="", marker="o",
              markersize=4, markerfacecolor="none", markeredgecolor=RED)
    axes.plot(steps["time"][~converged], steps["dt"][~converged], linestyle="", marker="x", markersize=6, color="black")
    log_scale(axes)


def figure_steps(study):
    """Step sizes of the 3 km fault, a panel a controller, with rejected attempts (red) and failed ones (crosses)."""
    size = 3.0
    mesh = finest(study, size)
    runs = detail_runs(study, size, mesh) if mesh else []
    rows = max((len(runs) + 1) // 2, 1)
    canvas, panels = plt.subplots(rows, 2, figsize=(10, 2.2 * rows + 0.4), layout="constrained", sharex=True,
                                  sharey=True, squeeze=False)
    for axes in panels.flat[len(runs):]:
        axes.set_axis_off()
    if not runs:
        panels[0, 0].text(0.5, 0.5, "no runs", ha="center", transform=panels[0, 0].transAxes)
    for axes, (label, colour, cell) in zip(panels.flat, runs):
        draw_attempts(axes, cell, colour)
        axes.set_title(f"{label}: {cell['accepted']} accepted, {cell['rejected']} rejected, {cell['failures']} "
                       "not converged", fontsize=8)
    for axes in panels[:, 0]:
        axes.set_ylabel("step (s)")
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    if runs:
        canvas.suptitle(f"{size:g} km, {mesh} x {mesh}, {DEFAULT[0]} estimate: rejected attempts red, not "
                        "converged crossed", fontsize=10)
    return canvas


def draw_plane(axes, values, times, size, norm, cmap, title):
    image = axes.imshow(values, extent=(times[0], times[-1], size, 0), aspect="auto", cmap=cmap, norm=norm,
                        interpolation="nearest")
    axes.figure.colorbar(image, ax=axes, pad=0.02, label="m/s")
    axes.set_title(title, fontsize=9)
    axes.set(xlabel="time (s)", ylabel="depth (km)")
    axes.grid(False)


def figure_history(study, size=3.0):
    """Mean slip rate and slip against time; slip rate over depth and time, and off from the reference."""
    mesh = finest(study, size)
    case = f"fault_{size:g}km_{mesh}x{mesh}"
    canvas, panels = plt.subplots(2, 3, figsize=(12, 6.6), layout="constrained")
    runs = [run for run in detail_runs(study, size, mesh) if run[2].converged] if case in study.references else []
    if not runs:
        for axes in panels.flat:
            empty(axes, "no runs")
        return canvas
    reference = study.reference(case)
    for axes, name, label in ((panels[0, 0], "mean_slip_rate", "mean slip rate (m/s)"),
                              (panels[0, 1], "mean_slip", "mean slip (m)")):
        axes.plot(reference["time"], reference[name], color=REFERENCE, linewidth=3, alpha=0.7, label="reference")
        for text, colour, cell in runs:
            series = cell.series()
            axes.plot(series["time"], series[name], color=colour, marker=".", markersize=4, linewidth=0.9,
                      label=f"{text}: {cell['solves']} solves, {100 * cell['final_error']:+.2g} %")
        axes.set(xlabel="time (s)", ylabel=label)
    handles, labels = panels[0, 1].get_legend_handles_labels()
    empty(panels[0, 2], "")
    panels[0, 2].set_axis_off()
    panels[0, 2].legend(handles, labels, loc="center left",
                        title="solves, error of the final slip").set_in_layout(False)
    times, exact = study.reference_profile(case)
    label, _, cell = runs[0]
    own, values = cell.profile()
    mine, top = np.array([np.interp(times, own, column) for column in values.T]), exact.max()
    draw_plane(panels[1, 0], exact.T, times, size, plt.Normalize(0, top), "magma",
               "slip rate along strike averaged: reference")
    draw_plane(panels[1, 1], mine, times, size, plt.Normalize(0, top), "magma", label)
    draw_plane(panels[1, 2], mine - exact.T, times, size, plt.Normalize(-top, top), "RdBu_r",
               f"{label} minus reference")
    canvas.suptitle(f"{size:g} km, {mesh} x {mesh}", fontsize=10)
    return canvas


# ---- work and precision ----

def draw_precision(axes, study, wanted, problem, measure, scale, width=1.0):
    """Error against solves: a line for each controller and treatment, a mark for each policy."""
    cells = study.select(converged=1, **wanted)
    classical = [cell for cell in cells if not cell.learned]
    for controller in CLASSICAL:
        for (error, reaction), style in TREATMENTS.items():
            error = "none" if controller == "none" else error
            if controller == "none" and style in ("--", "-."):
                continue
            own = sorted((c["solves"], scale * c.error(measure)) for c in classical
                         if c["controller"] == controller and c.treatment == (error, reaction))
            if own:
                axes.plot(*zip(*own), color=COLOURS[controller], linestyle=style, linewidth=width, marker=".",
                          markersize=3, alpha=0.8)
    solves, errors = envelope(classical, measure)
    if len(solves):
        axes.step(solves, scale * errors, where="post", color="#bbbbbb", linewidth=5, alpha=0.5, zorder=0)
    for colour, name in zip(policy_colours(study, problem), study.policies(problem)):
        for cell in (c for c in cells if c.get("policy") == name):
            axes.plot(cell["solves"], scale * cell.error(measure), color=colour,
                      marker=MARKERS.get(cell.treatment, "*"), markersize=6,
                      linestyle="", markeredgecolor="white", markeredgewidth=0.5, zorder=5)
    axes.set_xscale("log")
    axes.set_yscale("log")
    if not cells:
        empty(axes, "no runs")


def policy_colours(study, problem):
    """A shade by alpha within a family, a colour for each other policy."""
    names, sweeps, single, out = study.policies(problem), study.sweeps(problem), iter(SINGLE * 8), []
    for name in names:
        members = sorted(sweeps.get(family(name), {}).items())
        place = [policy for _, policy in members].index(name) if members and name in dict(members).values() else None
        maps = [plt.cm.Blues, plt.cm.Purples, plt.cm.Greens, plt.cm.Oranges]
        which = list(sweeps).index(family(name)) % 4 if place is not None else 0
        out.append(next(single) if place is None else maps[which](0.4 + 0.6 * place / max(len(members) - 1, 1)))
    return out


def precision_panels(rows, columns, width, height, sharex=False):
    """Panels and, in one cell beside all of them, axes for the legend."""
    canvas = plt.figure(figsize=(width * columns + 2.4, height), layout="constrained")
    grid = canvas.add_gridspec(rows, columns + 1, width_ratios=[1] * columns + [2.0 / width])
    panels = np.empty((rows, columns), dtype=object)
    for i, k in np.ndindex(rows, columns):
        panels[i, k] = canvas.add_subplot(grid[i, k], sharex=panels[0, 0] if sharex else None)
    beside = canvas.add_subplot(grid[:, -1])
    beside.set_axis_off()
    return canvas, panels, beside


def within(name, problem):
    """What tells a small problem's policies apart, for a shared legend: tqc; dial@0.1 of one with a dial."""
    rest = name.removeprefix(problem).lstrip("_")
    return rest if rest and not rest.startswith("@") else "dial" + rest


def precision_legend(axes, study, problem):
    """Colours for controllers and policies, lines and marks for treatments."""
    line = plt.Line2D
    handles = [line([], [], color=COLOURS[name], label=name if name != "none" else "constant steps")
               for name in CLASSICAL
               if study.select(problem=problem, controller=name)]
    handles += [line([], [], color="black", linestyle=style, marker=MARKERS[key], markersize=4,
                     label=f"{key[0]}, {key[1]}")
                for key, style in TREATMENTS.items()]
    handles += [line([], [], color="#bbbbbb", linewidth=5, alpha=0.5, label="best classical run")]
    handles += [line([], [], color=colour, marker="o", linestyle="",
                     label=name if problem == "fault" else within(name, problem))
                for colour, name in zip(policy_colours(study, problem), study.policies(problem))]
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0, fontsize=8)


def figure_precision(study):
    """The fault: error of the final slip above, the largest of the history below."""
    sizes = study.axis("size_km", problem="fault") or [3.0]
    canvas, panels, beside = precision_panels(2, len(sizes), 4.6, 8, sharex=True)
    for k, size in enumerate(sizes):
        mesh = richest(study, size)
        for axes, measure, label in ((panels[0, k], "final_error", "error of final mean slip (%)"),
                                     (panels[1, k], "history_error", "largest error of mean slip over time (%)")):
            draw_precision(axes, study, {"problem": "fault", "size_km": size, "mesh": mesh}, "fault", measure, 100)
            axes.set_title(f"{size:g} km, {mesh} x {mesh}" if mesh else "no runs")
            axes.set_ylabel(label)
        panels[1, k].set_xlabel("Bathe solves")
    precision_legend(beside, study, "fault")
    return canvas


def figure_precision_small(study):
    """Sliding mode and circuit: L2 error of the history, linear between steps."""
    canvas, panels, beside = precision_panels(1, 2, 4.6, 5)
    for axes, problem, label in zip(panels[0], ("sliding_mode", "circuit"), ("L2 error", "relative L2 error")):
        draw_precision(axes, study, {"problem": problem}, problem, "history_error", 1, 0.4)
        axes.set(title=problem, xlabel="Bathe solves", ylabel=label)
    problem = max(("sliding_mode", "circuit"), key=lambda name: len(study.policies(name)))
    precision_legend(beside, study, problem)
    return canvas


# ---- transfer ----

def transfers(study):
    """(transferred policy, the one of a sweep that it began from), whose name it begins with."""
    swept = [name for members in study.sweeps().values() for name in members.values()]
    return [(name, base) for name in study.policies("fault") for base in swept if name.startswith(base + "_")]


def draw_transfer(axes, study, size, meshes, named):
    """Bars of one size: solves of heuristic over those of each policy, its error on top."""
    width = 0.8 / len(named)
    for k, name in enumerate(named):
        for i, mesh in enumerate(meshes):
            case = {"problem": "fault", "size_km": size, "mesh": mesh, "error": PUBLISHED[0], "reaction": PUBLISHED[1]}
            cell, other = study.one(policy=name, **case), study.one(controller="heuristic", tolerance=1.0, **case)
            x = i + (k - (len(named) - 1) / 2) * width
            if cell is None or other is None or not cell.converged or not other.converged:
                axes.text(x, 0, "failed" if cell is not None and not cell.converged else "–", ha="center", va="bottom",
                          fontsize=8)
                continue
            height = other["solves"] / cell["solves"]
            axes.bar(x, height, 0.95 * width, color=BLUES[k % len(BLUES)])
            axes.text(x, height, f"{height:.0f}\n{100 * cell.error():.2g} %", ha="center", va="bottom", fontsize=7)
    axes.set_xticks(range(len(meshes)), [f"{mesh}²" for mesh in meshes])
    axes.set_xlim(-0.5, len(meshes) - 0.5)
    axes.margins(y=0.3)  # room for the legend
    axes.grid(False, axis="x")
    axes.tick_params(bottom=False)
    axes.set_title(f"{size:g} km")


def figure_transfer(study):
    """Solves of heuristic over those of a policy before and after its transfer, with errors on the bars."""
    sizes, pairs = study.axis("size_km", problem="fault") or [3.0], transfers(study)
    meshes, named = study.axis("mesh", problem="fault"), [name for pair in pairs for name in pair[::-1]]
    canvas, panels = plt.subplots(1, len(sizes), figsize=(5.4 * len(sizes), 4.2), layout="constrained", squeeze=False,
                                  sharey=True)
    for axes, size in zip(panels[0], sizes):
        if not named or not meshes:
            empty(axes, "no transferred policy")
            continue
        draw_transfer(axes, study, size, meshes, named)
    panels[0, 0].set_ylabel("solves of heuristic over rl")
    if named:
        handles = [plt.Rectangle((0, 0), 1, 1, color=BLUES[k % len(BLUES)], label=name) for k, name in enumerate(named)]
        panels[0, 0].legend(handles=handles, loc="upper left", fontsize=9)
        canvas.suptitle(f"Transfer to a finer mesh: {PUBLISHED[0]} estimate, {PUBLISHED[1]} reaction; the ratio and "
                        "the error of the final slip on each bar", fontsize=10)
    return canvas


FIGURES = {
    "sliding_mode": lambda study: figure_states(study, "sliding_mode"),
    "circuit": lambda study: figure_states(study, "circuit"),
    "ratios_published": lambda study: figure_ratios(study, PUBLISHED),
    "ratios_default": lambda study: figure_ratios(study, DEFAULT),
    "errors_published": lambda study: figure_errors(study, PUBLISHED),
    "errors_default": lambda study: figure_errors(study, DEFAULT),
    "steps": figure_steps,
    "history": figure_history,
    "work_precision": figure_precision,
    "work_precision_small": figure_precision_small,
    "transfer": figure_transfer,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("study", metavar="FILE", help="output file of evaluate")
    parser.add_argument("--figures", metavar="DIR", default=os.path.join("output", "figures"),
                        help="folder for the figures, default figures/ beside this script")
    parser.add_argument("--only", metavar="NAME,...", help=f"some of {', '.join(FIGURES)}; default all")
    options = parser.parse_args()
    names = options.only.split(",") if options.only else list(FIGURES)
    unknown = [name for name in names if name not in FIGURES]
    if unknown:
        parser.error(f"unknown figure {unknown[0]}, expected some of {', '.join(FIGURES)}")
    study = Study(options.study)
    study.warn()
    os.makedirs(options.figures, exist_ok=True)
    use_style()
    for name in names:
        target = os.path.join(options.figures, f"study_{name}.png")
        save(FIGURES[name](study), target)
        print(f"Figure: {target}")
