#!/usr/bin/env python3
"""Copy an output file without its fields and with few rows, small enough to keep under version control: the program slipstep.programs.compact; --help says how to use it."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.programs.compact import main

if __name__ == "__main__":
    main()
