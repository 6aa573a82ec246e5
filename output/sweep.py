#!/usr/bin/env python3
"""A study of many runs: the program slipstep.programs.sweep; --help says how to use it."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.programs.sweep import main

if __name__ == "__main__":
    main()
