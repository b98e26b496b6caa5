"""Errors with one clear sentence: what came, what was wanted, what to do."""


def printable(text: str) -> str:
    """Return `text` with whatever cannot be printed on one line written as an escape."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


class OmniVatError(Exception):
    """Anything a person can put right. The command line prints its sentence and exits with 1.

    A sentence quotes names and cells from other people's files, so it is always made printable.
    """

    def __str__(self) -> str:  # KeyError would also print the sentence in quotation marks
        return printable(str(self.args[0])) if self.args else ""


class ShapeError(OmniVatError, ValueError):
    """A tensor has the wrong axes."""


class SettingsError(OmniVatError, ValueError):
    """A setting is unknown or out of range."""


class DataError(OmniVatError, ValueError):
    """A file, folder or table is not what it should be."""


class WriteError(OmniVatError, OSError):
    """A file or folder cannot be written."""


class MissingNameError(OmniVatError, KeyError):
    """A table has no entry of that name."""


class MissingPackageError(OmniVatError, ImportError):
    """An optional package is needed and not installed."""
