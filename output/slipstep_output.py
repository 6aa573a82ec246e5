"""slipstep_output of before version 0.4, for scripts that import it: from slipstep import Run."""

import os
import sys
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep import OutputError, Run

warnings.warn("slipstep_output has moved: from slipstep import Run", FutureWarning, stacklevel=2)
