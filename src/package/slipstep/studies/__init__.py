"""Studies of many runs: Study, its plan, its processes, its table and its job arrays."""

from .study import Study

__all__ = ["Study"]
