"""slipstep_surface of before version 0.4, for scripts that import it: from slipstep.geometry.surface import Elastic, slip_of_run."""

import os
import sys
import warnings

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "src", "package"))  # of the source; in an installation it is beside this file
from slipstep.geometry.surface import Elastic, Source, look_vector, slip_of_event, slip_of_run

warnings.warn("slipstep_surface has moved: from slipstep.geometry.surface import Elastic, slip_of_run", FutureWarning, stacklevel=2)
