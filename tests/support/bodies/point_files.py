"""Files of particles."""

import h5py


def write_csv(path, data, **extra):
    axes = "xyz"[: data["position"].shape[1]]
    columns = dict(zip(axes, data["position"].T, strict=True)) | {"volume": data["volume"]}
    if "velocity" in data:
        columns |= {f"velocity-{a}": v for a, v in zip(axes, data["velocity"].T, strict=True)}
    columns |= extra
    rows = [",".join(repr(float(x)) for x in row) for row in zip(*columns.values(), strict=True)]
    path.write_text("\n".join(["# by a test", ",".join(columns), "", *rows]) + "\n")


def write_hdf5(path, data):
    with h5py.File(path, "w") as file:
        for key, value in data.items():
            file[key] = value
