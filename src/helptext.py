"""Options of a program as it prints them on -help NAME: what man pages and the reference of options are made from."""

import os
import re
import subprocess

OPTION = re.compile(r"^  (-\w+):?(?: <(.*?)>)?:?\s(.*)$")


def printed(program):
    """What a program prints of its own options."""
    name = os.path.basename(program)
    done = subprocess.run([program, "-help", name], capture_output=True, text=True,
                          env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMPI_MCA_ess_singleton_isolated": "1"})
    if done.returncode or "options" not in done.stdout:
        raise SystemExit(f"{program} -help {name} failed: {done.stderr.strip() or done.stdout[-300:]}")
    return done.stdout


def default_of(text):
    """The default in PETSc's "now 10 : formerly 10", of switches yes or no."""
    found = re.match(r"(?:now )?(.*?) ?: ?(?:formerly )?(.*)$", text or "")
    value = (found[2] if found else text or "").strip()
    return {"FALSE": "no", "TRUE": "yes"}.get(value, value).rstrip(".")


def parse(text):
    """(paragraphs before the options, [(title, [(name, default, description)])])."""
    intro, sections = [], []
    for line in text.split("\n"):
        match = OPTION.match(line)
        if match:
            description = re.sub(r" \((?:\w*::)?[A-Za-z]\w*\)$", "", match[3].strip())  # the function that sets it
            choices = re.search(r"\(choose one of\) (.*)$", description)
            if choices:
                description = description[: choices.start()].rstrip() + f" Choices: {', '.join(choices[1].split())}"
            if sections:
                sections[-1][1].append((match[1], default_of(match[2]), description.lstrip(": ")))
        elif line.endswith(":") and not line.startswith(" "):
            sections.append((line.rstrip(":").strip(), []))
        elif not sections:
            intro.append(line)
    return "\n".join(intro).strip(), [(title, options) for title, options in sections if options]
