"""Smaller cases that still fail: parts are taken away one after the other, as long as they do."""

import copy
import itertools
import math
import time

#: Keys whose entries may go one by one, and what else then has to: entries of their bodies.
ENTRIES = ("probes", "gauges", "tractions", "constraints", "boundaries", "outflow", "bodies")
#: Keys by path that may go. First come those that do not change what is compiled.
OPTIONAL = ("output.at", "output.grid", "output.fields", "output.precision", "output.compression",
            "output.every", "history", "gravity", "contact", "method.volume", "method.size",
            "method.wall", "method.pic-damping", "method.affine",
            "method.volumetric")  # fmt: skip


def _without(case, path):
    *parents, key = path.split(".") if isinstance(path, str) else path
    found = copy.deepcopy(case)
    part = found
    for parent in parents:
        part = part.get(parent, {})
    return found if part.pop(key, None) is not None else None


def _step(case):
    """A fixed step of about the size that Courant control takes."""
    moduli = ("young", "bulk", "shear")  # a gas has none: it is as slow as what else there is

    def number(entry, *keys):  # what varies in space counts as little as what is not there
        return max(v for v in (0.0, *map(entry.get, keys)) if isinstance(v, int | float))

    speed = (
        max(
            math.sqrt(1.5 * number(m, *moduli) / (number(m, "density") or 1.0))
            for m in case["materials"].values()
        )
        or 1.0
    )
    courant = case["time"]["step"]["courant"]
    courant = 0.3 if courant == "auto" else courant
    return float(f"{courant * min(case['grid']['cell']) / (1.2 * speed):.3g}")


