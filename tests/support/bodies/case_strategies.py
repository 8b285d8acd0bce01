"""Good cases of every kind, for hypothesis."""

from hypothesis import strategies as st

from pgimp.physics.fields import OPTIONAL

#: Fields that every case may ask for: `unwrapped` is of periodic ones, `recovered-stress` of bodies
#: in the initial configuration.
IN_ALL = [name for name in OPTIONAL if name not in ("unwrapped", "recovered-stress")]
NUMBER = st.floats(-1e150, 1e150)
NAME = st.from_regex("[A-Za-z][A-Za-z0-9_-]{0,12}", fullmatch=True) | st.sampled_from(
    ["null", "true", "False", "yes", "on", "e5", "Infinity"]
)
TEXT = st.text(st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"]), max_size=40)


def rows(draw, values):
    """Rows of a table: increasing times that no change between them makes too steep."""
    times = sorted(draw(st.lists(st.integers(-1000, 1000), min_size=1, max_size=12, unique=True)))
    return [[time / 7, draw(values)] for time in times]


@st.composite
def cases(draw):
    """Good cases in any dimension, as plain data."""
    dimensions = draw(st.integers(1, 3))
    small = st.floats(-1e150, 1e150)
    vector = st.lists(NUMBER, min_size=dimensions, max_size=dimensions)
    gentle = st.lists(small, min_size=dimensions, max_size=dimensions)
    cell = [draw(st.floats(1e-3, 1e3)) for _ in range(dimensions)]
    size = [draw(st.integers(4, 1000)) * c for c in cell]
    low, high = [0.25 * s for s in size], [0.5 * s for s in size]
    box = {"box": {"min": low, "max": high}}
    ball = {"ball": {"centre": high, "radius": 0.4 * min(size)}}
    half = {"half-space": {"point": high, "normal": [1.0, -0.5, 0.2][:dimensions]}}
    region = draw(
        st.sampled_from(
            [
                box,
                ball,
                {"union": [ball, {"difference": [ball, box]}]},
                {"intersection": [ball, half]},
                {"difference": [ball, half]},
            ]
        )
    )
    if dimensions == 3 and draw(st.booleans()):
        region = {"cylinder": {"from": low, "to": high, "radius": 0.1 * min(size)}}
    velocity = draw(vector)
    if dimensions > 1 and draw(st.booleans()):
        rate = draw(NUMBER) if dimensions == 2 else draw(vector)
        velocity = {"rotation": {"about": draw(vector), "rate": rate}}
    component = st.none() | NUMBER | st.builds(lambda r: {"table": r}, st.just(rows(draw, small)))
    step = draw(st.floats(1e-9, 1e3))
    steps = draw(st.integers(1, 10**9))
    return {
        "format": 1,
        "title": draw(TEXT),
        "units": draw(TEXT),
        "dimensions": dimensions,
        "grid": {"size": size, "cell": cell},
        "method": {"shape": "gimp", "particles-per-cell": [draw(st.integers(1, 9))] * dimensions},
        "time": {"end": steps * step, "step": draw(st.just(step) | st.just({"courant": 0.5}))},
        "materials": {
            (name := draw(NAME)): {
                "model": draw(st.sampled_from(["neo-hookean", "hooke"])),
                "density": draw(st.floats(1e-150, 1e150)),
                "young": draw(st.floats(1e-150, 1e150)),
                "poisson": draw(st.floats(-1, 0.5, exclude_min=True, exclude_max=True)),
            }
        },
        "bodies": {draw(NAME): {"material": name, "region": region, "velocity": velocity}},
        "gravity": draw(st.none() | vector | st.just({"table": rows(draw, gentle)})),
        "boundaries": {
            "x-max": draw(st.sampled_from(["fixed", "slip", "unilateral"])),
            "x-min": {"velocity": [draw(component) for _ in range(dimensions)]},
        },
        "outflow": {
            face: draw(st.sampled_from(["stop", "remove"]))
            for face in ("y-min", "y-max", "z-min", "z-max")[: 2 * dimensions - 2]
            if draw(st.booleans())
        }
        | ({"bin": {"region": region}} if draw(st.booleans()) else {}),
        "output": {
            "every": draw(st.none() | st.floats(1e-150, 1e150)),
            "fields": draw(st.lists(st.sampled_from(IN_ALL), unique=True)),
        },
        "history": {"every": {"steps": draw(st.integers(1, 2**53))}},
    }
