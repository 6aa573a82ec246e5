"""Numbers that papers quote of a run, from arrays; each is defined, with its source, in output/howto/numbers.md.

    from slipstep.numbers import rupture, source, stress, cycle      # NumPy alone
    slipstep.numbers.of_run(run, catalogue, "largest")               # all that a run has
"""

from .report import Number, of_catalogue, of_event, of_run
from .spinup import spin_up

__all__ = ["Number", "of_catalogue", "of_event", "of_run", "spin_up"]
