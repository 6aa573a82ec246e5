"""A report of a run as one HTML file: what ran, on what, with which options, its pictures, its accuracy and its
warnings.

    slipstep report RUN.h5 [--catalogue EVENTS.h5] [-o REPORT.html]

The file needs no other file and no network: it can be sent by mail. Default name: RUN.html.
"""

import argparse
import base64
import html
import io
import os
import re

import numpy as np
from PIL import Image

from ..plots.cumulative import courses
from ..plots.panels import plt
from ..plots.spacetime import space_time
from ..results.catalogue import Catalogue
from ..results.events import Events
from ..results.files import replacing
from ..results.run import Run
from ..times import Clock, written
from . import moment_rate, plot_catalogue, plot_run

STYLE = """body{font:15px/1.5 system-ui,sans-serif;color:#1c2430;max-width:1000px;margin:2em auto;padding:0 1em}
h1{font-size:1.6em;margin-bottom:.1em}
h2{font-size:1.15em;margin-top:1.8em;border-bottom:1px solid #d5dbe3;padding-bottom:.2em}
table{border-collapse:collapse;margin:.5em 0}td,th{padding:.15em 1.2em .15em 0;text-align:left;vertical-align:top}
th{font-weight:600;color:#4a5666}td:first-child{white-space:nowrap}
code{font:13px/1.5 ui-monospace,monospace}td{overflow-wrap:anywhere}
img{max-width:100%;height:auto;border:1px solid #e3e7ed}
.warn{background:#fff6e0;border-left:4px solid #e0a100;padding:.4em .8em;margin:.4em 0}
.good{background:#eaf6ec;border-left:4px solid #2c8a4b;padding:.4em .8em}
small,.note{color:#5d6876}summary{cursor:pointer;color:#0062a5}"""


def table(rows, head=()):
    """Rows of (name, value); values are escaped."""
    lines = ["<table>"] + (["<tr>" + "".join(f"<th>{html.escape(name)}</th>" for name in head) + "</tr>"] if head
                           else [])
    lines += ["<tr>" + "".join(f"<td>{'<code>' if head else ''}{html.escape(str(cell))}{'</code>' if head else ''}</td>"
                               for cell in row) + "</tr>" for row in rows]
    return "\n".join(lines + ["</table>"])


def picture(canvas, what):
    """A figure as PNG of 256 colours within the page."""
    buffer, small = io.BytesIO(), io.BytesIO()
    canvas.savefig(buffer, format="png", dpi=90)
    plt.close(canvas)
    Image.open(buffer).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
    return f'<img alt="{html.escape(what)}" src="data:image/png;base64,{base64.b64encode(small.getvalue()).decode()}">'


def options_of(run):
    """(name, value) of each option that the run was given, by the command line or a file of options."""
    words = re.findall(r"(?:^|\s)(-[A-Za-z]\w*)((?:\s+(?!-[A-Za-z])\S+)*)", run.run.get("options", ""))
    return [(name, value.strip()) for name, value in words]


def facts(run):
    """(name, value) of what ran, on what, and how it ended."""
    of = run.run
    ended = "reached its end" if run.complete else "not ended"
    rows = [("file", run.path), ("state", f"{ended}, at {written(run.series['time'][-1])}"),
            ("date of the start", of.get("date", "not recorded")),
            ("SlipStep", of.get("slipstep_version", "not recorded")),
            ("PETSc", of.get("petsc_version", "not recorded")),
            ("machine", f"{of.get('host', 'not recorded')}, {of.get('ranks', '?')} MPI "
             f"{'process' if of.get('ranks') == 1 else 'processes'}")]
    if of.get("restarts"):
        rows.append(("restarts", of["restarts"]))
    rows.append(("integrator and controller", f"{of.get('ts_type', '?')}, {of.get('ts_adapt_type', '?')}"))
    if of.get("policy"):
        rows.append(("policy", f"{os.path.basename(of['policy'])} ({of.get('policy_hash', '')})"))
    return rows


def numbers(run):
    """(name, value) of the summary."""
    names = (("accepted", "accepted steps", ""), ("rejected", "rejected steps", ""), ("solves", "Bathe solves", ""),
             ("explicit_attempts", "explicit attempts", ""), ("newton_iterations", "Newton iterations", ""),
             ("linear_iterations", "linear iterations", ""), ("products_k", "products with the stiffness", ""),
             ("products_h", "products with the viscosity", ""), ("mean_slip", "final mean slip", " m"),
             ("events", "events", ""), ("wall_time_setup", "wall time of the set-up", " s"),
             ("wall_time_solve", "wall time of the solve", " s"))
    return [(label, f"{run.result[name]:.6g}{unit}") for name, label, unit in names if name in run.result]


