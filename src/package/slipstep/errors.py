"""Errors of runs and of their files."""


class Error(RuntimeError):
    """A run that could not be made: the line that the program prints, which names the option, file or dataset and what was expected."""


class OutputError(Error):
    """A file cannot be read as SlipStep output; the message names the file and what was expected in it."""
