"""Tables of numbers in text from other programs: encodings, separators, quotes, decimal commas.

The line of names says what separates columns: tabs, semicolons, commas or spaces, in this order. A
comma in a number is a decimal one where it cannot separate columns. What can be read in two ways is
refused.
"""

from __future__ import annotations

import codecs
import csv
import re

import numpy as np
from numpy.typing import NDArray

from pgimp.errors import CaseError

#: Integers as decimal commas between commas leave them.
_PIECE = re.compile(r"[-+]?\d+([eE][-+]?\d+)?")

#: A number whose comma may also separate thousands.
_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")
_WORD = re.compile(r"[^\s;\"]*,[^\s;\"]*")


def encoding_of(begin: bytes) -> str:
    """Return the encoding of a text by its first bytes, as Python names it.

    Raises
    ------
    CaseError
        If it is UTF-16 or UTF-32 without its mark, or no text.
    """
    if begin.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        return "utf-32"
    if begin.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    if b"\0" in begin:
        raise CaseError(
            "it has zero bytes: it is no text, or UTF-16 without its mark; save it as UTF-8"
        )
    return "utf-8-sig"


def decoded(content: bytes) -> str:
    """Return the text of a whole file.

    Raises
    ------
    CaseError
        If it is no text in UTF-8, UTF-16 or UTF-32.
    """
    encoding = encoding_of(content[:4096])
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        name = encoding.removesuffix("-sig").upper()
        line = content.count(b"\n", 0, error.start) + 1
        raise CaseError(f"line {line}: it is no text in {name}; save it as UTF-8") from None


class Columns:
    """The columns of a table, by its line of names.

    Raises
    ------
    ValueError
        If its quotes cannot be read.

    Attributes
    ----------
    names : list of str
        As written, without quotes and spaces around them.
    separator : str or None
        Between columns; None for any spaces.
    """

    def __init__(self, line: str) -> None:
        bare = re.sub(r'"[^"]*"', "", line)
        marks = [mark for mark in "\t;," if mark in bare]
        self.separator = marks[0] if marks else None
        self._decimal, self._sure = "", False
        self._example = ""
        self.names = self._words(line)
        #: Whether each line ends with a separator.
        self._ends = len(self.names) > 1 and not self.names[-1]
        if self._ends:
            self.names.pop()

    def _words(self, line: str) -> list[str]:
        if '"' in line:
            if self.separator is None:
                line = " ".join(line.split())
            mark = self.separator or " "
            try:
                words = next(csv.reader([line], delimiter=mark, skipinitialspace=True))
            except csv.Error as error:
                raise ValueError(f"quotes that cannot be read: {error}") from None
        else:
            words = line.split(self.separator)
        return [word.strip() for word in words]

    def words(self, line: str) -> list[str]:
        """Return the values of a line as text, one for each column.

        Raises
        ------
        ValueError
            If there are more or fewer, with the likely cause.
        """
        words = self._words(line)
        if self._ends and words and not words[-1]:
            words.pop()
        if len(words) == len(self.names):
            return words
        text = f"{len(words)} values, expected {len(self.names)}"
        pieces = len(words) > len(self.names) and all(map(_PIECE.fullmatch, words))
        if self.separator == "," and pieces:
            text += (
                "; decimal commas cannot be told from commas between columns: export it with "
                "semicolons between columns, or with decimal points"
            )
        raise ValueError(text)

    def number(self, word: str) -> float:
        """Return the number that a word is.

        Raises
        ------
        ValueError
            If it is none, or has another decimal mark than those before; the reason.
        """
        usual = word
        if "," in word:
            if "." in word or word.count(",") > 1:
                raise ValueError("has separators of thousands; export it without them")
            self._take(",")
            usual = word.replace(",", ".")
            self._note(word)
        elif "." in word:
            self._take(".")
        try:
            return float(usual) if "_" not in usual else float("no")  # Python takes 1_0 for 10
        except ValueError:
            raise ValueError("is no number") from None

    def _take(self, decimal: str) -> None:
        if self._decimal not in ("", decimal):
            names = {",": "a decimal comma", ".": "a decimal point"}
            raise ValueError(f"has {names[decimal]}, but numbers before it {names[self._decimal]}s")
        self._decimal = decimal

    def _note(self, word: str) -> None:
        if _THOUSANDS.fullmatch(word):
            self._example = self._example or word
        else:
            self._sure = True

    def block(self, lines: list[str]) -> NDArray[np.float64] | None:
        """Return the numbers of lines at once, (n, columns); None where lines must be read singly.

        Parameters
        ----------
        lines : list of str
            None of them empty.
        """
        text = "\n".join(lines)
        if '"' in text:
            return None
        if self.separator != "," and "," in text:
            if "." in text or self._decimal == "." or re.search(r",[^\s;]*,", text):
                return None
            self._decimal = ","
            if not self._sure:
                for word in _WORD.findall(text):
                    self._note(word)
                    if self._sure:
                        break
            text = text.replace(",", ".")
        elif "." in text:
            if self._decimal == ",":
                return None
            self._decimal = "."
        try:
            values = np.loadtxt(text.split("\n"), delimiter=self.separator, ndmin=2, comments=None)
        except ValueError:
            return None
        return values if values.shape == (len(lines), len(self.names)) else None

    def finish(self) -> None:
        """Ensure, after the last line, that commas in numbers can only be decimal ones.

        Raises
        ------
        ValueError
            If all of them may also separate thousands.
        """
        if self._example and not self._sure:
            raise ValueError(
                f"'{self._example}' may be {self._example.replace(',', '.')} or "
                f"{self._example.replace(',', '')}, as all its numbers with commas; export it with "
                "decimal points"
            )
