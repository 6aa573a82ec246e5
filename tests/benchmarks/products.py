#!/usr/bin/env python3
"""Products with stiffness and viscosity, and how often the accuracy is kept, of faults with inertia of each kind.

    tests/benchmarks/products.py                       # steps that are explicit or implicit, and implicit ones, by
                                                       # learned policies
    tests/benchmarks/products.py --kinds event rupture --faults 40 --all     # beside every classical setting, chosen
                                                                             # afterwards
    tests/benchmarks/products.py --other PATH/TO/build              # another build's default as well
    tests/benchmarks/products.py --move                             # how far the policy's dial would have to be moved

Faults: products_cases.py, drawn by a seed. A run's error is that of the whole history (slipstep.results.course) against
constant explicit steps which those twice as long confirm. Products are all with K, Kn and H, those formed at once
counted once, and with the preconditioner (output/README.md); of a build that does not count these, those with K.
"Afterwards" is the cheapest run within the dial, chosen for each fault; "one setting" the cheapest one that keeps the
dial in 95 % of the kind. Runs are kept in FOLDER: an interrupted benchmark goes on where it was. Needs numpy and h5py.
"""

import argparse
import json
import os
import sys

from common import ROOT
import h5py
import numpy as np

from slipstep.results import course
import products_cases
from held_out_cases import Case
from held_out_run import Bench, BenchmarkError, Job, execute, read_course

POLICY = os.path.join(ROOT, "training", "policies", "fault_products.h5")
SEED = 20261128
DIALS = [1e-1, 3e-2, 1e-2, 3e-3]
LADDER = [float(f"{a:.4g}") for a in np.geomspace(1e-1, 1e-3, 33)]  # of --move: 16 a decade
STEPS = [float(f"{s:.4g}") for s in np.geomspace(3, 0.02, 16)]  # constant ones [T*]
SHARES = [1, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.09]  # constant ones, of the longest that are stable
TOLERANCES = [float(f"{t:.4g}") for t in np.geomspace(1, 1e-4, 9)]
METHODS = {"explicit": ["-ts_type", "moreau"], "implicit": [], "auto": ["-ts_bathe_method", "auto"]}
CONTROLLERS = {"pi": ["-ts_adapt_type", "pi", "-ts_adapt_pi_filter", "fault_history"], "dsp": ["-ts_adapt_type", "dsp"]}
FINE = (1 / 60, 1 / 120, 1 / 240, 1 / 480, 1 / 960)  # steps of references [T*], until two agree
AGREE = 3e-4  # a tenth of the finest dial
SHARE = 0.95  # of runs of one setting that keep the dial
MOVED_SHARE = 0.97  # of those by which the dial is moved


class Products(Bench):
    """Cases and references are those of explicit steps."""

    def probe(self, case):
        options = METHODS["auto"] if "traction" not in case.options else constant("explicit", 0.1 * case.tstar)
        (_, found, _), = execute(self.build, [Job(case, "fine", "", 0, options)], self.folder, read_course)
        if not found:
            return None, 0.0
        return None if np.isnan(found[0]["rest"]) else float(found[0]["rest"]), found[0]["mean_slip"]

    def make_reference(self, case, path):
        before, spread = None, None
        for share in FINE:
            (_, found, message), = execute(self.build, [
                Job(case, "fine", "", 0, constant("explicit", share * case.tstar))], self.folder, read_course)
            if not found:
                raise BenchmarkError(f"the reference of {case.name} failed: {message}")
            if before and found[0]["accepted"] > 1.5 * before[0]["accepted"]:
                spread = course.MEASURES["history"](course.errors(before[1], found[1]))
                if spread < AGREE:
                    break
            # not twice the longest steps that are stable
            if not before or found[0]["accepted"] > 1.5 * before[0]["accepted"]:
                before = found
        else:
            print(f"Note: {case.name} has no reference: fine runs differ by {spread:.1e}, expected < {AGREE:g}; it "
                  "is left out")
            spread = np.inf
        with h5py.File(path + ".part", "w") as file:
            for name, values in vars(found[1]).items():
                file[name] = values
            file.attrs.update(case=case.name, spread=spread, longest=self.longest(case))
        os.replace(path + ".part", path)

    def longest(self, case):
        """The longest explicit step that is stable [s], to which longer constant ones are cut"""
        def first(output):
            with h5py.File(output) as file:
                return float(file["steps/dt"][0])
        (_, found, message), = execute(self.build, [
            Job(case, "fine", "", 0, [*constant("explicit", case.duration), "-ts_max_steps", "1"])], self.folder, first)
        if not found:
            raise BenchmarkError(f"the longest step of {case.name}: {message}")
        return found

    def cases(self, kinds, count, seed):
        """Made once, with the longest explicit step [s]; those without a reference are left out."""
        room = os.path.join(self.folder, f"cases_{seed}")
        os.makedirs(room, exist_ok=True)
        cases = []
        for kind in kinds:
            for k in range(count):
                path = os.path.join(room, f"{kind}_{k + 1:02d}.json")
                if not os.path.exists(path):
                    with open(path + ".part", "w") as file:
                        json.dump(vars(products_cases.make(kind, k, seed, room, self.probe)), file)
                    os.replace(path + ".part", path)
                with open(path) as file:
                    case = Case(**json.load(file))
                reference = self.reference(case)
                if reference["spread"] < AGREE:
                    case.longest = float(reference["longest"])
                    cases.append(case)
        return cases


