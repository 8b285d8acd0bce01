"""Particles from frames of other codes: .vtu and .vtp, in every encoding that VTK has."""

import base64
import struct
import zlib

import meshio
import numpy as np
import pytest

from pgimp.errors import CaseError
from pgimp.geometry.points.file import blocks

RNG = np.random.default_rng(3)
N = 50
PLACES = RNG.uniform(-1.0, 1.0, (N, 3))
VOLUME = RNG.uniform(0.1, 0.2, N)
SPEED = RNG.uniform(-1.0, 1.0, (N, 3))
FULL = RNG.uniform(-1.0, 1.0, (N, 3, 3))
STRESS = (FULL + np.swapaxes(FULL, 1, 2)).reshape(N, 9)
SIX = STRESS[:, [0, 4, 8, 1, 5, 2]]


def check(path, single=False):
    (block,) = blocks(str(path), 3)
    tolerance = 1e-6 if single else 0.0
    np.testing.assert_allclose(block.position, PLACES, rtol=0, atol=tolerance)
    np.testing.assert_allclose(block.volume, VOLUME, rtol=0, atol=tolerance)
    np.testing.assert_allclose(block.velocity, SPEED, rtol=0, atol=tolerance)
    np.testing.assert_allclose(block.stress, SIX, rtol=0, atol=tolerance)
    assert block.gradient is None and block.place(7) == "point 7 (from 0)"


@pytest.mark.parametrize(
    "options",
    [{"binary": False}, {"compression": None}, {"compression": "zlib"}, {"compression": "lzma"}],
    ids=["ascii", "base64", "zlib", "lzma"],
)
def test_vtu_as_meshio_writes_it(tmp_path, options):
    data = {"volume": VOLUME, "velocity": SPEED, "stress": SIX, "plastic": VOLUME}
    mesh = meshio.Mesh(PLACES, [("vertex", np.arange(N)[:, None])], point_data=data)
    meshio.vtu.write(tmp_path / "frame.vtu", mesh, **options)
    check(tmp_path / "frame.vtu", single="binary" in options)


def vtp(path, order="<", header="I", packed=False, raw=True, kind="d", names=()):
    """Write polygons with appended data; plural names, a stress of nine components."""
    names = names or ("Volumes", "Velocities", "Stresses")
    arrays = [("", PLACES), (names[0], VOLUME), (names[1], SPEED), (names[2], STRESS)]
    appended, entries = b"", []
    for name, values in arrays:
        data = np.asarray(values, order + {"d": "f8", "f": "f4"}[kind]).tobytes()
        if packed:
            half = len(data) // 2 // 8 * 8
            parts = [zlib.compress(part) for part in (data[:half], data[half:])]
            head = struct.pack(f"{order}5{header}", 2, half, len(data) - half, *map(len, parts))
            body = b"".join(parts)
        else:
            head, body = struct.pack(f"{order}{header}", len(data)), data
        width = values.shape[1] if values.ndim > 1 else 1
        bits = {"d": 64, "f": 32}[kind]
        entries.append(
            f'<DataArray type="Float{bits}" Name="{name}" NumberOfComponents="{width}" '
            f'format="appended" offset="{len(appended)}"/>'
        )
        if raw:
            appended += head + body
        elif packed:
            appended += base64.b64encode(head) + base64.b64encode(body)
        else:
            appended += base64.b64encode(head + body)
    endian = {"<": "LittleEndian", ">": "BigEndian"}[order]
    zipped = ' compressor="vtkZLibDataCompressor"' * packed
    text = (
        f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="{endian}" '
        f'header_type="UInt{32 if header == "I" else 64}"{zipped}>\n<PolyData>\n'
        f'<Piece NumberOfPoints="{N}" NumberOfVerts="{N}">\n<Points>{entries[0]}</Points>\n'
        f"<PointData>{''.join(entries[1:])}</PointData>\n<Verts/>\n</Piece>\n</PolyData>\n"
        f'<AppendedData encoding="{"raw" if raw else "base64"}">\n  _'
    )
    path.write_bytes(text.encode() + appended + b"\n</AppendedData>\n</VTKFile>\n")


@pytest.mark.parametrize("raw", [True, False])
@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize(("order", "header", "kind"), [("<", "I", "d"), (">", "Q", "f")])
def test_vtp_with_appended_data(tmp_path, order, header, packed, raw, kind):
    vtp(tmp_path / "frame.vtp", order, header, packed, raw, kind)
    check(tmp_path / "frame.vtp", single=kind == "f")


def test_a_flat_case_takes_flat_points(tmp_path):
    flat = PLACES * [1.0, 1.0, 0.0]
    data = {"volume": VOLUME, "velocity": SPEED * [1.0, 1.0, 0.0]}
    meshio.Mesh(flat, [("vertex", np.arange(N)[:, None])], point_data=data).write(
        tmp_path / "frame.vtu"
    )
    (block,) = blocks(str(tmp_path / "frame.vtu"), 2)
    assert (block.position == flat[:, :2]).all() and block.velocity.shape == (N, 2)
    vtp(tmp_path / "frame.vtp")
    with pytest.raises(CaseError, match="has a part along a direction that the case, 2D"):
        list(blocks(str(tmp_path / "frame.vtp"), 2))


def test_what_is_no_frame_of_particles_is_refused(tmp_path):
    path = tmp_path / "frame.vtp"
    vtp(path, names=("mass", "velocity", "stress"))
    with pytest.raises(CaseError, match="no array 'volume'; there are: mass, velocity, stress"):
        list(blocks(str(path), 3))
    vtp(path, packed=True)
    data = path.read_bytes()
    wrong = {
        "damaged": data.replace(b"x\x9c", b"y\x9c"),
        "no XML": data[:300],
        "of the type ImageData": data.replace(b'type="PolyData"', b'type="ImageData"'),
        "write it with ZLib": data.replace(b"ZLib", b"LZ4"),
        "numbers, expected": data.replace(b'Points="50"', b'Points="49"'),
        "claims 999,999,999 particles": data.replace(b'Points="50"', b'Points="999999999"'),
    }
    for words, content in wrong.items():
        path.write_bytes(content)
        with pytest.raises(CaseError) as caught:
            list(blocks(str(path), 3, 10**8))
        assert words in str(caught.value), (words, str(caught.value))
    data = dict.fromkeys(("id", "body", "material", "volume", "radius"), VOLUME)
    meshio.Mesh(PLACES, [("vertex", np.arange(N)[:, None])], point_data=data).write(
        tmp_path / "own.vtu"
    )
    with pytest.raises(CaseError, match=r"an exported frame of pgimp; take the frame itself"):
        list(blocks(str(tmp_path / "own.vtu"), 3))
