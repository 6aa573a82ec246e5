"""Errors of runs."""


class Error(RuntimeError):
    """A run that could not be made: the line that the program prints, which names the option, file or dataset and what was expected."""