def constant(method, step):
    return [*METHODS[method], "-ts_adapt_type", "none", "-ts_dt", f"{step:.6g}"]


def kind_of(case):
    return case.group.split()[0]


def learned(case, policy, dial):
    """Ruptures have no policy for explicit steps: theirs is that of implicit ones."""
    rl = ["-ts_adapt_type", "rl", "-ts_adapt_rl_accuracy", f"{dial:g}", *METHODS["auto"]]
    return Job(case, "policy", "auto", dial, rl, policy if kind_of(case) in products_cases.EVENTS else "")


def default(case, dial):
    return Job(case, "default", "default", dial, ["-fault_accuracy", f"{dial:g}"])


def implicit(case, dial):
    return Job(case, "policy", "implicit", dial, ["-fault_accuracy", f"{dial:g}", "-ts_bathe_method", "implicit"])


def classical(case):
    """Every setting of --all. A setting that fails keeps no dial."""
    for step in STEPS:
        yield Job(case, "classical", "constant explicit", step, constant("explicit", step * case.tstar))
    for share in SHARES:
        yield Job(case, "classical", "share of the longest explicit", share, constant("explicit", share * case.longest))
    for method, options in METHODS.items():
        for name, controller in CONTROLLERS.items():
            for rtol in TOLERANCES:
                yield Job(case, "classical", f"{name} {method}", rtol, [*options, *controller, "-ts_rtol", f"{rtol:g}"])


def error(row):
    return np.inf if row["failed"] else course.MEASURES["history"](row)


def products(row):
    if row["failed"]:
        return np.inf
    return max(row["products_all"] + row["products_pc"] if "products_all" in row else row["products"], 1)


def mean(values):
    """Geometric"""
    values = np.array(values)
    values = values[np.isfinite(values)]
    return np.exp(np.mean(np.log(values))) if len(values) else np.nan


def one_setting(rows, dial):
    """The name of the cheapest of [row] by settings that keeps the dial, and its products by case."""
    best = (np.inf, "-", {})
    settings = {}
    for row in rows:
        settings.setdefault((row["family"], row["setting"]), []).append(row)
    for (family, setting), runs in settings.items():
        if np.mean([error(r) <= dial for r in runs]) >= SHARE:
            best = min(best, (mean([products(r) for r in runs]), f"{family} {setting:g}",
                              {r["case"]: products(r) for r in runs}), key=lambda b: b[0])
    return best[1:]


def afterwards(rows, bound):
    """Products of the cheapest run of each case within a bound of its own."""
    return {case: min([products(r) for r in rows if r["case"] == case and error(r) <= limit], default=np.inf)
            for case, limit in bound.items()}


def ratios(ours, others):
    """mean, least of others' products over ours"""
    found = np.array([others[case] / products(row) for case, row in ours.items()
                      if np.isfinite(others.get(case, np.inf)) and not row["failed"]])
    return f"{mean(found):7.2f}{found.min():6.2f}" if len(found) else f"{'-':>7}{'-':>6}"