def _shorter(case):
    found = copy.deepcopy(case)
    time_, out = found["time"], found.get("output", {})
    if isinstance(time_["step"], dict):
        if time_["end"] < _step(case):
            return None
        time_["end"] = float(f"{0.5 * time_['end']:.4g}")
    else:
        steps = round(time_["end"] / time_["step"])
        if steps < 2:
            return None
        time_["end"] = round(steps // 2 * time_["step"], 12)
    if "at" in out:
        out["at"] = [t for t in out["at"] if t <= time_["end"]]
    return found


def _bodiless(case, name):
    """The case without a body and what acts on it."""
    if len(case["bodies"]) < 2:
        return None
    found = _without(case, ("bodies", name))
    for kind in ("probes", "tractions", "constraints"):
        entries = found.get(kind, {})
        found[kind] = {key: each for key, each in entries.items() if each.get("body") != name}
    gauges = found.get("gauges", {}).items()
    found["gauges"] = {key: each for key, each in gauges if name not in each.get("bodies", ())}
    laws = found.pop("contact", [])
    if len(found["bodies"]) > 1:
        kept = [law for law in laws if name not in law["bodies"]]
        found |= {"contact": kept} if kept else {}
    used = {body.get("material") for body in found["bodies"].values()}
    found["materials"] = {key: each for key, each in found["materials"].items() if key in used}
    return found


def _boxed(region):
    """A simpler region, or None."""
    if "ball" in region:
        centre, r = region["ball"]["centre"], region["ball"]["radius"]
        low, high = ([round(c + s * r, 6) for c in centre] for s in (-1, 1))
        return {"box": {"min": low, "max": high}}
    if "cylinder" in region:
        ends = region["cylinder"]["from"], region["cylinder"]["to"]
        r = 0.9 * region["cylinder"]["radius"]
        return {"ball": {"centre": [0.5 * (a + b) for a, b in zip(*ends, strict=True)],
                         "radius": r}}  # fmt: skip
    for name in ("union", "difference", "intersection"):
        if name in region:
            return region[name][0]
    return None


def _plain(value):
    """A value that does not vary in time: the first of each table, the last of each ramp."""
    if isinstance(value, dict):
        if "table" in value:
            return value["table"][0][1]
        if "ramp" in value or "sine" in value:
            return value["ramp"]["to"] if "ramp" in value else value["sine"]["mean"]
        return {key: _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, list) else value


def _flat(value, D):
    """A value without its last direction: vectors of D numbers become shorter."""
    if isinstance(value, dict):
        faces = ("xyz"[D - 1] + "-min", "xyz"[D - 1] + "-max")
        found = {key: _flat(each, D) for key, each in value.items() if key not in faces}
        if isinstance(value.get("rate"), list):
            found["rate"] = value["rate"][2]
        found.pop("cylinder", None)
        if "cylinder" in value:
            found |= _flat(_boxed(value), D)
        return found
    vector = isinstance(value, list) and len(value) == D
    if vector and all(each is None or isinstance(each, int | float | dict) for each in value):
        return value[: D - 1] if not any("box" in e for e in value if isinstance(e, dict)) else [
            _flat(each, D) for each in value
        ]  # fmt: skip
    return [_flat(each, D) for each in value] if isinstance(value, list) else value


def _lower(case):
    """The case in one dimension less."""
    D = case["dimensions"]
    if D == 1 or any(region in str(case["bodies"]) for region in ("points", "mesh")):
        return None
    found = _flat(case, D) | {"dimensions": D - 1}
    loads = found.get("tractions", {}).items()
    found["tractions"] = {k: e for k, e in loads if e.get("face", "zyx"[-D])[0] != "xyz"[D - 1]}
    if D == 2:
        for name, each in found["materials"].items():
            modulus = each.get("young", each.get("bulk", 100.0))  # soils, fluids and gases, too
            found["materials"][name] = {"model": "linear-1d", "young": modulus,
                                        "density": each["density"]}  # fmt: skip
        for body in found["bodies"].values():
            body.get("rigid", {}).pop("rotation", None)
            if isinstance(body.get("velocity"), dict):
                body["velocity"] = body["velocity"].get("translation", [0.0])
    return found


def _smaller_grid(case, d, upper):
    """Half as many cells along a direction, those of one end."""
    found = copy.deepcopy(case)
    grid, cell = found["grid"], case["grid"]["cell"][d]
    cells = round(grid["size"][d] / cell)
    if cells < 2:
        return None
    left = cells - max(1, cells // 3)
    grid["size"][d] = left * cell
    if upper:
        grid["origin"][d] += (cells - left) * cell
    return found


def candidates(case):
    """Yield cases that are smaller by one thing each, None for those that are not."""
    yield _shorter(case)
    for name in reversed(case["bodies"]):
        yield _bodiless(case, name)
    for path in (*ENTRIES[:-1], *OPTIONAL):
        yield _without(case, path)
    yield _plain(case)
    for kind, name in itertools.chain(*([(k, n) for n in case.get(k, {})] for k in ENTRIES[:-1])):
        yield _without(case, (kind, name))
    for name, body in case["bodies"].items():
        yield _without(case, ("bodies", name, "surface"))
        for key, value in (("region", _boxed(body["region"])), ("velocity", None)):
            if key == "velocity" and isinstance(body.get("velocity"), dict):
                value = body["velocity"].get("translation")
            if value is not None:
                found = copy.deepcopy(case)
                found["bodies"][name][key] = value
                yield found
        yield _without(case, ("bodies", name, "velocity"))
        for key in ("velocity", "rotation", "fixed"):
            yield _without(case, ("bodies", name, "rigid", key))
    yield case | {"method": case["method"] | {"particles-per-cell": [1] * case["dimensions"]}}
    for d, upper in itertools.product(range(case["dimensions"]), (False, True)):
        yield _smaller_grid(case, d, upper)
    if isinstance(case["time"]["step"], dict):
        step = _step(case)
        end = round(max(1, round(case["time"]["end"] / step)) * step, 12)
        yield case | {"time": {"end": end, "step": step}}
    for name in case["materials"]:
        yield _without(case, ("materials", name, "viscosity"))
    first = next(iter(case["materials"]))
    bodies = {
        name: body if "rigid" in body else body | {"material": first}
        for name, body in case["bodies"].items()
    }
    yield case | {"bodies": bodies, "materials": {first: case["materials"][first]}}
    yield _lower(case)


def shrink(case, fails, seconds):
    """The smallest case that is found to fail as one does; ``fails(case)`` says what does.

    After some seconds of this process the smallest so far will do.
    """
    end, tried, again = time.process_time() + seconds, {repr(case)}, True
    while again:
        again = False
        for smaller in candidates(case):
            if smaller is None or repr(smaller) in tried:
                continue
            if time.process_time() > end:
                return case
            tried.add(repr(smaller))
            if fails(smaller):
                case, again = smaller, True
                break
    return case
