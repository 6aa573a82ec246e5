#!/usr/bin/env python3
"""The files of a SEAS benchmark from a run of it, and a picture: the program slipstep.programs.seas; --help says how to use it."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.programs.seas import main

if __name__ == "__main__":
    main()
