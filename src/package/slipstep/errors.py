"""Errors and warnings of runs and of their files."""

import os
import re
import sys
import warnings

HERE = os.path.dirname(__file__) + os.sep


class Error(RuntimeError):
    """A run that could not be made: the line that the program prints, which names the option, file or dataset and what
    was expected."""


class OutputError(Error):
    """A file cannot be read as SlipStep output; the message names the file and what was expected in it."""


class SlipStepWarning(UserWarning):
    """What a run warns of, a warning for each line that the program prints; warnings.filterwarnings("error",
    category=SlipStepWarning) makes errors of them."""


def warn(*lines):
    """A SlipStepWarning for each line, of the line of Python that called the package."""
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_code.co_filename.startswith(HERE):
        frame, level = frame.f_back, level + 1
    for line in lines:
        warnings.warn(line, SlipStepWarning, stacklevel=level)


def warnings_of(text):
    """Lines of different warnings in what programs have printed, in their order: of SlipStep's, and of Python."""
    return list(dict.fromkeys(re.findall(r"(?m)^\S+: (?:\w*Warning|warning): (.*)$", text)))
