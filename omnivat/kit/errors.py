"""Errors with one clear sentence: what was given, what was expected, what to do."""

LONGEST = 2000  # letters of a message


def printable(text: str) -> str:
    """Return `text` with escapes for all characters that cannot be printed on one line."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def shortened(text: str) -> str:
    """Return a sentence without its middle if it lists thousands of names."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} … {text[-LONGEST // 4 :]}"


def first_line(error: BaseException, most: int = 120) -> str:
    """Return the first line of an error's text, at most `most` letters; its kind if it has none."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:most]


class OmniVatError(Exception):
    """An error that the user can fix. The command line prints its sentence and exits with 1.

    The sentence may quote names from any file, so it is always made printable.
    """

    def __str__(self) -> str:  # KeyError would print the sentence in quotation marks
        return printable(shortened(str(self.args[0]))) if self.args else ""


class ShapeError(OmniVatError, ValueError):
    """A tensor has the wrong axes."""


class SettingsError(OmniVatError, ValueError):
    """A setting is unknown or out of range."""


class DataError(OmniVatError, ValueError):
    """A file, folder or table is invalid."""


class WriteError(OmniVatError, OSError):
    """A file or folder cannot be written."""


class MissingNameError(OmniVatError, KeyError):
    """A table has no entry of that name."""


class MissingPackageError(OmniVatError, ImportError):
    """An optional package is needed and not installed."""
