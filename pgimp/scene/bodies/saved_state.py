"""Particles that go on from a run's own file: what is written there, and what they take of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pgimp.errors import CaseError
from pgimp.kernels.data.particles import COLUMNS, Particles, continued_columns
from pgimp.scene.bodies.lattice import ParticleBlock
from pgimp.scene.scene import Scene

#: Columns that all files have.
_ALWAYS = ("x", "v", "F", "sigma", "V", "V0", "m")

_CHECKPOINT = "take a checkpoint of its run, checkpoints/step-*.h5, which has it"


def saved_attributes(scene: Scene) -> dict[str, object]:
    """Attributes of a frame or a checkpoint that say what its state is of."""
    laws = [scene.materials.entries[material] for material in scene.materials.body_material]
    return {
        "dimensions": scene.dimension,
        "geometry": scene.case.geometry,
        "bodies": list(scene.body_names),
        "models": [str(getattr(law, "model", "")) for law in laws],
        "mass-scaling": float(scene.case.time.mass_scaling),
    }


def checkpoint_attributes(scene: Scene, fields: Sequence[int]) -> dict[str, object]:
    """Attributes of a checkpoint: those of a frame, and how to read states and vertices.

    `fields` are the bodies' velocity fields; () is one of all.
    """
    frame, states = scene.domain.frame, []
    for material in scene.materials.body_material:
        found = [
            (name, int(kept.first[material]), kept.state.width(scene.dimension))
            for name, kept in scene.materials.states.kept.items()
        ]
        states.append(" ".join(f"{n}:{first}:{width}" for n, first, width in found if first >= 0))
    return saved_attributes(scene) | {
        "configurations": [
            "initial" if body.formulation == "total-lagrangian" else "current"
            for body in scene.case.bodies.values()
        ],
        "states": states,
        "origin": np.array(frame.origin, float),
        "cell": np.array(frame.cell, float),
        "cells": np.array(frame.cells, np.int64),
        "fields": np.array(fields or [0] * len(states), np.int64),
        "ghost": np.int64(frame.ghost),
    }


def restore_state(scene: Scene, p: Particles, rows: slice, block: ParticleBlock) -> None:
    """Set the state of particles from a run's own file, after that of the new loads.

    Raises
    ------
    CaseError
        If the file has no column that goes on.
    """
    assert block.saved is not None
    columns, name = block.columns, scene.body_names[block.body]
    material = scene.materials.body_material[block.body]
    for column in _ALWAYS:
        getattr(p, column)[rows] = columns[column]
    p.state[rows] = scene.materials.states.initial[material]
    for state, values in block.states.items():
        first = scene.materials.states.first(state, material)
        p.state[rows, first : first + values.shape[1]] = values
    if p.origin.shape[1]:
        p.origin[rows] = columns.get("origin", columns["x"])
    if p.surface_F_correction.shape[1]:  # nothing has moved
        D = scene.dimension
        square = p.F[rows, : D * D].reshape(-1, D, D)
        p.surface_F_correction[rows, : D * D] = np.linalg.inv(square).reshape(-1, D * D)
        p.surface_F_correction[rows, D * D :] = 1.0 / p.F[rows, D * D :]
    for column in continued_columns():
        array: np.ndarray = getattr(p, column)
        if not array.shape[1] or (column == "L" and not scene.carried.affine):
            continue
        if column in columns and columns[column].shape[1:] == array.shape[1:]:
            array[rows] = columns[column]
        elif (
            COLUMNS[column].continued == "required"
            or column in columns
            or not block.saved.checkpoint
        ):
            raise CaseError(
                f"bodies.{name}.region: {block.saved.title} lacks something that particles of this "
                f"case keep, '{COLUMNS[column].meaning}': "
                + ("its run did not keep it" if block.saved.checkpoint else _CHECKPOINT)
            )
        elif column == "L":
            array[rows] = 0.0
