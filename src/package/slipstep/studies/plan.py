"""The plan of a study: which runs there are, and by what each is known again. A study file is TOML:

    options_file = "fault.opts"                      # of all runs
    seeds = 5                                        # 1 to 5, or a list; {seed} in options and in `before`
    before = "make_fault.py {folder}/fields.h5 --seed {seed}"
    ranks = 1
    table = ["magnitude", "duration", "cost"]
    spin_up = 2                                      # events, or a time as "50y", that the columns leave out; by
                                                     # default of loaded runs the first large event

    [options]                                        # of all runs, as the keywords of slipstep.Fault
    ts_max_time = "30s"

    [vary]                                           # each with each
    normal_stress = [40e6, 50e6]
    friction_slip = {from = 0.1, to = 0.4, count = 4}    # or step = 0.1; spacing = "log"

    [[zip]]                                          # first with first, second with second
    nx = [10, 20]
    nz = [10, 20]

A run is known by its command, its options and the content of the files that these name, not by its number: values may
be added later.
"""

import dataclasses
import difflib
import hashlib
import itertools
import json
import math
import os
import re
import shlex

from ..errors import Error
from ..numbers.spinup import parsed
from ..running import OPTION, options_of, word
from . import table

KEYS = {"command": "fault", "options_file": None, "options": {}, "vary": {}, "zip": [], "seeds": [], "before": None,
        "ranks": 1, "launcher": None, "cores": None, "checkpoint": True, "table": None, "spin_up": None, "folder": None,
        "slurm": {}}
# of a fault, for each run
OWN = ("output", "catalogue", "checkpoint", "restart", "progress", "output_xdmf", "output_overwrite", "sweep",
       "stop_file")
MOST = 100000  # runs


@dataclasses.dataclass
class Planned:
    """One run: its number from 1 on, what it is known by, the values that differ between runs, all options, seed or
    None, ranks."""
    number: int
    name: str
    values: dict
    options: dict
    seed: object
    ranks: int


def refuse(source, key, value, expected):
    raise Error(f"{source}: {key} is {value!r}, expected {expected}")


def is_plain(value):
    return isinstance(value, (bool, int, float, str)) and not (isinstance(value, float) and not math.isfinite(value))


def values_of(source, key, given):
    """The list of values that a list or a range means."""
    given = given.tolist() if hasattr(given, "tolist") else given
    if isinstance(given, dict):
        return values_of_range(source, key, given)
    if not isinstance(given, (list, tuple)):
        refuse(source, key, given, "a list, or a range as {from = 1, to = 2, count = 3}")
    values = [value.item() if hasattr(value, "item") else value for value in given]
    if not values or not all(map(is_plain, values)):
        refuse(source, key, given, "a list of numbers, texts, or true and false")
    if len({word(value) for value in values}) < len(values):
        refuse(source, key, given, "no value twice")
    return values


def values_of_range(source, key, given):
    unknown = set(given) - {"from", "to", "count", "step", "spacing"}
    numbers = {name: value for name, value in given.items() if name != "spacing"}
    if unknown or not {"from", "to"} <= set(given) or ("count" in given) == ("step" in given) or not all(
            isinstance(v, (int, float)) and not isinstance(v, bool) for v in numbers.values()) or given.get(
                "spacing", "linear") not in ("linear", "log"):
        refuse(source, key, given,
               'a range of numbers with from, to and one of count and step, and spacing = "log" where it is one')
    low, high, log = given["from"], given["to"], given.get("spacing") == "log"
    if log and ("step" in given or low <= 0 or high <= 0):
        refuse(source, key, given, "numbers above 0 and a count with the spacing log")
    if "step" in given:
        count = (high - low) / given["step"] if given["step"] else -1
        if not 0 <= count < MOST:
            refuse(source, key, given, "a step that leads from the first number to the last")
        values = [low + k * given["step"] for k in range(int(count + 1e-9) + 1)]
    else:
        count = given["count"]
        if not isinstance(count, int) or not 2 <= count <= MOST:
            refuse(source, key, given, f"a count from 2 to {MOST}")
        share = [k / (count - 1) for k in range(count)]
        values = [low * (high / low) ** s if log else low + s * (high - low) for s in share]
        values[-1] = high
    # 0.3, not 0.30000000000000004
    return [float(f"{value:.12g}") if isinstance(value, float) else value for value in values]


