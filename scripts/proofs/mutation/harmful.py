"""Files that would do harm to other readers, or ask for more than any machine has."""

import re

#: What a tag or a launcher would leave behind, had it been obeyed.
TRACE = "harm-done"
EXECUTE = f'!!python/object/apply:os.system ["touch {TRACE}"]'


def titled(text, title):
    """Give a case another title."""
    return re.sub(r"title: .*", lambda _: f"title: {title}", text, count=1)


def hostile(text, chance):
    """Return a text that makes other readers execute, expand or recurse; `text` is a good case."""
    n = chance.choice((40, 1000, 100_000))
    bomb = [f"l{i}: &l{i} [{', '.join([f'*l{i - 1}'] * 9)}]" for i in range(1, 12)]
    deep = ["[", "{a: ", "- ", "? ", "a: ", "&a ", "!", "%", "'", "# ", "\n", "a: [1\n", "a: 1\n"]
    return chance.choice((
        f"{text}\nx: {EXECUTE}\n", text.replace("format: 1", f"format: {EXECUTE}", 1),
        titled(text, EXECUTE), f"{text}\nx: !!python/name:os.system\ny: !!python/module:{TRACE}\n",
        "\n".join(["l0: &l0 lol", *bomb]),
        f"{text}\nbase: &b {{end: 1}}\ntime: {{<<: *b, step: 1}}\n",
        text.replace("\ntime:", "\n<<: {time: 1}\ntime:", 1), chance.choice(deep) * n,
        chance.choice(deep) * n, "a: |\n" + " x\n" * n, "a: [" + "1, " * n + "]",
        "a: {" + "b: 1, " * n + "}", "".join(f"k{i}: 1\n" for i in range(n)),
        "".join(" " * i + "a:\n" for i in range(200)), f"{text}\n{'k' * n}: 1\n",
        f'{text}\n"\\e[2J\\0": 1\n', f"{text}\n\x1b[2J: 1\n", titled(text, "t" * n),
        titled(text, '"\\0\\n\\e[31m"'), f"{text}\n---\n{text}", f"%YAML 9.9\n---\n{text}",
        f"%TAG !! tag:x,2000:\n--- !!map\n{text}",
        f"{text}\nx: !!binary aGFybQ==\ny: !!set {{a, b}}\nz: !!timestamp 2001-01-01\n",
        f"a: {'9' * n}", f"a: 0x{'f' * n}", f"a: 1e{'9' * n}", f'a: "\\U{"12345678"[: n % 9]}"',
        text.replace("young: ", f"young: {'1' * n}x", 1),
        text.replace("young: ", "young: 1" + "_1" * n, 1),
    ))  # fmt: skip


def enlarge(data, chance):
    """Make a case far larger than any machine, or with far too much of something."""
    D, n = data["dimensions"], chance.choice((30, 1000, 20_000))
    body, material = (next(iter(data[key].values())) for key in ("bodies", "materials"))
    region, grid = body["region"], data["grid"]
    huge = chance.choice((1e3, 1e5, 1e7, 1e9, 1e12))
    d = chance.randrange(D)

    def ball(x):
        return {"ball": {"centre": [x] * D, "radius": 1e-3 * x}}

    def everything():
        grid["size"] = [x * huge for x in grid["size"]]
        body["region"] = {"box": {"min": [0.0] * D, "max": grid["size"]}}
        grid["origin"] = [0.0] * D

    def nested():
        for _ in range(n):
            body["region"] = {"difference": [body["region"], ball(1e-9)]}

    def step():
        data["time"] = {"end": huge, "step": chance.choice((1e-9, {"courant": 1e-9}))}

    todo = (
        lambda: grid.update(cell=[h / huge for h in grid["cell"]]),
        lambda: grid["size"].__setitem__(d, huge * grid["size"][d]),
        lambda: data.setdefault("method", {}).update({"particles-per-cell": [int(huge)] * D}),
        everything,
        lambda: data.update(gravity={"table": [[i / n, [0.0] * D] for i in range(n)]}),
        lambda: data.update(output={"at": [data["time"]["end"] * i / n for i in range(n)]}),
        lambda: body.update(region={"union": [region] * n}),
        lambda: body.update(region={"union": [ball(1.0 + i / n) for i in range(n)]}),
        nested,
        lambda: data["bodies"].update({f"b{i}": {**body, "region": region} for i in range(n)}),
        lambda: data["materials"].update({f"m{i}": material for i in range(n)}),
        lambda: data.update(output={"fields": ["stress", "velocity", "strain"] * n}),
        step,
        lambda: data.update({f"key{i}": i for i in range(n)}),
    )
    for change in chance.sample(todo, 2):
        change()
