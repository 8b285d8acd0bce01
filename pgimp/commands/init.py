"""``pgimp init``: writes one of pgimp's packaged cases, to start from."""

from __future__ import annotations

import argparse
import difflib
import json
import re
import shlex
from collections.abc import Iterator
from importlib.resources import files as installed
from pathlib import Path

from pgimp.errors import UsageError
from pgimp.storage.plain import read_plain

#: Schemas for editors, beside the case and beside the study.
SCHEMA, STUDY_SCHEMA = "pgimp-schema.json", "pgimp-study-schema.json"

_STUDIES = "studies/"
#: The study that belongs to `--case`.
ACCURACY = "studies/accuracy"
# Most bytes of files beside a case, far more than any packaged mesh.
_LARGEST = 64 << 20
_FILE = re.compile(r"^ *file: ([\w.-]+)", re.MULTILINE)
_IMPORT = re.compile(r"--import cases/([\w.-]+\.py)")
_LINE = "# yaml-language-server: $schema="
_OTHER_WAY = re.compile(r"\n#? *\(or: scripts/run [^)]*\)|[ \t]*\(or: scripts/run [^)]*\)")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command line."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="the case; without, all are listed")
    parser.add_argument(
        "--case",
        metavar="CASE.yaml",
        help="with the name accuracy: the case whose error the study is to find",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE.yaml",
        help="the file to write (default: the name with .yaml, here)",
    )


def execute(args: argparse.Namespace) -> int:
    """Run the command.

    Returns
    -------
    int
        The exit status, 0.

    Raises
    ------
    UsageError
        If there is no such case, or if the file exists or cannot be written.
    """
    cases = packaged()
    if args.name is None:
        if args.output:
            raise UsageError("which case is to be written? Without a name, pgimp init lists them")
        print("\n".join(_list(cases)))
        return 0
    name = args.name.removeprefix("cases/").removesuffix(".yaml")
    if name not in cases and _STUDIES + name in cases:
        name = _STUDIES + name
    if name not in cases:
        raise UsageError(_unknown(name, cases))
    if args.case:
        if name != ACCURACY:
            raise UsageError("--case goes with the name accuracy")
        return _write_accuracy(args.case, args.output)
    study = name.startswith(_STUDIES)
    stem = name.rpartition("/")[2]
    path = Path(args.output or f"{stem}{'-study' if study else ''}.yaml")
    _write(path, _personal(name, cases[name], path))
    print(f"{path}: written, with comments; pgimp schema --markdown explains every key there is")
    imports = [path.with_name(file) for file in _IMPORT.findall(cases[name])]
    for source in _beside(name, cases[name]):
        text = source.read_text(encoding="utf-8")
        _write_beside(path.with_name(source.name), text, "the case takes it as it is")
    if study:
        case = _case_of(cases[name])
        beside = _case_path(case, path)
        _write_beside(beside, _personal(case, cases[case], beside), "the study takes it as it is")
        _write_schema(path.with_name(STUDY_SCHEMA))
    _write_schema(path.with_name(SCHEMA))
    print("\n".join(_next(path, study, imports)))
    return 0


def _write_accuracy(case: str, output: str | None) -> int:
    """Write the study that finds the error of a case; return the exit status."""
    from pgimp.utilities.study.accuracy import study_of

    path = Path(output or f"{Path(case).stem}-accuracy.yaml")
    _write(path, f"{_LINE}{STUDY_SCHEMA}\n{study_of(case, path)}")
    print(f"{path}: written; choose there what is measured (`error`), and when (`time.end`)")
    _write_schema(path.with_name(STUDY_SCHEMA))
    print("\n".join(_next(path, True, [])))
    return 0


def packaged() -> dict[str, str]:
    """Return the text of each packaged case and study, by name.

    The name is the path in the folder ``cases``, without the suffix.
    """

    def walk(folder: Path, before: str) -> Iterator[tuple[str, str]]:
        for entry in folder.iterdir():
            if entry.is_dir():
                yield from walk(entry, f"{before}{entry.name}/")
            elif entry.name.endswith(".yaml"):
                yield before + entry.name.removesuffix(".yaml"), entry.read_text(encoding="utf-8")

    order = {"": 0, _STUDIES: 1}
    found = dict(walk(_folder(), ""))

    def place(name: str) -> tuple[int, int, str]:
        folder = "".join(name.rpartition("/")[:2])
        return order.get(folder, 2), _dimensions(found[name]), name

    return {name: found[name] for name in sorted(found, key=place)}


def _folder() -> Path:
    return Path(str(installed("pgimp").joinpath("cases")))