def seeds_of(source, given):
    if isinstance(given, int) and not isinstance(given, bool) and 0 < given <= MOST:
        return list(range(1, given + 1))
    if (isinstance(given, (list, tuple)) and all(isinstance(seed, int) and not isinstance(seed, bool) for seed in given)
        and len(set(given)) == len(given)):
        return list(given)
    return refuse(source, "seeds", given, "a number of seeds, or a list of different whole numbers")


def checked(source, given):
    """All keys of a study, with their defaults."""
    for key in given:
        if key not in KEYS:
            near = difflib.get_close_matches(key, KEYS, 1)
            raise Error(f"{source}: there is no key {key}"
                        + (f"; did you mean {near[0]}?" if near else f"; expected {', '.join(KEYS)}"))
    whole = {**KEYS, **given}
    for key, kind, words in (("command", str, "a command"), ("options_file", str, "a file"),
                             ("before", str, "a command"), ("launcher", str, "words such as \"mpirun -n {ranks}\""),
                             ("folder", str, "a folder"), ("cores", int, "a number of cores"),
                             ("checkpoint", bool, "true or false"), ("options", dict, "a table of options"),
                             ("vary", dict, "a table of lists and ranges"),
                             ("slurm", dict, "a table of options of sbatch"), ("ranks", int, "a number of ranks"),
                             ("table", (list, tuple), "a list of columns")):
        if whole[key] is not None and (not isinstance(whole[key], kind)
                                       or (kind is int and (isinstance(whole[key], bool) or whole[key] < 1))
                                       or (kind is str and not whole[key].strip())):
            refuse(source, key, whole[key], words)
    if isinstance(whole["zip"], dict):
        whole["zip"] = [whole["zip"]]
    if not isinstance(whole["zip"], (list, tuple)) or not all(isinstance(group, dict) and group
                                                              for group in whole["zip"]):
        refuse(source, "zip", whole["zip"], "tables of lists")
    for key, value in whole["options"].items():
        if not is_plain(value):
            refuse(source, f"options.{key}", value, "a number, a text, or true or false; lists belong into vary")
    if whole["table"] is not None and not all(isinstance(name, str) for name in whole["table"]):
        refuse(source, "table", whole["table"], "a list of names of columns")
    if whole["spin_up"] is not None:
        try:
            parsed(whole["spin_up"])
        except Error as error:
            raise Error(f"{source}: {error}") from None
    for k, name in enumerate(whole["table"] or ()):
        if name in table.RESERVED or name in whole["table"][:k]:
            raise Error(f"{source}: table names {name}, which is "
                        f"{'a column of each table' if name in table.RESERVED else 'there twice'}: expected other "
                        "columns, each once")
    whole["seeds"] = seeds_of(source, whole["seeds"])
    return whole


def axes_of(source, whole):
    """What is varied: for each axis its names, and for each of its positions their values."""
    axes = [((key,), [(value,) for value in values_of(source, f"vary.{key}", given)])
            for key, given in whole["vary"].items()]
    for group in whole["zip"]:
        lists = [values_of_zip(source, f"zip.{key}", given) for key, given in group.items()]
        if len(set(map(len, lists))) > 1:
            refuse(source, "zip", {key: len(values) for key, values in zip(group, lists)}, "lists of one length")
        axes.append((tuple(group), list(zip(*lists))))
    if whole["seeds"]:
        axes.append((("seed",), [(seed,) for seed in whole["seeds"]]))
    names = [name for names, _ in axes for name in names]
    for name in names:
        if names.count(name) > 1:
            raise Error(f"{source}: {name} is varied twice, expected once in vary, zip and seeds")
        if name in whole["options"]:
            raise Error(f"{source}: {name} is in options and varied, expected one of them")
        if name in table.RESERVED:
            raise Error(f"{source}: {name} is varied, and is a column of each table: expected another name")
        if name in (whole["table"] or ()):
            raise Error(f"{source}: table names {name}, which is varied and has a column of its own; expected "
                        "what runs find")
    return axes


def values_of_zip(source, key, given):
    """As of vary, but one value may be there several times: the rows of a zip differ, not its columns."""
    if isinstance(given, (list, tuple)) and given and all(map(is_plain, given)):
        return list(given)
    return values_of(source, key, given)


