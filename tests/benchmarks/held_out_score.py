"""What the held-out benchmark concludes from its runs: pure functions on rows, one row a run.

A cell is one case at one position of the dial. Its ratio at equal error is that of the solves of the best classical
run, the one with the fewest solves (rejected and failed attempts included) whose error is not larger than the learned
run's and that all tighter tolerances of its family keep as well, over the learned run's. The choice is made afterwards,
for each case by itself and with the errors known; without the condition on tighter tolerances, a run whose error
happens to cross zero would win. Errors below FLOOR times the dial are luck of the same kind and count as that.
"setting" is what a user gets: one family and tolerance for all cases, the cheapest (geometric mean of solves) of those
that keep the dial in the share of the cases that the dial promises; chosen on the held-out cases themselves, which
favours the classical side.
"""

import numpy as np

from slipstep.results.course import MEASURES

PROMISE = {3e-3: 0.90}  # share of runs that keep the dial
USUAL_PROMISE = 0.95
FLOOR = 0.1
VIEWS = ("equal", "other", "setting")


def error(row, measure):
    return MEASURES[measure](row)


def by(rows, *names):
    groups = {}
    for r in rows:
        groups.setdefault(tuple(r[n] for n in names) if len(names) > 1 else r[names[0]], []).append(r)
    return groups


def steady(rows, measure, bound):
    """The runs within an error bound that all runs of tighter tolerances of their family keep as well."""
    found = []
    for runs in by(rows, "family").values():
        for run in sorted(runs, key=lambda r: r["setting"]):
            if run["failed"] or error(run, measure) > bound:
                break
            found.append(run)
    return found


def cheapest(rows, measure, bound):
    """The best classical run of one case; None when there is none."""
    return min(steady(rows, measure, bound), key=lambda r: (r["solves"], error(r, measure)), default=None)


def envelope(solves, errors):
    """Points that no other beats in both: ascending in solves, descending in error."""
    points, best = [], np.inf
    for n, e in sorted(zip(solves, errors)):
        if e < best:
            points.append((n, e))
            best = e
    return np.array(points).T


def solves_at(solves, errors, bound):
    """Solves that a set of runs needs for an error: its envelope, interpolated between logarithms. An error above all
    of the envelope's costs its cheapest run, one below all cannot be had: infinity."""
    n, e = envelope(solves, errors)
    if bound >= e[0]:
        return float(n[0])
    if bound < e[-1]:
        return np.inf
    return float(np.exp(np.interp(-np.log(bound), -np.log(e), np.log(n))))


def best_setting(rows, measure, dial):
    """((family, rtol), {case: run}) of the cheapest setting that all cases were run with and that keeps the dial in the
    share of them that it promises."""
    cases = {r["case"] for r in rows}
    best = (np.inf, None, {})
    for setting, runs in by([r for r in rows if r["family"] != "constant"], "family", "setting").items():
        kept = [not r["failed"] and error(r, measure) <= dial for r in runs]
        if len(runs) < len(cases) or np.mean(kept) < PROMISE.get(dial, USUAL_PROMISE):
            continue
        cost = np.exp(np.mean([np.log(r["solves"]) for r in runs if not r["failed"]]))
        if cost < best[0]:
            best = (cost, setting, {r["case"]: r for r in runs})
    return best[1], best[2]


def cells(ours, classical, measure):
    """Every run of ours beside the classical runs of its case, as rows. A run of ours that failed has no ratios.
    best_VIEW: solves of the best classical controller at equal error ("equal"), at equal error of the other measure,
    final slip or history ("other"), and with one setting for all cases ("setting")."""
    table, per_case, settings = [], by(classical, "case"), {}
    other = "history" if measure == "final_slip" else "final_slip"
    for run in ours:
        dial = run["setting"]
        if dial not in settings:
            settings[dial] = best_setting(classical, measure, dial)
        row = {name: run.get(name) for name in ("case", "group", "family", "setting", "failed", "solves", "rejected")}
        if not run["failed"] and run["case"] in per_case:
            row.update({name: run[name] for name in ("slip_error", "final", "history", "shift", "peak", "field")})
            row.update(error=error(run, measure), error_other=error(run, other))
            for view, by_measure, e in (("equal", measure, row["error"]), ("other", other, row["error_other"])):
                best = cheapest(per_case[run["case"]], by_measure, max(e, FLOOR * dial))
                row["best_" + view] = best["solves"] if best else np.nan
                row[f"best_{view}_by"] = f"{best['family']}, {best['setting']:g}" if best else ""
            chosen = settings[dial][1].get(run["case"])
            row["best_setting"] = chosen["solves"] if chosen and not chosen["failed"] else np.nan
            row.update({f"ratio_{view}": row["best_" + view] / run["solves"] for view in VIEWS})
        table.append(row)
    return table, {dial: s[0] for dial, s in settings.items()}


def statistics(table):
    """Per policy, dial and group of cases ("all" for all): honesty of the dial, and every view's mean and least
    ratio."""
    found = {}
    everything = [dict(r, group="all") for r in table]
    for key, rows in by(table + everything, "family", "setting", "group").items():
        good = [r for r in rows if not r["failed"]]
        errors = np.array([r["error"] for r in good])
        s = {"runs": len(rows), "failed": len(rows) - len(good),
             "solves": float(np.mean([r["solves"] for r in good] or [np.nan])),
             "median": float(np.median(errors)) if good else np.nan,
             "median_other": float(np.median([r["error_other"] for r in good])) if good else np.nan,
             "kept": float(np.sum(errors <= key[1]) / len(rows))}  # a failed run keeps nothing
        for view in VIEWS:
            ratio = np.array([r.get(f"ratio_{view}", np.nan) for r in good])
            ratio = ratio[np.isfinite(ratio)]
            if len(ratio):
                s[view] = {"mean": float(ratio.mean()), "median": float(np.median(ratio)), "least": float(ratio.min()),
                           "below_1": int(np.sum(ratio < 1)), "cells": len(ratio)}
        found[key] = s
    return found