def _beside(name: str, text: str) -> list[Path]:
    """Return the packaged files of a case: meshes, and Python files with its materials."""
    meshes = [_folder().joinpath(name).with_name(file) for file in _FILE.findall(text)]
    return meshes + [_folder() / file for file in _IMPORT.findall(text)]


def _dimensions(text: str) -> int:
    found = re.search(r"^dimensions: (\d)", text, re.MULTILINE)
    return int(found[1]) if found else 0


def _list(cases: dict[str, str]) -> list[str]:
    """Return a line for each case: name, dimensions, description."""
    width = max(map(len, cases))
    lines = ["Cases to start from; pgimp init NAME writes one here, with comments:"]
    for name, text in cases.items():
        kind = f"{_dimensions(text)}D" if _dimensions(text) else "study"
        summary = text.partition("\n")[0].lstrip("# ").rstrip(".")
        lines.append(f"  {name:<{width}}  {kind:<5}  {summary}")
    return lines


def _unknown(name: str, cases: dict[str, str]) -> str:
    ends = [case for case in cases if case.rpartition("/")[2] == name]
    near = ends or difflib.get_close_matches(name, cases, n=1)
    hint = f" Did you mean {' or '.join(near)}?" if near else ""
    return f"there is no case '{name}' to start from.{hint}\n" + "\n".join(_list(cases))


def _personal(name: str, text: str, path: Path) -> str:
    """Return a case adapted to its new path: commands with the path, a line for editors."""
    schema = SCHEMA
    if name.startswith(_STUDIES):
        case, schema = _case_of(text), STUDY_SCHEMA
        text = text.replace(f"../{case}.yaml", _case_path(case, path).name)
    for file in _IMPORT.findall(text):
        text = text.replace(f"cases/{file}", shlex.quote(str(path.with_name(file))))
        text = text.replace(f"../{file}", file)
    text = _OTHER_WAY.sub("", text).replace(f"cases/{name}.yaml", shlex.quote(str(path)))
    return f"{_LINE}{schema}\n{text}"


def _case_of(study: str) -> str:
    """Return the name of a study's case."""
    found = re.search(r"^case: \.\./([\w/-]+)\.yaml", study, re.MULTILINE)
    if found is None:
        raise ValueError("a study in cases/studies names its case as ../NAME.yaml")
    return found[1]


def _case_path(case: str, study: Path) -> Path:
    """Return the path of a study's case: beside the study."""
    beside = study.with_name(f"{case.rpartition('/')[2]}.yaml")
    if beside == study:
        raise UsageError(f"{beside} is the name of the study's case; give the study another one")
    return beside


def _write(path: Path, text: str) -> None:
    """Write a new file.

    Raises
    ------
    UsageError
        If the file exists, and then stays unchanged, or if it cannot be written.
    """
    try:
        with open(path, "x", encoding="utf-8") as file:
            try:
                file.write(text)
                file.flush()
            except OSError:
                path.unlink()
                raise
    except FileExistsError:
        raise UsageError(
            f"{path} is there already, and stays as it is; -o FILE.yaml names another file"
        ) from None
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from None


def _write_beside(path: Path, text: str, otherwise: str) -> None:
    """Write a file of the case, or report the consequence of an existing one."""
    try:
        there = read_plain(path, _LARGEST)
    except FileNotFoundError:
        _write(path, text)
        print(f"{path}: written")
        return
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from None
    if there != text.encode():
        print(f"{path}: there already, and left alone; {otherwise}")


def _write_schema(path: Path) -> None:
    from pgimp.utilities.reference.jsonschema import json_schema, study_schema

    study = path.name == STUDY_SCHEMA
    text = json.dumps(study_schema() if study else json_schema(), indent=2, ensure_ascii=False)
    renew = f"pgimp schema{' --study' if study else ''} > {shlex.quote(str(path))}"
    _write_beside(path, f"{text}\n", f"it is another version's; to renew it: {renew}")


def _next(path: Path, study: bool, imports: list[Path]) -> list[str]:
    """Return the next commands for the files."""
    file = " --import ".join(shlex.quote(str(one)) for one in (path, *imports))
    if study:
        commands = {f"pgimp study {file} --list": "its runs", f"pgimp study {file}": "runs them"}
    else:
        commands = {
            f"pgimp check {file}": "what it will cost",
            f"mpirun -n 2 pgimp {file}": f"writes {path.stem}.out/",
        }
    width = max(map(len, commands))
    return [
        "An editor that knows YAML completes keys and shows mistakes by the schema. Now:",
        *(f"  {command:<{width}}   # {effect}" for command, effect in commands.items()),
    ]