def filled(text, places):
    """A text with its {seed}, {folder} and varied names in place."""
    return re.sub(r"\{(\w+)\}", lambda m: word(places[m[1]]) if m[1] in places else m[0], text)


def option_name(command, name):
    """As the command line has it: faults' options may lack their "fault_"."""
    name = name.lstrip("-")
    return name if command != "fault" or OPTION.match(name) or name.startswith("fault_") else f"fault_{name}"


def digest(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


class Plan:
    """All runs of a study, in the order of the file: the last axis goes fastest.

    axes   what is varied, [(names, [values of each position])]
    runs   list of Planned
    """

    def __init__(self, source, given, base):
        self.source, self.base = source, base
        self.given = checked(source, given)
        self.axes = axes_of(source, self.given)
        self.command = self.given["command"]
        self.placed = "{" in self.command  # options go where the command has their names
        self.known = {}
        if math.prod(len(positions) for _, positions in self.axes) > MOST:
            raise Error(f"{source}: {math.prod(len(positions) for _, positions in self.axes)} runs, expected at "
                        f"most {MOST}")
        self.runs = [self.planned(number, values)
                     for number, values in enumerate(itertools.product(*(positions for _, positions in self.axes)), 1)]
        names = {}
        for run in self.runs:
            if run.name in names:
                raise Error(f"{source}: runs {names[run.name]} and {run.number} are the same, {run.values}: expected "
                            "runs that differ")
            names[run.name] = run.number
        if self.command == "fault":
            self.check_columns()

    def check_columns(self):
        """Error: a column that no run has, or that the options of all runs leave empty."""
        file = self.given["options_file"]
        of_file = dict.fromkeys(options_of(self.file(file))) if file else {}
        for name in self.given["table"] or ():
            table.check_name(self.source, name)
            needs = [table.missing(name, {**of_file, **{key.removeprefix("fault_"): value
                                                        for key, value in run.options.items()}}) for run in self.runs]
            if all(needs):
                raise Error(f"{self.source}: table names {name}, which needs {needs[0]}: no run has that, and the "
                            "column would be empty")

    def planned(self, number, positions):
        values = {name: value for (names, _), row in zip(self.axes, positions) for name, value in zip(names, row)}
        seed, ranks = values.get("seed"), values.get("ranks", self.given["ranks"])
        if not isinstance(ranks, int) or isinstance(ranks, bool) or ranks < 1:
            refuse(self.source, "ranks", ranks, "a number of ranks")
        options = {}
        places = {**self.given["options"], **values}
        for name, value in places.items():
            if name not in ("seed", "ranks"):
                key = name if self.placed else option_name(self.command, name)
                if key in options:
                    raise Error(f"{self.source}: {name} and another name of it are given, expected one")
                if self.command == "fault" and key.removeprefix("fault_") in OWN:
                    raise Error(f"{self.source}: {name} is of each run, whose files are in its folder: expected "
                                f"no {name}")
                options[key] = (filled(value, {k: v for k, v in places.items() if k != name}) if isinstance(value, str)
                                else value)
        return Planned(number, self.name(options, seed, values), values, options, seed, ranks)

    def file(self, name):
        return os.path.join(self.base, name)

    def digest(self, path):
        if path not in self.known:
            self.known[path] = digest(path)
        return self.known[path]

    def name(self, options, seed, values):
        """Twelve digits of a hash of all that decides what a run finds; ranks count where they are varied, as then
        their times are asked for."""
        file = self.given["options_file"]
        if file and not os.path.isfile(self.file(file)):
            raise Error(f"{self.source}: cannot read {file} (options_file) from {self.base}")
        texts = [*map(str, options.values()), *shlex.split(self.command), *shlex.split(self.given["before"] or ""),
                 *([file] if file else [])]
        files = {text: self.digest(self.file(text)) for text in texts if os.path.isfile(self.file(text))}
        content = [self.command, self.given["before"], sorted((name, word(value)) for name, value in options.items()),
                   seed, values.get("ranks"), file, sorted(files.items())]
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:12]

    def places(self, run, folder):
        """What braces stand for."""
        return {**run.options, **run.values, "seed": "" if run.seed is None else run.seed, "folder": folder,
                "ranks": run.ranks, "number": run.number}
