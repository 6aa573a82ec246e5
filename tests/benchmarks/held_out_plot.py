"""Figures of the held-out benchmark: work-precision diagrams, one for all kinds of cases and one panel a case for
each."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from held_out_score import by, envelope, error, solves_at

COLOURS = {"pi fault_history": "tab:olive", "heuristic": "tab:blue", "basic": "tab:green", "dsp": "tab:purple",
           "pi": "tab:brown", "constant": "tab:gray"}
DIAL_COLOURS = ["gold", "orange", "tab:red", "darkred", "black", "tab:pink"]
ERRORS = np.geomspace(1e-3, 0.3, 26)
LABELS = {"history": "error of the course of slip", "final_slip": "error of the final slip",
          "event_time": "error of the time of the event"}
PAGE = 40  # panels in a figure at most


def controller(run):
    """What has a line of its own: the tuned filter, and others by their type."""
    return run["family"] if run["family"] in COLOURS else run["family"].replace(",", " ").split()[0]


def points(runs, measure):
    """(solves, error), sorted by solves."""
    return np.array(sorted((r["solves"], error(r, measure)) for r in runs if not r["failed"])).T


def finish(ax, title):
    ax.set_title(title, fontsize=9)
    ax.set_xscale("log"), ax.set_yscale("log")
    ax.set_xlim(0.5, 7e-4), ax.set_ylim(3, 500)
    ax.grid(alpha=0.3, lw=0.4)
    ax.tick_params(labelsize=7)


def learned(ax, runs, measure, size):
    for colour, (dial, rows) in zip(DIAL_COLOURS, sorted(by(runs, "setting").items(), reverse=True)):
        found = points(rows, measure)
        if found.size:
            ax.plot(np.maximum(found[1], 8e-4), found[0], "o", color=colour, ms=size, mec="white", mew=0.4,
                    label=f"{rows[0]['family']}, {dial:g}", zorder=3)


def median_solves(cases, measure):
    """Over the cases, the solves that their runs need for ERRORS; NaN where a case's runs cannot have the error."""
    return np.median([[solves_at(*points(runs, measure), e) for e in ERRORS] for runs in cases], axis=0)


def best_solves(runs, measure):
    """The same of one case, by the family that needs the fewest at each error."""
    return np.min([[solves_at(*points(family, measure), e) for e in ERRORS] for family in by(runs, "family").values()],
                  axis=0)


def overview(path, measure, classical, ours):
    """A panel a kind: the medians of the envelopes of its cases, one line a controller, and the learned runs."""
    groups = list(dict.fromkeys(r["group"] for r in ours))
    columns = min(3, len(groups))
    rows = -(-len(groups) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(4.2 * columns, 3.2 * rows + 0.8), squeeze=False, sharex=True,
                                sharey=True)
    for ax, group in zip(axes.flat, groups):
        runs = [r for r in classical if r["group"] == group and not r["failed"]]
        for name, rows_of in by([dict(r, controller=controller(r)) for r in runs], "controller").items():
            ax.plot(ERRORS, median_solves(by(rows_of, "case").values(), measure), color=COLOURS[name], lw=1, label=name)
        ax.plot(ERRORS, np.median([best_solves(of_case, measure) for of_case in by(runs, "case").values()], axis=0),
                color="black", lw=2, label="best classical family")
        learned(ax, [r for r in ours if r["group"] == group], measure, 4)
        finish(ax, f"{group}, {len({r['case'] for r in runs})} cases")
    end(figure, axes, len(groups), measure, path)


def panels(path, measure, classical, ours):
    """A panel a case: the envelope of each controller's runs, and the learned runs."""
    names = list(dict.fromkeys(r["case"] for r in ours))
    columns = min(8 if len(names) > 12 else 4, len(names))
    rows = -(-len(names) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(2.6 * columns, 2.3 * rows + 0.9), squeeze=False, sharex=True,
                                sharey=True)
    for ax, name in zip(axes.flat, names):
        for key, runs in by([dict(r, controller=controller(r)) for r in classical if r["case"] == name
                             and not r["failed"]], "controller").items():
            n, e = envelope(*points(runs, measure))
            ax.plot(e, n, color=COLOURS[key], lw=0.9, label=key)
        learned(ax, [r for r in ours if r["case"] == name], measure, 5)
        finish(ax, name)
    end(figure, axes, len(names), measure, path)


def end(figure, axes, used, measure, path):
    for ax in axes.flat[used:]:
        ax.axis("off")
    figure.supxlabel(LABELS[measure], fontsize=9)
    figure.supylabel("Bathe solves", fontsize=9)
    handles = {}
    for ax in axes.flat[:used]:
        handles.update(dict(zip(*reversed(ax.get_legend_handles_labels()))))
    height = figure.get_size_inches()[1]
    figure.legend(handles.values(), handles.keys(), loc="upper center", ncol=min(6, len(handles)), fontsize=7,
                  frameon=False)
    figure.tight_layout(rect=(0.012, 0, 1, 1 - 0.6 / height))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw(prefix, measure, classical, ours):
    overview(f"{prefix}.png", measure, classical, ours)
    for group, runs in by(ours, "group").items():
        names = list(dict.fromkeys(r["case"] for r in runs))[:PAGE]
        slug = group.replace(" ", "").replace(",", "_")
        panels(f"{prefix}_{slug}.png", measure, classical, [r for r in runs if r["case"] in names])
