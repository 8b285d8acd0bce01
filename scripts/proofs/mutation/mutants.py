"""Mutated case files: wrong types, numbers, structure, text, encodings, and what means harm."""

import gzip
import json
import re
from copy import deepcopy
from pathlib import Path

from proofs.mutation.harmful import EXECUTE, TRACE, enlarge, hostile

from pgimp.schema.document import parse

ROOT = Path(__file__).resolve().parents[3]
FILES = sorted([*ROOT.glob("cases/*.yaml"), *ROOT.glob("cases/hard/*.yaml")])
STUDIES = sorted(ROOT.glob("cases/studies/*.yaml"))
NUMBERS = [
    0, 0.0, -0.0, 1, -1, 0.5, 1e-300, 5e-324, 1e308, -1e308, 1.7976931348623157e308, 1e-9, 1e9,
    1e15, 1e30, 2**31, 2**31 - 1, 2**53, 2**53 + 1, 2**63, 2**64, 10**30, 10**400, -(10**30),
    float("nan"), float("inf"), float("-inf"), 1.0000001, 3, 7, 1000, 100000,
]  # fmt: skip
VALUES = [
    None, True, False, "", " ", "x", "1.0", "1e6", "yes", "null", "[]", "\u0000", "a\nb",
    "\x1b[31m", "\u202e", "\ud7ff", "😀" * 40, "é", "x" * 5000, "2001-01-01", "0o17", "0b11",
    "1_000", "12:30:45", [], {}, [[]], [{}], {"a": {}}, {"": 1}, {"a b": 1}, [1] * 500, [None],
    "../../etc/passwd", "${HOME}", "$(id)", "{{7*7}}", "%s%n", "__import__('os')", "fixed", "gimp",
    "hooke", "mpm", "box", {"box": {}}, {"courant": 0.3}, {"steps": 1}, {"table": [[0, 0]]}, [0.0],
]  # fmt: skip
TOKENS = [
    "{", "}", "[", "]", ":", ": ", "- ", ",", '"', "'", "\n", "  ", "\t", "#", "&a ", "*a", "!t ",
    "|\n", ">\n", "? ", "%YAML 1.1\n", "%TAG ! x\n", "---\n", "...\n", "<<: *a\n", "0o7", "0x1F",
    "1e309", "-0.0", ".nan", ".inf", "2001-01-01", "1_000", "0b11", "~", "null", "\r", "\x85",
    "\u2028", "\ufeff", "😀", "@", "`", "=", "\\x", "9" * 400, "\x00", "\x07", "\x7f", "e", "E5",
    "+", "../", "%",
]  # fmt: skip


