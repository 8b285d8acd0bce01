"""Commands that the pages name, in blocks, tables and lines: each has the words and files it says.

None is run here: pgimp's are read by their own parsers, those of scripts by what their head says.
"""

import re
import shlex

import pytest
from pages import FENCE, LINKED, PAGES, ROOT

from pgimp.cli import parser_of
from pgimp.commands import COMMANDS
from pgimp.commands.init import packaged
from pgimp.errors import UsageError
from pgimp.utilities.element.paths import PATHS

TEXTS = {**PAGES, "cases/README.md": LINKED["cases/README.md"]}
#: What may come before pgimp or a script.
BEFORE = re.compile(r'(\S*(mpirun|srun|salloc)( -n \S+)? |python |eval "\$\()?')
COMMAND = re.compile(BEFORE.pattern + r"(?P<command>(pgimp|scripts/[\w./-]+)( .*)?)")
#: Files that readers have, or get by what the pages tell them.
THEIRS = ("case.yaml", "my-case.yaml", "mine.yaml")
PLACEHOLDER = re.compile(r"\[?[A-Z]+\d?(\.yaml|\.py|\.out)?(\.\.\.)?\]?")
#: Options of mpirun, pytest, Slurm and EasyBuild.
FOREIGN = {
    "--mpi", "--hypothesis-profile", "--mem", "--signal", "--robot", "--sourcepath", "--map-by",
    "--bind-to", "--cpu-set", "--mca", "--oversubscribe",
}  # fmt: skip


def spans(text):
    """What stands between backquotes in lines, and the lines of blocks for a shell."""
    for language, block in FENCE.findall(text):
        if language in ("sh", "text"):
            yield from block.splitlines()
    yield from (" ".join(code.split()) for code in re.findall(r"`([^`]+)`", FENCE.sub("", text)))


def named():
    """Page and words of every command, each once."""
    found = {}
    for page, text in TEXTS.items():
        for span in spans(text):
            match = COMMAND.fullmatch(span.replace("\\|", "|"))
            if match and not re.fullmatch(r"pgimp|scripts/(\w+/)*", match["command"]):
                command = match["command"].removesuffix(')"').partition(" > ")[0]
                found.setdefault(tuple(shlex.split(command, comments=True)), page)
    return [(page, list(words)) for words, page in found.items()]


NAMED = named()


def lenient(name):
    """The parser of a command to which words may be missing: `pgimp plot --field damage`."""
    parser = parser_of(name)
    for action in parser._actions:
        action.required = False
    return parser


def head(script):
    """What a script says of itself, or a program of the scripts in whole."""
    text = (ROOT / script).read_text(encoding="utf-8")
    if script.endswith(".py"):
        return text
    return "\n".join(re.findall(r"^#(?!!)(.*)", text.partition("\nset -e")[0], re.MULTILINE))


def check_files(words):
    """What looks like a file is one of the repository's, or one of the reader's own."""
    for word in words:
        if re.match(r"(cases|tests|scripts)/", word) or word.endswith(".yaml"):
            there = (ROOT / word.replace("NAME", "disks")).exists()
            assert there or word in THEIRS or PLACEHOLDER.fullmatch(word), f"there is no {word}"


