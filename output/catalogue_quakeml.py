#!/usr/bin/env python3
"""The catalogue of a run as QuakeML 1.2: the program slipstep.programs.catalogue_quakeml; --help says how to use it."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.programs.catalogue_quakeml import main

if __name__ == "__main__":
    main()
