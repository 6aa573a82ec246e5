#!/usr/bin/env python3
"""Write the tables of RESULTS.md from the file of evaluate, so that none of their numbers is typed: the program slipstep.programs.results_table; --help says how to use it."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.programs.results_table import main

if __name__ == "__main__":
    main()
