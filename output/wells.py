#!/usr/bin/env python3
"""Pore pressure of wells, for -fault_pore_pressure: the program slipstep.programs.wells; --help says how to use it."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.programs.wells import main

if __name__ == "__main__":
    main()