def render(value):
    """YAML of data: JSON, but for numbers that JSON does not have."""
    if isinstance(value, float) and value != value:
        return ".nan"
    if isinstance(value, float) and abs(value) == float("inf"):
        return ".inf" if value > 0 else "-.inf"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)}: {render(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(render, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def places(data, path=()):
    """Paths of all parts of data."""
    if isinstance(data, list):
        data = dict(enumerate(data))
    for key, value in data.items() if isinstance(data, dict) else ():
        yield (*path, key)
        yield from places(value, (*path, key))


def at(data, path):
    for key in path:
        data = data[key]
    return data


def put(data, path, value):
    at(data, path[:-1])[path[-1]] = value


class Mutator:
    """Makes mutants, the same for the same random numbers of `chance`.

    Each kind is a method that returns the content of a file and further words of a command line.
    """

    def __init__(self, chance):
        self.chance = chance
        self.texts = [path.read_text(encoding="utf-8") for path in FILES]
        self.studies = [path.read_text(encoding="utf-8") for path in STUDIES]

    def case(self):
        return parse(self.chance.choice(self.texts), "case").data

    def text(self):
        """Text of one of the cases, without its comments."""
        return re.sub(r"(?m)\s*#.*$", "", self.chance.choice(self.texts))

    def make(self, kind):
        return getattr(self, kind)()

    def types(self):
        """Values of other types in a few places."""
        data = self.case()
        for _ in range(self.chance.choice((1, 1, 1, 2, 4))):
            path = self.chance.choice(list(places(data)))
            put(data, path, deepcopy(self.chance.choice(VALUES)))
        return render(data).encode("utf-8", "surrogatepass"), []

    def ranges(self):
        """Other numbers in a few places."""
        data = self.case()
        for _ in range(self.chance.choice((1, 1, 2, 3))):
            numbers = [p for p in places(data) if type(at(data, p)) in (int, float)]
            path = self.chance.choice(numbers)
            old = float(min(at(data, path), 2**1000))
            times = (-1, 1 / 3, 2, 10, 0.1, 1e6, 1e-6, 1 + 1e-12, 1e300, 1e-300)
            near = [old + 1, *(old * factor for factor in times)]
            put(data, path, self.chance.choice([*NUMBERS, *near]))
        return render(data).encode(), []

    def structure(self):
        """Keys dropped, doubled, renamed, swapped, moved, wrapped."""
        data = self.case()
        for _ in range(self.chance.choice((1, 1, 2, 3))):
            paths = list(places(data))
            if not paths:
                break
            path = self.chance.choice(paths)
            parent, value = at(data, path[:-1]), at(data, path)
            how = self.chance.randrange(8)
            if how == 0:
                del parent[path[-1]]
            elif how == 1 and isinstance(parent, list):
                parent.insert(path[-1], deepcopy(value))
            elif how in (1, 2) and isinstance(parent, dict):
                parent[self.typo(str(path[-1]))] = parent.pop(path[-1])
            elif how == 3:
                put(data, path, [value])
            elif how == 4:
                put(data, path, {self.chance.choice(("table", "box", "union", "x")): value})
            elif how == 5:
                put(data, path, deepcopy(at(data, self.chance.choice(paths))))
            elif how == 6 and isinstance(value, dict):
                value[self.chance.choice(("name", "end", "", "a.b", "0", "é"))] = 1
            elif how == 7:
                other = self.chance.choice(paths)
                if other[: len(path)] != path and path[: len(other)] != other:
                    there = at(data, other)
                    put(data, other, value)
                    put(data, path, there)
        text = render(data)
        if self.chance.random() < 0.2:  # twice the same key
            text = text[:-1] + ", " + text[1:]
        return text.encode(), []

    def typo(self, word):
        """Return a word with a letter dropped, doubled or exchanged."""
        i = self.chance.randrange(max(1, len(word)))
        return self.chance.choice(
            (word[:i] + word[i + 1 :], word[:i] + word[i : i + 1] * 2 + word[i + 1 :],
             word[:i] + "_" + word[i + 1 :], word.upper(), word + " ", word * 300)
        )  # fmt: skip

    def letters(self):
        """Text with pieces inserted, removed, doubled; lines moved and indented."""
        text = self.text()
        for _ in range(self.chance.choice((1, 1, 2, 3, 8))):
            i, j = (self.chance.randrange(len(text) + 1) for _ in range(2))
            lines = text.split("\n")
            row = self.chance.randrange(len(lines))
            how = self.chance.randrange(7)
            if how <= 1:
                text = text[:i] + self.chance.choice(TOKENS) + text[i:]
            elif how == 2:
                text = text[:i] + text[i + self.chance.randrange(1, 12) :]
            elif how == 3:
                text = text[:i] + text[j : j + self.chance.randrange(60)] + text[i:]
            elif how == 4:
                lines[row] = self.chance.choice((" ", "  ", "\t", "- ")) + lines[row]
                text = "\n".join(lines)
            elif how == 5:
                lines.insert(self.chance.randrange(len(lines)), lines.pop(row))
                text = "\n".join(lines)
            else:
                text = text[:i]
        return text.encode("utf-8", "surrogatepass"), []

    def encodings(self):
        """Bytes that are no UTF-8, or not only."""
        text = self.text().replace("title: ", "title: Höhe ", 1)
        data = text.encode()
        i = self.chance.randrange(len(data))
        noise = self.chance.randbytes(self.chance.choice((1, 2, 50)))
        codes = (
            "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1", "cp037", "utf-7", "utf-8-sig",
        )  # fmt: skip
        return self.chance.choice((
            text.encode(self.chance.choice(codes), "replace"),
            data[:i] + noise + data[i:],
            bytes(b ^ (1 << self.chance.randrange(8)) if k == i else b for k, b in enumerate(data)),
            self.chance.randbytes(self.chance.choice((0, 1, 100, 100_000))),
            gzip.compress(data, mtime=0),
            data.replace(b"\n", self.chance.choice((b"\r", b"\r\n", b"\n\n", b"\x0b", b"\x00"))),
            data[:i] + b"\xc0\xae\xed\xa0\x80\xf5" + data[i:],
            b"\xef\xbb\xbf" * self.chance.choice((1, 2)) + data,
            data[:i] + b"\x00" * 100 + data[i:],
        )), []  # fmt: skip

    def hostile(self):
        """YAML that would do something in other readers, or never end."""
        return hostile(self.text(), self.chance).encode("utf-8", "surrogatepass"), []

    def sizes(self):
        """Cases far larger than any machine."""
        data = self.case()
        enlarge(data, self.chance)
        try:
            return render(data).encode()[:4_100_000], []
        except RecursionError:
            return b"a: " + b"{b: " * 10_000, []

    def overrides(self):
        """A good case, and --set with anything."""
        data = self.case()
        words = []
        for _ in range(self.chance.choice((1, 1, 2, 3))):
            path = [str(part) for part in self.chance.choice(list(places(data)))]
            how = self.chance.randrange(6)
            if how == 0:
                path[self.chance.randrange(len(path))] = self.typo(path[-1])
            elif how == 1:
                path += [self.chance.choice(("x", "0", "-1", "999999999999", "", ".", "é"))] * 2
            elif how == 2:
                path *= 40
            value = self.chance.choice([
                *map(render, NUMBERS), *map(render, VALUES), *TOKENS, "", "[" * 100, "{" * 5000,
                EXECUTE, "&a [*a]", "--set", "1" * 5000,
            ])  # fmt: skip
            word = self.chance.choice((f"{'.'.join(path)}={value}", value, ".".join(path)))
            # No process can be given these.
            word = word.replace("\x00", "").encode("utf-8", "ignore").decode()
            words += ["--set", word] if not word.startswith("--") else [f"--set={word}"]
        return render(data).encode(), words

    def study(self):
        """A mutated study, whose runs are listed only."""
        text = self.chance.choice(self.studies).replace("../", f"{ROOT}/cases/")
        text = re.sub(r"(?m)\s*#.*$", "", text)
        if self.chance.random() < 0.3:
            i = self.chance.randrange(len(text))
            text = text[:i] + self.chance.choice(TOKENS) + text[i + self.chance.randrange(5) :]
            return text.encode("utf-8", "surrogatepass"), []
        data = parse(text, "study").data
        for _ in range(self.chance.choice((1, 1, 2, 3))):
            path = self.chance.choice(list(places(data)))
            other = [*VALUES, *NUMBERS, f"touch {TRACE}", ["sh", "-c", f"touch {TRACE}"]]
            put(data, path, deepcopy(self.chance.choice(other)))
        if self.chance.random() < 0.3:
            data["launcher"] = [
                "sh", "-c", f"touch {TRACE}", self.chance.choice(("", "\x00", "{ranks}")),
            ]  # fmt: skip
            data["ranks"] = self.chance.choice((2, 10**9, 2**53))
        if self.chance.random() < 0.1:
            data["sweep"] = [{"grid.cell": [[1.0]] * 30}] * self.chance.choice((1, 2, 9))
        return render(data).encode("utf-8", "surrogatepass"), []


KINDS = (
    "types", "ranges", "structure", "letters", "encodings", "hostile", "sizes", "overrides",
    "study",
)  # fmt: skip