def check_script(script, words):
    """Words are in what the script says of itself, or a file, a number, or for what it starts."""
    said = head(script)
    if script == "scripts/run":
        check_files(words)
        lenient("run").parse_args(re.sub(r"(^| )-n \d+(?= |$)", "", shlex.join(words)).split())
        return
    if script == "scripts/test":  # pytest's words are its own
        check_files(words)
        words = [word for word in words if word.startswith("--")]
    for word in words:
        names = [word.partition("=")[0]]
        if not word.startswith("-"):  # a scene may have something added to its name: 3D-own
            names.append(word.removesuffix("-own"))
        known = any(re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", said) for name in names)
        assert known or word.isdecimal(), f"{script} does not know {word}"


def check_values(name, arguments):
    """Cases, paths, fields and columns are some that there are, as the reference has them."""
    reference = LINKED["cases/reference.md"]
    if name == "run":
        assert arguments.case is None or arguments.case.endswith(".yaml")
    elif name == "init" and arguments.name not in (None, "NAME"):
        assert {arguments.name, f"studies/{arguments.name}"} & {*packaged()}
    elif name == "element":
        assert arguments.path is None or arguments.path in PATHS
    elif name == "plot":
        if field := (arguments.field or "").partition(".")[0].removeprefix("parameter-"):
            # Also a parameter of a material, or the state of one that comes with the cases.
            softening = (ROOT / "cases" / "softening.py").read_text(encoding="utf-8")
            found = re.search(rf"[`.]{field}`", reference) or f'State("{field}"' in softening
            assert found, f"there is no field {field}"
        columns = [arguments.x or "", *(arguments.columns or "").split(",")]
        for column in filter(None, columns):
            general = re.sub(r"^(\w+)\.[\w*]+(?=[.-])", r"\1.NAME", column)
            general = re.sub("-[xyz]$", "-AXIS", general)
            assert f"`{general}`" in reference, f"there is no column {column}"


def test_there_are_many():
    assert len(NAMED) > 120
    assert {words[1] for _, words in NAMED if words[0] == "pgimp" and len(words) > 1} > {*COMMANDS}


@pytest.mark.parametrize(("page", "words"), NAMED, ids=[shlex.join(words) for _, words in NAMED])
def test_named_commands_have_these_words_and_files(page, words):
    program, *rest = words
    if program != "pgimp":
        assert (ROOT / program).is_file(), f"{page}: there is no {program}"
        check_script(program, rest)
        return
    check_files(rest)
    rest = [word.strip("[]").removesuffix("...") for word in rest]
    name, rest = (rest[0], rest[1:]) if rest[0] in COMMANDS else ("run", rest)
    if words[-1] == "--import":  # without its file
        rest += ["FILE.py"]
    try:
        arguments = lenient(name).parse_args(rest)
    except UsageError as error:
        pytest.fail(f"{page}: {shlex.join(words)}: {error}")
    check_values(name, arguments)


def test_options_named_alone_exist():
    """As `--wall-time HH:MM:SS`: of a command of pgimp, or of a script."""
    parts = [parser_of(name).format_help() for name in ("run", *COMMANDS)]
    parts += [
        head(f"scripts/{path.name}") for path in (ROOT / "scripts").iterdir() if path.is_file()
    ]
    parts.append((ROOT / "cases" / "in_paraview.py").read_text(encoding="utf-8"))
    known = {option for part in parts for option in re.findall(r"--[a-z][\w-]*", part)} | FOREIGN
    found = [
        (page, option)
        for page, text in TEXTS.items()
        for span in spans(text)
        for option in re.findall(r"(?<![\w-])--[a-z][\w-]*", span)
    ]
    assert len(found) > 50
    for page, option in found:
        assert option in known, f"{page}: there is no option {option}"


@pytest.mark.parametrize("path", sorted((ROOT / "scripts").iterdir()), ids=lambda path: path.name)
def test_options_in_the_head_of_a_script_are_read_by_it(path):
    """In its own lines, or in the programs that it starts."""
    if path.is_dir() or path.suffix:
        return
    text = path.read_text(encoding="utf-8")
    said = head(f"scripts/{path.name}")
    body = text.partition("\nset -e")[2]
    for started, study in re.findall(r"\$root/(scripts/\w+)(?:\.py|/\w+\.py)?\" ?(\w*)", body):
        folder = ROOT / started / study
        body += "".join(p.read_text() for p in folder.rglob("*.py")) if folder.is_dir() else ""
    if path.name == "test":
        body += (ROOT / "tests" / "conftest.py").read_text()
    if not (lines := re.findall(r"^ +scripts/.*", said, re.MULTILINE)):
        pytest.fail("a script says first how it is started")
    for option in re.findall(r"--[a-z][\w-]*", "".join(lines)):
        named = f"{option[2:].replace('-', '_')}="  # as the studies' harness takes it
        ways = f'"{option}"', f"{option})", f"{option} ", named
        assert any(way in body for way in ways), option
