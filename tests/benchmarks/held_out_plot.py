"""Figures of the held-out benchmark: a summary, and the work-precision curves of every case."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import held_out_score

# embedded estimates solid, doubling dashed; one hue a controller
STYLE = {"heuristic": ("tab:blue", "-"), "heuristic, safety 0.9": ("tab:cyan", "-"), "heuristic, long start": ("navy", "-"),
         "basic": ("tab:green", "-"), "dsp": ("tab:purple", "-"), "pi": ("tab:brown", "-"), "heuristic, doubling": ("tab:blue", ":"),
         "basic, doubling": ("tab:green", ":"), "dsp, doubling": ("tab:purple", ":"), "pi, doubling": ("tab:brown", ":")}
MARKERS = "osD^vP"
LABEL = {"same_error": "afterwards, same final-slip error", "dial": "afterwards, error within the dial",
         "steady": "afterwards, same error, without luck",
         "history": "same error of the slip history", "setting": "one setting that keeps the dial"}


def dial_name(dial):
    return f"{dial:g}" if dial else "no dial"


def curves(path, classical, ours, names, columns):
    """Solves against error of final slip, a panel a case."""
    rows = -(-len(names) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(2.6 * columns, 2.3 * rows + 0.9), squeeze=False, sharex=True, sharey=True)
    settings = sorted({(r["family"], r["setting"]) for r in ours}, key=lambda s: (s[0], -s[1]))
    for ax, name in zip(axes.flat, names):
        for family, runs in held_out_score.by([r for r in classical if r["case"] == name and not r["failed"]], "family").items():
            points = np.array(sorted((r["solves"], abs(r["slip_error"])) for r in runs)).T
            colour, line = STYLE[family]
            ax.plot(*points, line, color=colour, lw=0.8, label=family)
        for marker, (policy, dial) in zip(MARKERS, settings):
            for r in ours:
                if (r["case"], r["family"], r["setting"]) == (name, policy, dial) and not r["failed"]:
                    ax.plot(r["solves"], max(abs(r["slip_error"]), 1e-6), marker, color="tab:red" if policy != "study" else "black", ms=5,
                            mec="white", mew=0.5, label=f"{policy}, {dial_name(dial)}", zorder=3)
        ax.set_title(name, fontsize=8)
        ax.set_xscale("log"), ax.set_yscale("log")
        ax.set_xlim(4, 2000), ax.set_ylim(1e-6, 1)
        ax.grid(alpha=0.3, lw=0.4)
        ax.tick_params(labelsize=7)
    for ax in axes.flat[len(names):]:
        ax.axis("off")
    figure.supxlabel("Bathe solves", fontsize=9)
    figure.supylabel("relative error of the final slip", fontsize=9)
    handles = dict(zip(*(reversed(axes.flat[0].get_legend_handles_labels()))))
    figure.legend(handles.values(), handles.keys(), loc="upper center", ncol=min(7, len(handles)), fontsize=7, frameon=False)
    figure.tight_layout(rect=(0.012, 0, 1, 1 - 0.75 / (2.3 * rows + 0.9)))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def strip(ax, table, groups, settings, value, text):
    """Values of cells as dots, a column a group and position of the dial, medians as bars."""
    ticks, labels = [], []
    for g, group in enumerate(groups):
        for k, setting in enumerate(settings):
            x = g * (len(settings) + 1) + k
            y = np.array([v for v in (value(r) for r in table if r["group"] == group and (r["family"], r["setting"]) == setting)
                          if v is not None and np.isfinite(v)])
            if not len(y):
                continue
            jitter = (np.arange(len(y)) % 7 - 3) * 0.08
            colour = "black" if setting[0] == "study" else f"C{k}"
            ax.plot(x + jitter, y, ".", color=colour, ms=5, alpha=0.7, label=f"{setting[0]}, {dial_name(setting[1])}" if g == 0 else None)
            ax.plot([x - 0.35, x + 0.35], [np.median(y)] * 2, color=colour, lw=2)
        ticks.append(g * (len(settings) + 1) + (len(settings) - 1) / 2)
        labels.append(group)
    ax.set_xticks(ticks, labels, fontsize=8)
    ax.set_xlim(-1, len(groups) * (len(settings) + 1) - 1)
    ax.set_yscale("log")
    ax.grid(axis="y", alpha=0.3, lw=0.4)
    ax.set_title(text, fontsize=9)


def summary(path, table):
    groups = list(dict.fromkeys(r["group"] for r in table))
    settings = sorted({(r["family"], r["setting"]) for r in table}, key=lambda s: (s[0] == "study", s[0], -s[1]))
    figure, axes = plt.subplots(4, 2, figsize=(13, 14))
    for ax, view in zip(axes.flat, held_out_score.VIEWS):
        strip(ax, table, groups, settings, lambda r, view=view: r.get(f"ratio_{view}"), "solves, best classical over ours: " + LABEL[view])
        ax.axhline(1, color="black", lw=0.8)
        ax.axhline(2, color="black", lw=0.8, ls=":")
        ax.set_ylim(0.2, 30)
        ax.set_yticks([0.2, 0.5, 1, 2, 5, 10, 20], ["0.2", "0.5", "1", "2", "5", "10", "20"])
        ax.set_ylabel("ratio of solves", fontsize=8)
    error, solves, unused = axes.flat[len(held_out_score.VIEWS):]
    unused.axis("off")
    strip(error, table, groups, settings, lambda r: None if r["failed"] else max(abs(r["slip_error"]), 1e-7), "relative error of the final slip")
    for dial in {s[1] for s in settings if s[1]}:
        error.axhline(dial, color="black", lw=0.6, ls=":")
    strip(solves, table, groups, settings, lambda r: None if r["failed"] else r["solves"], "Bathe solves")
    handles, labels = solves.get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=len(labels), fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw(folder, classical, ours, table):
    names = list(dict.fromkeys(r["case"] for r in classical))
    groups = {r["case"]: r["group"] for r in classical}
    single = [n for n in names if groups[n] == "one cell"]
    others = [n for n in names if groups[n] != "one cell"]
    for title, chosen, columns in (("one", single, 8), ("mesh", others, 4)):
        if chosen:
            curves(os.path.join(folder, f"curves_{title}.png"), classical, ours, chosen, min(columns, len(chosen)))
    summary(os.path.join(folder, "summary.png"), table)