def report(cases, rows, other):
    """A line for each kind and dial"""
    kinds = {}
    for case in cases:
        kinds.setdefault(kind_of(case), []).append(case.name)
    print("\nproducts of others over those of auto: mean, least\n"
          f"{'kind':<11}{'dial':>6}{'runs':>5}{'kept':>6}{'median':>9}{'worst':>6}{'products':>9} | {'implicit':>8}"
          f"{'kept':>6}{'over auto':>13} | {'other build':>13} | {'afterwards':>13} | {'equal error':>13} | "
          "one setting")
    for kind, names in kinds.items():
        own = [r for r in rows if r["case"] in names]
        every = [r for r in own if r["kind"] == "classical"]
        for dial in DIALS:
            ours = {r["case"]: r for r in own if r["family"] == "auto" and r["setting"] == dial}
            others = {r["case"]: r for r in own if r["family"] == "implicit" and r["setting"] == dial}
            errors = np.array([error(r) for r in ours.values()])
            name, setting = one_setting(every, dial)
            print(f"{kind:<11}{dial:>6g}{len(ours):>5}{100 * np.mean(errors <= dial):>5.0f}%"
                  f"{np.median(errors):>9.1e}{errors.max() / dial:>6.2f}"
                  f"{mean([products(r) for r in ours.values()]):>9.1f} | "
                  f"{mean([products(r) for r in others.values()]):>8.1f}"
                  f"{100 * np.mean([error(r) <= dial for r in others.values()]):>5.0f}%"
                  f"{ratios(ours, {c: products(r) for c, r in others.items()})} | "
                  f"{ratios(ours, {r['case']: products(r) for r in other if r['setting'] == dial})} | "
                  f"{ratios(ours, afterwards(every, dict.fromkeys(ours, dial)))} | "
                  f"{ratios(ours, afterwards(every, {c: max(error(r), 0.1 * dial) for c, r in ours.items()}))} "
                  f"|{ratios(ours, setting)} {name}")


def report_moves(cases, rows):
    """The dial that the policy would have to see, so that the share of each kind's runs keeps the user's"""
    kinds = {kind: [c.name for c in cases if kind_of(c) == kind] for kind in dict.fromkeys(map(kind_of, cases))}
    kinds["all"] = [c.name for c in cases]
    print(f"\nlargest move of the dial [decades] with which {MOVED_SHARE:.0%} and {SHARE:.0%} are kept, and what it "
          f"costs in products\n{'kind':<11}" + "".join(f"{dial:>32g}" for dial in DIALS))
    for kind, names in kinds.items():
        line = f"{kind:<11}"
        at = {a: [r for r in rows if r["setting"] == a and r["case"] in names] for a in LADDER}
        for dial in DIALS:
            for share in (MOVED_SHARE, SHARE):
                good = [a for a in LADDER if a <= dial * 1.01 and np.mean([error(r) <= dial for r in at[a]]) >= share]
                cost = {a: mean([products(r) for r in at[a]]) for a in LADDER}
                near = min(LADDER, key=lambda a: abs(np.log(a / dial)))
                line += (f"{np.log10(max(good) / dial):>9.2f} x{cost[max(good)] / cost[near]:>4.2f}" if good
                         else f"{'none':>15}")
            line += f" {np.mean([error(r) <= dial for r in at[near]]):.2f}"[:5].rjust(2)
        print(line)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "output", "products"), help="of results")
    parser.add_argument("--other", help="another build, whose default steps run as well")
    parser.add_argument("--policy", default=POLICY, help="of the learned steps of events")
    parser.add_argument("--kinds", nargs="+", default=list(products_cases.KINDS), choices=products_cases.KINDS)
    parser.add_argument("--faults", type=int, default=20, help="of each kind")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--all", action="store_true", help="all classical settings, too")
    parser.add_argument("--move", action="store_true", help="the learned steps at many positions of the dial, and by "
                                                            "how much it would have to be moved")
    parser.add_argument("--jobs", type=int, default=2, help="processes at once")
    return parser.parse_args()


def main():
    o = arguments()
    bench = Products(os.path.abspath(o.build), os.path.abspath(o.folder), o.jobs)
    cases = bench.cases(o.kinds, o.faults, o.seed)
    policy = os.path.abspath(o.policy)
    if o.move:
        report_moves(cases, bench.all([learned(c, policy, a) for c in cases for a in LADDER], "positions of the dial"))
        return
    jobs = [make(case, *more, dial) for case in cases for dial in DIALS
            for make, more in ((learned, [policy]), (implicit, []))]
    rows, other = bench.all(jobs, "learned steps"), []
    if o.other:
        theirs = Products(os.path.abspath(o.other), os.path.join(bench.folder, "other"), o.jobs)
        theirs.fine = bench.fine
        other = theirs.all([default(c, dial) for c in cases for dial in DIALS], "the other build")
    if o.all:
        rows += bench.all([job for case in cases for job in classical(case)], "classical settings")
    report(cases, rows, other)


if __name__ == "__main__":
    try:
        main()
    except BenchmarkError as failure:
        sys.exit(f"products.py: {failure}")
