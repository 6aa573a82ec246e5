#!/usr/bin/env python3
"""The program slipstep: of a build a link to this file, installed a copy; Debian's python3 finds the package by
itself."""

import os
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path[0] = (HERE if os.path.isdir(os.path.join(HERE, "slipstep"))
               else os.path.join(HERE, "..", "share", "slipstep", "python"))
from slipstep.__main__ import main

if __name__ == "__main__":
    main()
