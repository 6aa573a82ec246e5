#!/usr/bin/env python3
"""A report of a run as one HTML file: the program slipstep.programs.report; --help says how to use it."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.programs.report import main

if __name__ == "__main__":
    main()
