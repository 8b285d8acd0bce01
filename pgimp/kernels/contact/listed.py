"""List of a step's contact vertices, with their fields and pairs."""

from typing import NamedTuple

import numpy as np

from pgimp.jit.memory import structure

#: A contact vertex: its numbers by direction, its fields with particles and its rigid bodies, and
#: its pairs. `first_field` and `first_pair` are their first entries in the list. `simple` is 1
#: if nothing else acts there, and no pair while its surfaces move apart.
LISTED_VERTEX = structure(
    ("number", "i8", 3),
    ("fields", "i8"),
    ("rigid", "i8"),
    ("first_field", "i8"),
    ("pairs", "i8"),
    ("first_pair", "i8"),
    ("simple", "i8"),
)

#: A field: the offset of its record, -1 for a rigid body, and its body.
LISTED_FIELD = structure(("offset", "i8"), ("body", "i8"))

#: A pair: its fields, counted at the vertex, the offsets of their records, and its law; the rest as
#: in `PAIR_STATE`.
LISTED_PAIR = structure(
    ("fields", "i8", 2),
    ("offsets", "i8", 2),
    ("law", "i8"),
    ("normal", "f8", 3),
    ("gap_rate", "f8"),
    ("area", "f8"),
    ("adhesion", "f8"),
    ("shear_adhesion", "f8"),
)

#: Entries of `VertexList.found`.
VERTICES, FIELDS, PAIRS = 0, 1, 2


class VertexList(NamedTuple):
    """The contact vertices of a rank in a step, plane by plane."""

    start: np.ndarray  #: (planes + 1,) int64: First vertex of each plane.
    #: (3,) int64: Numbers of vertices, fields and pairs, also if there is no room for them.
    found: np.ndarray
    #: vertices, fields, pairs: LISTED_VERTEX, LISTED_FIELD, LISTED_PAIR: The list; all have room
    #: for more.
    vertices: np.ndarray
    fields: np.ndarray
    pairs: np.ndarray

    @classmethod
    def empty(cls, planes: int) -> "VertexList":
        """Return a list without room."""
        return cls(
            np.zeros(planes + 1, np.int64),
            np.zeros(3, np.int64),
            np.zeros(0, LISTED_VERTEX),
            np.zeros(0, LISTED_FIELD),
            np.zeros(0, LISTED_PAIR),
        )

    def fits(self) -> bool:
        """Whether there was room for all that was found."""
        room = len(self.vertices), len(self.fields), len(self.pairs)
        return all(found <= size for found, size in zip(self.found.tolist(), room, strict=True))

    def with_room(self) -> "VertexList":
        """Return a list with room for what was found, and some more."""
        vertices, fields, pairs = (self.found * 5 // 4 + 16).tolist()
        return self._replace(
            vertices=np.zeros(vertices, LISTED_VERTEX),
            fields=np.zeros(fields, LISTED_FIELD),
            pairs=np.zeros(pairs, LISTED_PAIR),
        )
