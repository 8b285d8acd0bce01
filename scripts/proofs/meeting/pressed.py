"""Random scenes of what is folded, pressed, lifted, or lies on what it tilts off: it meets at rest.

Bodies meet for most of the time, where those of `touching.py` mostly fly.
"""

from proofs.scenes.bodies import number

FLOOR = {"unilateral": {"friction": 0.2}}
SEAM = {"x-min": "periodic", "x-max": "periodic"}
SOFT = {"formulation": "total-lagrangian", "material": "soft"}


def box(low, high):
    """A region along the grid."""
    return {"box": {"min": [round(x, 4) for x in low], "max": [round(x, 4) for x in high]}}


def wrapped(make, at, period, height):
    """The region `make(x)` and its image, as far as they are in a periodic domain."""
    images = [make(at + shift) for shift in (-period, 0.0, period)]
    return {"intersection": [{"union": images}, box([0.0, 0.0], [period, height])]}


def folded(rng, seam=False):
    """A tube or a fork that a plate folds until it meets itself, and that springs back."""
    slot, wall, fast = number(rng, 2.1, 2.6), number(rng, 1.1, 1.8), number(rng, 1.5, 3.0)
    tube = rng.random() < 0.5
    height = slot + 2.0 * wall
    width = height if tube else number(rng, 6.0, 8.0)
    size = [float(round(width + 5.0)), float(round(height + 3.0))]

    def region(x):
        y = 0.5 * height
        if tube:
            balls = ({"ball": {"centre": [x, y], "radius": round(r, 4)}} for r in (y, 0.5 * slot))
            return {"difference": [*balls]}
        low, high = x - 0.5 * width, x + 0.5 * width
        cut = box([low + wall, wall], [high + 1.0, wall + slot])
        return {"difference": [box([low, 0.0], [high, height]), cut]}

    at = number(rng, 0.0, size[0]) if seam else number(rng, 0.45, 0.55) * size[0]
    whole = wrapped(region, at, *size) if seam else region(at)
    turn = number(rng, 0.7, 1.0) * (slot + 0.1) / fast
    rows = [[0.0, [0.0, -fast]], [turn, [0.0, -fast]], [1.2 * turn, [0.0, fast]]]
    plate = box([0.0, height + 0.02], [size[0], height + 1.5])
    bodies = {
        "tube": SOFT | {"region": whole},
        "plate": {"rigid": {"velocity": {"table": rows}}, "region": plate},
    }
    laws = [
        {"bodies": "all", "friction": number(rng, 0.0, 0.5)},
        {"bodies": ["tube"], "self": True, "friction": number(rng, 0.0, 0.5)},
    ]
    faces = {"y-min": FLOOR} | (SEAM if seam else {})
    return size, bodies, laws, 1.6 * turn, {"boundaries": faces}


def ends(rng):
    """A bar round a periodic domain but for a slit, which a plate closes: it meets its image."""
    size, height, slit = [float(rng.randint(8, 12)), 7.0], number(rng, 2.5, 3.5), 0.1
    fast, turn = number(rng, 0.8, 1.5), number(rng, 0.6, 1.0)
    at = number(rng, 0.0, size[0])
    middle = 0.5 * (size[0] - slit)

    def region(x):
        return box([x - middle, 0.0], [x + middle, height])

    rows = [[0.0, [0.0, -fast]], [turn, [0.0, -fast]], [1.2 * turn, [0.0, fast]]]
    bodies = {
        "bar": SOFT | {"region": wrapped(region, at, *size)},
        "plate": {"rigid": {"velocity": {"table": rows}},
                  "region": box([0.0, height + 0.01], [size[0], height + 1.5])},
    }  # fmt: skip
    laws = [{"bodies": "all"}, {"bodies": ["bar"], "self": True, "friction": 0.2}]
    return size, bodies, laws, 2.0 * turn, {"boundaries": {"y-min": FLOOR} | SEAM}


