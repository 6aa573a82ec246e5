#!/usr/bin/env python3
"""A man page of a program, from what it prints on -help (programs of PETSc) or --help (Python): man.py PROGRAM NAME
VERSION > NAME.1"""

import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from helptext import parse, printed


def escaped(text):
    """Plain text as roff has it."""
    return "\n".join(("\\&" if line[:1] in ".'" else "") + line
                     for line in text.replace("\\", "\\e").replace("-", "\\-").split("\n"))


def page(name, version, summary, body):
    return "\n".join([f'.TH {name.upper().replace("-", chr(92) + "-")} 1 "" "SlipStep {version}" "SlipStep"',
                      ".SH NAME", f"{escaped(name)} \\- {escaped(summary)}", *body,
                      ".SH SEE ALSO", "https://petsc.org for the options of PETSc"]) + "\n"


def of_petsc(program, name, version):
    intro, sections = parse(printed(program))
    own = os.path.basename(program).removeprefix("slipstep-")
    lines = re.sub(rf"(?m)^(\s*(?:mpirun -n \d+ )?){own}\b", rf"\1{name}", intro).split("\n")[1:]
    lines = [line for line in lines if line.strip()]
    summary = lines[0].split(".")[0] if lines else "a program of SlipStep"
    body = [".SH SYNOPSIS", f".B {escaped(name)}", "[\\-option value ...]", ".SH DESCRIPTION"]
    for line in lines:
        body += [".nf", escaped(line.strip()), ".fi"] if line.startswith("  ") else [".PP", escaped(line)]
    for title, options in sections:
        body.append(f".SH {escaped(title.removesuffix(' options').upper())}")
        for option, default, text in options:
            body += [".TP", f".BI {escaped(option)}",
                     escaped(text + (f" (default {default})" if default and "default" not in text else ""))]
    return page(name, version, summary[0].lower() + summary[1:], body)


def of_python(program, name, version):
    # slipstep NAME
    words = [name.removeprefix("slipstep-")] if os.path.basename(program) == "program.py" and name != "slipstep" else []
    text = subprocess.run([sys.executable, program, *words, "--help"], capture_output=True, text=True,
                          check=True).stdout
    text = text.replace(os.path.basename(program), name)
    usage, _, rest = text.partition("\n\n")
    summary, _, rest = rest.partition("\n\n")
    words = " ".join(summary.split()).split(". ")[0].rstrip(".")
    return page(name, version, words[:1].lower() + words[1:],
                [".SH SYNOPSIS", ".nf", escaped(re.sub(r"^usage: ", "", usage)), ".fi", ".SH DESCRIPTION",
                 escaped(" ".join(summary.split())),
                 ".SH OPTIONS", ".nf", escaped(rest), ".fi"])


def main():
    program, name, version = sys.argv[1:4]
    sys.stdout.write((of_python if program.endswith(".py") else of_petsc)(program, name, version))


if __name__ == "__main__":
    main()
