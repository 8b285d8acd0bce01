"""Cases of one body in 1D, for what reading says of its material."""


def case_of(entry):
    """The case whose material `law` has this entry, of density 1 if it says none."""
    return {
        "format": 1,
        "dimensions": 1,
        "grid": {"size": [4.0], "cell": [1.0]},
        "method": {"shape": "gimp", "particles-per-cell": [2]},
        "time": {"end": 1.0, "step": 0.01},
        "materials": {"law": {"density": 1.0} | entry},
        "bodies": {"body": {"material": "law", "region": {"box": {"min": [1.0], "max": [2.0]}}}},
    }


def text_of(entry, line):
    """The text of a case whose material `m` has this entry but for one line, from line 7 on."""
    lines = [f"    {k}: {v}" for k, v in entry.items() if k != line.partition(":")[0]]
    text = "format: 1\ndimensions: 1\ngrid: {origin: [0], size: [4], cell: [1]}\n"
    text += "method: {shape: gimp, particles-per-cell: [2]}\ntime: {end: 1, step: 0.1}\n"
    text += "materials:\n  m:\n" + "\n".join([*lines, f"    {line}"]) + "\n"
    return text + "bodies: {b: {material: m, region: {box: {min: [1], max: [2]}}}}\n"
