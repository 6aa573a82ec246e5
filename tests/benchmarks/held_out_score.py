"""What the held-out benchmark concludes from its runs: pure functions on rows, one row a run.

A cell is one case at one position of the dial. Views of "the best classical controller" in a cell, as its Bathe solves
(rejected and failed attempts included, doubling counted as three a step):

    same_error   the cheapest of all classical runs of the case with |error of final slip| <= e, e being ours but at
                 least a tenth of the dial. The choice is made afterwards, with the error known, among some 160 runs: a
                 run whose error happens to cross zero wins. No user could have chosen it.
    dial         likewise with e = the dial.
    steady       the cheapest run with an error <= e (of same_error) that all tighter tolerances of its family keep as
                 well: without the crossings of zero, and still chosen afterwards, for each case by itself.
    history      families are curves, solves against the error of the slip's history, of which no run's crosses zero:
                 the cheapest family interpolated at our error, along its lower envelope.
    setting      one family and tolerance for all cases, as a user has to choose: the cheapest (geometric mean of
                 solves) of those that keep the dial in the share of cases that the dial promises. Chosen on the
                 held-out cases themselves, which favours the classical side.

The headline is "steady": at the same error, case by case, and no run of ours or of theirs wins by a crossing of zero.
"setting" is what a user gets. "history" tells what a policy trained on the final slip leaves to others.
"""

import numpy as np

PROMISE = {1e-1: 0.95, 1e-2: 0.95, 1e-3: 0.90, 1e-4: 0.90}  # share of runs that keep the dial
FLOOR = 0.1  # of the dial: an error below it is luck
BARE_FLOOR = 1e-4  # that of a policy without a dial
VIEWS = ("same_error", "dial", "steady", "history", "setting")


def cheapest(rows, error):
    """The run with the fewest solves among those within an error of final slip; None when there is none."""
    within = [r for r in rows if not r["failed"] and abs(r["slip_error"]) <= error]
    return min(within, key=lambda r: (r["solves"], abs(r["slip_error"])), default=None)


def steady(rows, error):
    """The cheapest run that keeps an error of final slip with every run of a tighter tolerance of its family."""
    found = []
    for runs in by(rows, "family").values():
        kept = []
        for run in sorted(runs, key=lambda r: r["setting"]):
            if run["failed"] or abs(run["slip_error"]) > error:
                break
            kept.append(run)
        found += kept
    return cheapest(found, error)


def envelope(solves, errors):
    """Points that no other beats in both: ascending in solves, descending in error."""
    points, best = [], np.inf
    for n, e in sorted(zip(solves, errors)):
        if e < best:
            points.append((n, e))
            best = e
    return np.array(points).T


def solves_at(solves, errors, error):
    """Solves that a family needs for an error: its envelope, interpolated between logarithms. An error above all of the
    envelope's costs its cheapest run, one below all cannot be had: infinity."""
    n, e = envelope(solves, errors)
    if error >= e[0]:
        return float(n[0])
    if error < e[-1]:
        return np.inf
    return float(np.exp(np.interp(-np.log(error), -np.log(e), np.log(n))))


def by(rows, *names):
    groups = {}
    for r in rows:
        groups.setdefault(tuple(r[n] for n in names) if len(names) > 1 else r[names[0]], []).append(r)
    return groups


def history_best(rows, error):
    """(solves, family) of the cheapest family at an error of the slip's history."""
    found = []
    for family, runs in by([r for r in rows if not r["failed"]], "family").items():
        found.append((solves_at([r["solves"] for r in runs], [r["history_error"] for r in runs], error), family))
    return min(found, default=(np.inf, ""))


def best_setting(rows, error, promise):
    """((family, rtol), {case: run}) of the cheapest setting that all cases were run with and that keeps the error in a
    share of them."""
    cases = {r["case"] for r in rows}
    best = (np.inf, None, {})
    for setting, runs in by(rows, "family", "setting").items():
        kept = [not r["failed"] and abs(r["slip_error"]) <= error for r in runs]
        if len(runs) < len(cases) or np.mean(kept) < promise:
            continue
        cost = np.exp(np.mean([np.log(r["solves"]) for r in runs if not r["failed"]]))
        if cost < best[0]:
            best = (cost, setting, {r["case"]: r for r in runs})
    return best[1], best[2]


def compare(ours, classical, setting_runs, dial):
    """A cell: solves of the best classical controller in every view, and who it was."""
    own = abs(ours["slip_error"])
    error = max(own, FLOOR * dial if dial else BARE_FLOOR)
    cell = {"error_compared": error}  # best_VIEW: solves
    for view, run in (("same_error", cheapest(classical, error)), ("dial", cheapest(classical, dial or error)),
                      ("steady", steady(classical, error)), ("setting", setting_runs.get(ours["case"]))):
        usable = run is not None and not run["failed"]
        cell["best_" + view] = run["solves"] if usable else np.nan
        cell[f"best_{view}_by"] = f"{run['family']}, rtol {run['setting']:g}" if usable else ""
    cell["best_history"], cell["best_history_by"] = history_best(classical, ours["history_error"])
    return cell


def cells(ours, classical):
    """Every run of ours beside the classical runs of its case, as rows. A run of ours that failed has no ratios."""
    table, per_case, settings = [], by(classical, "case"), {}
    for run in ours:
        dial = run["setting"]
        if dial not in settings:
            settings[dial] = best_setting(classical, dial, PROMISE.get(dial, 0.95)) if dial else (None, {})
        row = {name: run.get(name) for name in ("case", "group", "family", "setting", "failed", "solves", "rejected", "slip_error",
                                                "history_error", "peak_error", "half_time_error", "slip_error_estimate")}
        if not run["failed"] and run["case"] in per_case:
            row.update(compare(run, per_case[run["case"]], settings[dial][1], dial))
            row.update({f"ratio_{view}": row["best_" + view] / run["solves"] for view in VIEWS})
        table.append(row)
    return table, {dial: s[0] for dial, s in settings.items()}


def statistics(table):
    """Per policy and dial: honesty of the dial, and every view's mean and smallest ratio."""
    found = {}
    for key, rows in by(table, "family", "setting").items():
        good = [r for r in rows if not r["failed"]]
        error = np.array([abs(r["slip_error"]) for r in good])
        s = {"runs": len(rows), "failed": len(rows) - len(good), "solves": float(np.mean([r["solves"] for r in good] or [np.nan])),
             "median_error": float(np.median(error)) if good else np.nan}
        if key[1]:
            s["kept"] = float(np.sum(error <= key[1]) / len(rows))  # a failed run keeps nothing
            s["median_over_dial"] = s["median_error"] / key[1]
        for view in VIEWS:
            ratio = np.array([r.get(f"ratio_{view}", np.nan) for r in good])
            ratio = ratio[np.isfinite(ratio)]
            if len(ratio):
                s[view] = {"mean": float(ratio.mean()), "least": float(ratio.min()), "below_1": int(np.sum(ratio < 1)), "cells": len(ratio)}
        found[key] = s
    return found
