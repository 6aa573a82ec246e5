"""Text files of other programs, whose errors name the file, the line and what was expected."""

import gzip
import math
import os

from ..errors import Error


LARGE = 1e40  # beyond any number of a file: moments in dyne cm are below 1e31
NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?![\w.])"  # as a group of a regular expression


def unused(said, used, what="key"):
    """What is said of names that a reader does not use: one entry for all, none without."""
    left = [name for name in dict.fromkeys(said) if name not in used]
    return [f"{what}{'s' * (len(left) > 1)} {', '.join(left)}"] if left else []


def beyond(rows, count):
    """What is said of words of rows beyond those that a reader uses."""
    more = max((len(words) for words in rows), default=0) - count
    return [f"{more} column{'s' * (more > 1)} after the first {count}"] if more > 0 else []


class FormatError(Error):
    """A file of another program that cannot be read: its name, the line, what is there and what was expected."""


class Text:
    """The lines of a text file, counted from 1. Compressed by gzip, it is read likewise."""

    def __init__(self, path):
        self.path = os.fspath(path)
        opened = gzip.open if self.path.endswith(".gz") else open
        try:
            with opened(self.path, "rb") as file:
                content = file.read()
        except (OSError, EOFError) as error:
            raise FormatError(f"{self.path}: {getattr(error, 'strerror', None) or error}, expected a "
                              "file to read") from None
        if b"\0" in content:
            raise FormatError(f"{self.path}: not a text file, expected one")
        self.lines = content.decode(errors="replace").splitlines()

    def __len__(self):
        return len(self.lines)

    def __iter__(self):
        """Numbers of lines and lines."""
        return iter(enumerate(self.lines, 1))

    def fail(self, line, found, expected):
        """Raises the error of a line; beyond the last one the file has ended too early."""
        if line > len(self.lines):
            raise FormatError(f"{self.path} ends after line {len(self.lines)}{' with ' * bool(found)}{found}, expected "
                              f"{expected}")
        raise FormatError(f"{self.path}, line {line}: {found}, expected {expected}")

    def quoted(self, line):
        return f"\"{self.lines[line - 1].strip()[:60]}\""

    def number(self, line, word, what="a number"):
        """A number that is not beyond all bounds; Fortran's d is an e."""
        try:
            value = float(word.lower().replace("d", "e"))
        except ValueError:
            value = math.nan
        if not abs(value) <= LARGE:
            self.fail(line, f"\"{word[:40]}\"", what)
        return value

    def whole(self, line, word, what="a whole number"):
        value = self.number(line, word, what)
        if value != int(value):
            self.fail(line, f"\"{word[:40]}\"", what)
        return int(value)

    def numbers(self, line, count, what):
        """So many numbers, at least, that a line begins with."""
        if line > len(self.lines):
            self.fail(line, "", what)
        words = self.lines[line - 1].replace(",", " ").split()
        if len(words) < count:
            self.fail(line, f"{len(words)} words", what)
        return [self.number(line, word, what) for word in words[:count]]
