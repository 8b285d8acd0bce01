"""The floors of the package: what a folder may import."""

import ast
from itertools import pairwise
from pathlib import Path

import pgimp

#: From the ground up; those of a floor know nothing of each other.
FLOORS = (
    ("errors", "signals", "terminal"),
    ("mpi", "jit"),
    ("storage",),
    ("schema",),
    ("geometry",),
    ("physics",),
    ("kernels",),
    ("case",),
    ("decomposition",),
    ("scene",),
    ("io",),
    ("solver",),
    ("running",),
    ("utilities",),
    ("commands",),
    ("cli",),
    ("__init__", "__main__"),
)
FLOOR = {name: floor for floor, names in enumerate(FLOORS) for name in names}
ROOT = Path(pgimp.__file__).parent
SCRIPTS = Path(__file__).parents[1] / "scripts"
MODULES = sorted(path.relative_to(ROOT) for path in ROOT.rglob("*.py"))


def statements(path):
    """Names of pgimp's modules, or in them, that a file imports, anywhere, for types alone too."""
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            whole = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            whole = [alias.name for alias in node.names]
        else:
            continue
        yield from (name for name in whole if name.startswith("pgimp."))


def imported(path):
    """As `statements`, and names of modules that are given as text."""
    yield from statements(path)
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from [node.value] * node.value.startswith("pgimp.")


def test_every_folder_has_a_floor():
    assert {path.parts[0].removesuffix(".py") for path in MODULES} - {"cases"} == set(FLOOR)


def test_folders_can_be_seen_at_a_glance():
    """Sixteen files at most, and what each folder of kernels and of the solver is for."""
    roots = ROOT, Path(__file__).parent, SCRIPTS
    for folder in (*roots, *(each for root in roots for each in root.rglob("*"))):
        files = [path for path in folder.glob("*.py") if path.stem != "__init__"]
        assert len(files) <= 16, f"{folder} has {len(files)} files"
        if ROOT not in folder.parents:
            continue
        if files and folder.relative_to(ROOT).parts[:1] in (("kernels",), ("solver",)):
            text = (folder / "README.md").read_text()
            missing = [path.name for path in files if path.name not in text]
            assert not missing, f"{folder.relative_to(ROOT)}/README.md does not name {missing}"


def test_no_import_runs_up():
    up = []
    for path in MODULES:
        own = path.parts[0].removesuffix(".py")
        for name in imported(path):
            other = name.split(".")[1]
            if own in FLOOR and own not in (other, "__init__") and other in FLOOR:
                up += [f"{path} imports {name}"] * (FLOOR[other] >= FLOOR[own])
    assert not up, "\n".join(up)


def test_no_modules_import_each_other_in_a_circle():
    """Nor through others; also not for types, or in a function."""
    names = {".".join(("pgimp", *path.with_suffix("").parts)).removesuffix(".__init__"): path
             for path in MODULES}  # fmt: skip
    left = {}
    for name, path in names.items():
        wanted = {n if n in names else n.rpartition(".")[0] for n in statements(path)}
        left[name] = wanted & set(names) - {name}
    while done := {name for name, wanted in left.items() if not wanted & set(left)}:
        left = {name: wanted for name, wanted in left.items() if name not in done}
    assert not left, {name: sorted(wanted & set(left)) for name, wanted in left.items()}


def test_no_file_of_tests_imports_another():
    """What several need is in tests/support/; a file may be changed, or run, without the others."""
    for path in Path(__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                names = [node.module]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            else:
                continue
            assert not any(name.startswith(("test_", "conftest")) for name in names), path.name


def test_folders_of_tests_are_those_of_the_package():
    """So that what tests a file is found where that lies; besides, what tests the whole."""
    besides = {"cases", "docs", "proofs", "scripts", "support"}
    for path in Path(__file__).parent.rglob("test_*.py"):
        folder = path.parent.relative_to(Path(__file__).parent)
        assert str(folder) in besides or (ROOT / folder).is_dir(), f"there is no pgimp/{folder}"


def test_files_of_tests_have_different_names():
    """They are no packages: pytest knows each by its name alone, but for what a folder shares."""
    names = sorted(path.name for path in Path(__file__).parent.rglob("*.py"))
    twice = {one for one, other in pairwise(names) if one == other}
    assert twice <= {"conftest.py"}


def test_no_kernel_takes_more_than_eight_arguments():
    """What belongs together goes in one NamedTuple, see `pgimp.kernels.data.arguments`."""
    many = []
    for path in [*(ROOT / "kernels").rglob("*.py"), *(ROOT / "physics").rglob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.Lambda):
                own = node.args
                count = len(own.posonlyargs + own.args + own.kwonlyargs)
                if count > 8 or own.vararg or own.kwarg:
                    many.append(f"{path.relative_to(ROOT)}:{node.lineno}: {count}")
    assert not many, "\n".join(many)


def test_no_script_is_longer_than_three_hundred_lines():
    long = {path.name: count for path in SCRIPTS.rglob("*.py")
            if (count := len(path.read_text().splitlines())) > 300}  # fmt: skip
    assert not long


def test_what_studies_share_knows_no_study():
    """And no study starts another one, but by functions that it imports from its modules."""
    for path in (SCRIPTS / "studies").rglob("*.py"):
        shared = path.parent.name == "studies"
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("studies."):
                assert not shared, f"{path.name} imports {node.module}"
                assert not node.module.endswith("__main__"), f"{path.name} imports {node.module}"


#: Pairs of folders within a folder that import each other. Lower a number that has become smaller.
PAIRS = {"kernels": 0, "solver": 0, "scene": 0}


def test_fewer_and_fewer_folders_import_each_other():
    """Also within the folders whose floors are above: an import should run one way."""
    for top, most in PAIRS.items():
        arrows = set()
        for path in MODULES:
            if path.parts[0] != top:
                continue
            own = path.parts[1].removesuffix(".py")
            others = (name.split(".") for name in statements(path))
            arrows |= {(own, parts[2]) for parts in others if parts[1] == top and len(parts) > 3}
        pairs = {
            tuple(sorted(pair)) for pair in arrows if pair[0] != pair[1] and pair[::-1] in arrows
        }
        assert len(pairs) == most, f"{top}: {sorted(pairs)}"
