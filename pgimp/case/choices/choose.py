"""Choice of what a case leaves out of its method, and its lines for people."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from pgimp.case.body import has_means
from pgimp.case.choices.body_rules import MASS, OF_BODIES, VOLUMETRIC
from pgimp.case.choices.facts import BodyChoice, Meeting, SceneChoice, facts_of, meeting
from pgimp.case.choices.rules import Rule, rule_of
from pgimp.case.choices.scene_rules import CONTACT, OF_SCENES
from pgimp.schema.pages import page

#: Stands for `pgimp.case.schema.Case`, whose module imports these.
Case = Any
Data = dict[str, Any]
Path = tuple[str, ...]

TOTAL, UPDATED = "total-lagrangian", "updated-lagrangian"

#: The word that says of any key of the method that it is chosen.
CHOSEN = "auto"
#: Keys of `method` that are chosen for the scene, and those that are chosen by body.
_OF_METHOD = ("shape", "particles-per-cell", "affine", "volumetric")
_OF_BODY = ("formulation", "mass", "volumetric")
#: Most bodies that a line names.
_NAMED = 3
#: Kinds of bodies as lines name them.
_WORDS = {
    "elastic": "elastic", "metal": "a metal", "soil": "soil", "grains": "grains",
    "liquid": "a liquid", "gas": "a gas", "other": "of a material of one's own",
}  # fmt: skip


class Choice(NamedTuple):
    """A value that was chosen for a key of the case."""

    path: Path
    value: Any
    reason: str
    page: str  #: As links between pages have it.
    instead: bool = False  #: Whether a better one is refused in the case.
    whose: tuple[str, ...] = ()  #: Bodies of the scene because of which it is.

    def because(self, refused: str) -> Choice:
        """Return it with the problem of the better choice."""
        return self._replace(reason=f"{self.reason} ({refused})") if self.instead else self


class Open(NamedTuple):
    """What a case leaves out."""

    bodies: tuple[str, ...]  #: Those of a material without `formulation`.
    masses: tuple[str, ...]  #: Those of a material without `mass`.
    volumes: tuple[str, ...]  #: Those of a material without `volumetric`.
    method: tuple[str, ...]  #: Keys of `_OF_METHOD`.
    step: bool
    contact: bool
    bonded: bool  #: Whether `contact: bonded` stands for entries.


def left_out(data: Mapping[str, Any]) -> Open | None:
    """Find what is to be chosen; None if nothing is, or parts have the wrong form.

    A case of format 1 that names shape, particles and step was always whole: what else it leaves
    out has the defaults of that format, but for keys that say `auto`.
    """
    method, time, every = (data.get(key) for key in ("method", "time", "bodies"))
    method = {} if method is None or method == CHOSEN else method
    if not (
        isinstance(method, Mapping) and isinstance(time, Mapping) and isinstance(every, Mapping)
    ):
        return None
    if data.get("dimensions") not in (1, 2, 3) or isinstance(data.get("dimensions"), bool):
        return None
    whole = {"shape", "particles-per-cell"} <= set(method) and "step" in time
    chooses = data.get("format") == 2 or not whole

    def left(part: Mapping[str, Any], key: str, chooses: bool = chooses) -> bool:
        value = part.get(key)
        return (isinstance(value, str) and value == CHOSEN) or (chooses and key not in part)

    soft = {k: b for k, b in every.items() if isinstance(b, Mapping) and "rigid" not in b}
    of_scene = {key: left(method, key) for key in (*_OF_METHOD, "mass")}
    bodies, masses, volumes = (
        tuple(n for n, b in soft.items() if left(b, key, of_scene.get(key, chooses)))
        for key in _OF_BODY
    )
    found = Open(
        bodies,
        masses,
        volumes,
        tuple(key for key in _OF_METHOD if of_scene[key]),
        left(time, "step"),
        left(data, "contact"),
        data.get("contact") == "bonded",
    )
    return found if any(found) else None


def _named(data: Mapping[str, Any]) -> Data:
    """The case without keys that say `auto`."""

    def named(part: Any, *keys: str) -> Any:
        if not isinstance(part, Mapping):
            return part
        return {k: v for k, v in part.items() if not (k in keys and v is not None and v == CHOSEN)}

    found = named(data, "method", "contact")
    found["method"] = named(found.get("method", {}), *_OF_METHOD, "mass")
    if found["method"] is None:
        found["method"] = {}
    found["time"] = named(found.get("time"), "step")
    if isinstance(every := found.get("bodies"), Mapping):
        found["bodies"] = {name: named(body, *_OF_BODY) for name, body in every.items()}
    return found  # type: ignore[no-any-return]


def without_choice(data: Mapping[str, Any]) -> Data:
    """Return data in which nothing is chosen, with a method where parts of the wrong form lack one.

    So that it does not hide what is wrong with them.
    """
    found, count = _named(data), data.get("dimensions")
    time = found["time"] = found["time"] if "time" in data else None
    if not found["method"]:
        known = count if count in (1, 2, 3) else 1
        found["method"] = {"shape": "gimp", "particles-per-cell": (2,) * int(known or 1)}
    if isinstance(time, Mapping) and "step" not in time:
        found["time"] = {**time, "step": {"courant": 0.3}}
    if "time" not in data:
        del found["time"]
    return found


def plain(data: Mapping[str, Any], open_keys: Open) -> Data:
    """Return the data with defaults that every case can have: for looking at it."""
    count = int(data["dimensions"])
    values: dict[Path, Any] = {
        ("method", "shape"): "gimp",
        ("method", "particles-per-cell"): (2,) * count,
        ("time", "step"): {"courant": 0.3},
    }
    asked = {("method", key) for key in open_keys.method}
    asked |= {("time", "step")} if open_keys.step else set()
    return filled(data, {path: value for path, value in values.items() if path in asked})


def filled(data: Mapping[str, Any], values: Mapping[Path, Any]) -> Data:
    """Return the data with values by their paths, in place of what says `auto`."""
    found = _named(data)
    if found.get("contact") == "bonded":
        found["contact"] = ()
    for path, value in values.items():
        at = found
        for key in path[:-1]:
            at[key] = dict(at[key])
            at = at[key]
        at[path[-1]] = value
    return found


def candidates(case: Case, open_keys: Open) -> Iterator[dict[Path, Choice]]:
    """Yield choices by their paths, the best first, then such as more scenes may have.

    Parameters
    ----------
    case : Case
        The case with `plain` values.
    open_keys : Open
        What it leaves out.
    """
    facts = facts_of(case)
    met = meeting(case, facts)
    for initial, averaged, mean in (
        (True, True, True), (True, False, True), (True, False, False),
        (False, False, True), (False, False, False),
    ):  # fmt: skip
        yield _choices(case, open_keys, facts, met, (initial, averaged, mean))


def _choices(
    case: Case, open_keys: Open, facts: list[BodyChoice], met: Meeting, may: tuple[bool, bool, bool]
) -> dict[Path, Choice]:
    """Choices, as far as the initial configuration, averaged mass and mean dilatation `may` be."""
    found: dict[Path, Choice] = {}
    initial = []
    for body in facts:
        rule = rule_of(OF_BODIES, "formulation", body)
        value, reason = rule.value, f"{_WORDS[body.kind]}: {rule.reason}"
        if body.wall and rule.page == "walls.md":
            reason += f" ({body.wall})"
        instead = not may[0] and value == TOTAL
        if instead:
            value, reason = UPDATED, f"{TOTAL} is refused in this case"
        if body.name in open_keys.bodies:
            path = ("bodies", body.name, "formulation")
            found[path] = Choice(path, value, reason, rule.page, instead)
        else:
            value = case.bodies[body.name].formulation
        initial.append(value == TOTAL)
    if open_keys.bonded:
        entries = bonded(case, initial)
        found["contact",] = Choice(("contact",), entries, "bonded, as written", "contact.md")
    elif open_keys.contact and (entries := _contact(met)):
        rule = CONTACT[0]
        found["contact",] = Choice(("contact",), entries, _met(met), rule.page)
    approached = any(face.approaches for face in case.boundaries.values())
    meets = bool(case.contact or case.rigid_bodies or approached or ("contact",) in found)
    scene = SceneChoice(
        case.dimensions, tuple(facts), tuple(initial), (), meets, case.start.equilibrate is not None
    )
    each = [(body, one, scene) for body, one in zip(facts, initial, strict=True)]
    rules = [rule_of(VOLUMETRIC, "volumetric", it) for it in each] if may[2] else []
    means = _means(case, open_keys, rules or [VOLUMETRIC[-1]] * len(facts), found)
    scene = scene._replace(means=means)
    for it in each:
        path, rule = ("bodies", it[0].name, "mass"), MASS[0]
        if may[1] and it[0].name in open_keys.masses and all(initial) and rule.fits(it):
            found[path] = Choice(path, rule.value, rule.reason, rule.page)
    for key in open_keys.method:
        if key == "volumetric":
            continue
        rule = rule_of(OF_SCENES, key, scene)
        value = (rule.value,) * case.dimensions if key == "particles-per-cell" else rule.value
        found["method", key] = Choice(
            ("method", key), value, rule.reason, rule.page, whose=_whose(rule, scene)
        )
    if open_keys.step:
        rule = rule_of(OF_SCENES, "courant", scene)
        found["time", "step"] = Choice(
            ("time", "step"), {"courant": rule.value}, rule.reason, rule.page,
            whose=_whose(rule, scene),
        )  # fmt: skip
    return found


def _whose(rule: Rule, scene: SceneChoice) -> tuple[str, ...]:
    """Names of the bodies that need what a rule takes; () where all do."""
    if rule.whose is None:
        return ()
    pairs = zip(scene.bodies, scene.initial, strict=True)
    found = tuple(body.name for body, initial in pairs if rule.whose(body, initial))
    return found if len(found) < len(scene.bodies) else ()


def _means(
    case: Case, open_keys: Open, rules: list[Rule], found: dict[Path, Choice]
) -> tuple[bool, ...]:
    """Choose mean dilatation by body; which have it.

    The method has it where any body needs it, and the others have a word of their own.
    """
    needs = [rule.value == "b-bar" for rule in rules]
    open_bodies = [name in open_keys.volumes for name in case.bodies]
    of_method = "volumetric" in open_keys.method
    needed = [rule for rule, n, o in zip(rules, needs, open_bodies, strict=True) if n and o]
    common = bool(needed)
    if of_method:
        rule = needed[0] if needed else VOLUMETRIC[-1]
        names = tuple(n for n, one in zip(case.bodies, needs, strict=True) if one and common)
        found["method", "volumetric"] = Choice(
            ("method", "volumetric"), rule.value, rule.reason, rule.page,
            whose=names if len(names) < len(needs) else (),
        )  # fmt: skip
    else:
        common = case.method.volumetric == "b-bar"
    means = []
    for (name, body), own, is_open in zip(case.bodies.items(), rules, open_bodies, strict=True):
        value, need = common if is_open else has_means(body, case.method), own.value == "b-bar"
        if is_open and need != common:
            path = ("bodies", name, "volumetric")
            found[path] = Choice(path, own.value, own.reason, own.page)
            value = need
        means.append(value)
    return tuple(means)


def _contact(met: Meeting) -> tuple[Data, ...]:
    """Entries of contact: of all that may meet, but for groups that stay together."""
    if not met.pairs:  # the others share a field as they are
        return ()
    tied = ({"bodies": group, "law": "tie"} for group in met.together)
    return ({"bodies": "all"}, *tied)


def _met(met: Meeting) -> str:
    """Name the pairs that meet, those that touch first."""
    named = sorted(met.pairs, key=lambda pair: not pair[2])[:3]
    texts = [f"'{a}' and '{b}'" + " (touch at the start)" * touch for a, b, touch in named]
    more = f" and {len(met.pairs) - 3} more pairs" if len(met.pairs) > 3 else ""
    return f"frictionless, of {', '.join(texts)}{more}; if they are bonded, `contact: bonded`"


def bonded(case: Case, every_initial: Iterable[bool]) -> tuple[Data, ...]:
    """Entries of contact of `contact: bonded`: in the current configuration none are needed."""
    several = len(case.every_body) > 1
    return ({"bodies": "all", "law": "tie"},) if several and any(every_initial) else ()


def lines(case: Case) -> list[str]:
    """Return what was chosen for a case: a line for bodies alike, and for the scene."""
    found: Mapping[Path, Choice] = case.__dict__.get("chosen", {})
    alike: dict[str, list[str]] = {}
    for name in case.bodies:
        body = [found[p] for p in (("bodies", name, key) for key in _OF_BODY) if p in found]
        if body:
            values = ", ".join(f"{one.path[-1]} {one.value}" for one in body)
            reasons = "; ".join(one.reason for one in body)
            alike.setdefault(f"{values} - {reasons} ({page(body[0].page)})", []).append(name)
    texts = []
    for text, names in alike.items():
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        texts.append(f"{', '.join(names[:_NAMED])}{more}: {text}")
    scene = [one for one in found.values() if one.path[0] in ("method", "time")]
    if scene:
        values = ", ".join(f"{one.path[-1]} {_text(one)}" for one in scene)
        texts.append(f"{values} ({page('methods.md#what-is-chosen')})")
    if ("contact",) in found:
        one = found["contact",]
        texts.append(f"contact: {one.reason} ({page(one.page)})")
    return texts


def _text(choice: Choice) -> str:
    if choice.path[-1] == "step":
        text = f"{{courant: {choice.value['courant']}}}"
    elif isinstance(choice.value, tuple):
        text = "[" + ", ".join(map(str, choice.value)) + "]"
    else:
        text = str(choice.value).lower()
    if not choice.whose:
        return text
    more = " .." if len(choice.whose) > _NAMED else ""
    return f"{text} (because of {', '.join(choice.whose[:_NAMED])}{more})"