def lifted(rng, seam=False):
    """Two bodies under a load: lifted off, taken away by a stage, or pressed by a force."""
    size = [float(rng.randint(9, 12)), 10.0]
    width, low, high = (number(rng, *ends) for ends in ((3.0, 5.0), (1.7, 2.9), (1.7, 2.9)))
    at = number(rng, 0.0, size[0]) if seam else 0.5 * size[0]
    radius = 0.5 * high

    def base(x):
        return box([x - 0.5 * width, 0.0], [x + 0.5 * width, low])

    def top(x):
        if rng_kind < 0.5:
            return {"ball": {"centre": [round(x, 4), round(low + radius, 4)], "radius": radius}}
        return box([x - 0.3 * width, low], [x + 0.3 * width, low + high])

    rng_kind = rng.random()
    regions = [wrapped(each, at, *size) if seam else each(at) for each in (base, top)]
    fast, end = number(rng, 0.3, 1.0), number(rng, 0.8, 1.6)
    plate = box([0.0, low + high + 0.01], [size[0], low + high + 1.2])
    how, more = rng.choice(("lifted", "gone", "force", "spring")), {}
    rigid = {"velocity": [0.0, -fast]}
    if how == "lifted":
        rows = [[0.0, [0.0, -fast]], [0.4 * end, [0.0, -fast]], [0.41 * end, [0.0, 3.0 * fast]]]
        rigid = {"velocity": {"table": rows}}
    elif how == "gone":
        more["stages"] = [{"name": "off", "end": end, "remove": ["plate"]}]
    elif how == "force":
        rows = [[0.0, [0.0, 0.0]], [0.3 * end, [0.0, -20.0]], [0.31 * end, [0.0, 5.0]]]
        rigid = {"density": 1.0, "fixed": ["x", "rotation"], "force": {"table": rows}}
    else:
        spring = {"stiffness": 50.0, "dashpot": 1.0, "to": [0.5 * size[0], low + high]}
        rigid = {"density": 2.0, "fixed": ["x", "rotation"], "spring": spring}
    bodies = {
        "base": SOFT | {"region": regions[0], "material": rng.choice(("soft", "stiff"))},
        "top": SOFT | {"region": regions[1]},
        "plate": {"rigid": rigid, "region": plate},
    }
    more["boundaries"] = {"y-min": FLOOR} | (SEAM if seam else {})
    laws = [{"bodies": "all", "friction": number(rng, 0.0, 0.6)}]
    if rng.random() < 0.5:
        more["gravity"] = [0.0, -number(rng, 0.5, 2.0)]
    return size, bodies, laws, end, more


def blocks(rng):
    """In 3D a block on another one of another lattice, which it may slide on or tilt off."""
    size = [9.0, 7.0, 7.0]
    low = [number(rng, 1.0, 2.0), number(rng, 1.0, 1.8), 0.0]
    high = [low[0] + number(rng, 3.0, 5.0), low[1] + number(rng, 2.6, 3.6), number(rng, 1.6, 2.4)]
    begin = [low[0] + number(rng, 0.3, 2.0), low[1] + number(rng, -0.4, 0.6), high[2]]
    end = [begin[0] + number(rng, 2.1, 3.0), begin[1] + number(rng, 2.1, 3.0), high[2] + 2.1]
    rate = [number(rng, -0.5, 0.5), number(rng, 0.0, 1.5), number(rng, -0.3, 0.3)]
    edge = [high[0], begin[1], high[2]]
    spin = {"rotation": {"about": edge, "rate": rate}, "translation": [number(rng, 0, 1.0), 0.3, 0]}
    bodies = {
        "base": SOFT | {"region": box(low, high)},
        "top": SOFT | {"region": box(begin, end), "velocity": spin},
    }
    laws = [{"bodies": "all", "friction": number(rng, 0.0, 0.5)}]
    more = {"boundaries": {"z-min": FLOOR}, "gravity": [0.0, 0.0, -number(rng, 1.0, 9.0)]}
    return size, bodies, laws, number(rng, 0.5, 0.9), more


#: What makes each kind.
KINDS = {
    "folded": folded,
    "folded seam": lambda rng: folded(rng, True),
    "ends": ends,
    "lifted": lifted,
    "lifted seam": lambda rng: lifted(rng, True),
    "blocks": blocks,
}


def make(rng, kind, materials):
    """A case of a kind."""
    size, bodies, laws, end, more = KINDS[kind](rng)
    stages = more.pop("stages", [])
    end = float(f"{end:.4g}")
    for stage in stages:
        stage["end"] = end
    time = {"end": round(0.5 * end, 4) if stages else end}
    time |= {"step": {"courant": number(rng, 0.15, 0.35)}}
    D = len(size)
    return {
        "format": rng.choice((1, 2)), "dimensions": D,
        "grid": {"size": size, "cell": [1.0] * D},
        "method": {"shape": "gimp", "particles-per-cell": [rng.choice((2, 2, 3)) for _ in size]},
        "time": time | ({"stages": stages} if stages else {}), "materials": materials,
        "bodies": bodies, "contact": laws,
        "output": {"every": 0.3 * end, "fields": ["velocity", "stress"]},
        "history": {"every": {"steps": rng.randint(1, 9)}},
        "checkpoint": {"every": {"steps": rng.randint(3, 15)}, "keep": 4},
    } | more  # fmt: skip
