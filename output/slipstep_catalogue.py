"""slipstep_catalogue of before version 0.4, for scripts that import it: from slipstep import Catalogue."""

import os
import sys
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep import Catalogue

warnings.warn("slipstep_catalogue has moved: from slipstep import Catalogue", FutureWarning, stacklevel=2)
