"""Results of runs: Result and open() as a user has them, Run and Catalogue as pictures and tables need them, and what
follows from those."""

from ..errors import Error, OutputError

try:
    from .catalogue import Catalogue
    from .result import Result, open
    from .run import Run
except ImportError as error:
    raise Error(f"results need h5py and NumPy ({error}); Debian's packages are python3-h5py and "
                "python3-numpy") from error

__all__ = ["Catalogue", "OutputError", "Result", "Run", "open"]