def accuracy(run):
    """What is known of the run's error, in sentences."""
    of, found = run.result, []
    asked = of.get("accuracy_requested")
    if asked:
        found.append(f"Wanted relative error of the history of slip: {asked:g}.")
    for name, label in (("history_error_estimate", "history of slip"), ("slip_error_estimate", "final slip"),
                        ("event_time_error_estimate", "time of the event")):
        if name in of:
            found.append(f"Estimated relative error of the {label}: {of[name]:.2g}.")
    if not any(name.endswith("error_estimate") for name in of):
        found.append("The run has no estimate of its error; <code>-fault_check_error</code> repeats it with finer "
                     "steps and compares.")
    resolution = of.get("least_resolution")
    if resolution is not None:
        found.append(f"Cells in the smallest cohesive zone or nucleation length: {resolution:.3g}; 3 or more resolve "
                     "it (Day et al. 2005).")
    outside = of.get("policy_outside_range")
    if outside:
        found.append(f"{outside:.0f} of {of.get('policy_decisions', 0):.0f} decisions of the policy were outside of "
                     "the range of its training.")
    return found


def pictures(run, events):
    """(title, image) of each picture."""
    clock = Clock(0.0, run.series["time"][-1])
    years = clock.unit == "y"
    if not run.is_fault:
        return [("The run", picture(plot_run.small_figure(run, clock), "series and step sizes"))]
    found = [("Slip, slip rate and steps",
              picture(plot_run.figure(run, clock, clock.logarithmic("slip_rate")), "time series, step sizes and maps"))]
    rows = len(run.field("slip")[0]) if "slip" in run.field_names else 0
    if rows > 2 and "slip_rate" in run.field_names:
        found.append(("Slip rate and slip along strike",
                      picture(space_time(run, ["slip_rate", "slip"]), "space-time picture")))
    if events is not None and len(events):
        lines = courses(run, "slip", "strike", None, None, 5.0) if rows > 2 and years else []
        found.append(("The catalogue",
                      picture(plot_catalogue.figure(events, lines, None)[0], "magnitudes, frequencies, hypocentres")))
        number = events.number_of("largest")
        if events.has_maps:
            found.append(("The largest event",
                          picture(plot_catalogue.event_figure(events, number), "slip of the largest event")))
        begin, end = events["onset"][number], events["end"][number]
        time, rate, _ = moment_rate.moment_rate(run, begin, end)
        title = f"Event {number + 1} at {written(begin)}: M {events['magnitude'][number]:.2f}"
        found.append(("Its moment-rate function",
                      picture(moment_rate.figure(time, rate, [run.fault_name(label) for label in run.faults], title),
                              "moment rate")))
    return found


def page(run, events, catalogue):
    warnings = [line for line in run.run.get("warnings", "").split("\n") if line]
    parts = [f"<h1>{html.escape(os.path.basename(run.path))}</h1>", '<p class="note">A run of SlipStep</p>',
             "<h2>What ran</h2>", table(facts(run))]
    parts += ["<h2>Result</h2>", table(numbers(run))]
    if catalogue is not None and catalogue.goes_on:
        of = catalogue.goes_on
        parts.append(f"<p>The last event goes on at the end of the run: M {of['magnitude']:.2f} so far, since "
                     f"{written(of['onset'])}.</p>")
    parts += ["<h2>Accuracy</h2>", *(f"<p>{line}</p>" for line in accuracy(run))]
    if "warnings" in run.run:
        parts += ["<h2>Warnings</h2>"] + ([f'<p class="warn">{html.escape(line)}</p>' for line in warnings]
                                          or ['<p class="good">The run printed no warnings.</p>'])
    for title, image in pictures(run, events):
        parts += [f"<h2>{html.escape(title)}</h2>", image]
    parts += ["<h2>Options given</h2>", '<p class="note">All other options have their defaults.</p>',
              table(options_of(run), ("option", "value"))]
    if run.parameters:
        parts += ["<details><summary>All parameters that are one number or one choice (SI units)</summary>",
                  table(sorted((name, f"{value:.10g}" if isinstance(value, (int, float, np.number)) else value)
                               for name, value in run.parameters.items()), ("parameter", "value")),
                  "</details>"]
    return ('<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<title>{html.escape(os.path.basename(run.path))}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n'
            + "\n".join(parts) + "\n</body>\n</html>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("run", metavar="RUN", help="output file of a run")
    parser.add_argument("--catalogue", metavar="EVENTS", help="its catalogue of events")
    parser.add_argument("-o", "--output", metavar="REPORT", help="file to write, default RUN.html")
    options = parser.parse_args()
    target = options.output or os.path.splitext(options.run)[0] + ".html"
    run = Run(options.run)
    run.warn()
    catalogue = Catalogue(options.catalogue) if options.catalogue else None
    events = Events(options.catalogue) if catalogue and catalogue.count else None
    text = page(run, events, catalogue)
    with replacing(target) as part, open(part, "w", encoding="utf-8") as file:
        file.write(text)
    print(f"Report: {target}, {len(text) // 1000} kB")
