"""Stereo depth: two eyes see how far the edges are, and it takes the freest of three motions.

Source: [12] of the paper, "depth estimation from 3D reconstruction of images acquired by a modular
stereo-vision": not identified, so reconstructed as the plainest of its kind, two-eye triangulation
of edges (`edge_stereo`). How it steers is ours (`anchors.three_motions`).

Between its edges a bright thing is as far away as the nearer of them. A thing that fills the field
of view has none: of it nothing is known but that it is there, and it counts as `unknown_m` away.
The eyes see colours, not nearness: one eye alone knows no distance.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Span
from reflexarc_baselines.headings import free_along_m, headings_rad
from reflexarc_baselines.history.edge_stereo import EyeEdges, edges_in, match
from reflexarc_baselines.rays import bearings_rad
from reflexarc_baselines.steering import STAY
from reflexarc_runtime.arrays import Actions, Mask, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_SOURCE = "[12] of the paper, not identified: depth from a modular stereo-vision"

_DARK = np.float32(0.01)
"""A ray that is no brighter sees nothing."""


def eye_pair() -> RetinaSpec:
    """Two eyes 0.2 m apart, 16 rays each over 120°, whose values say which part of a ray is lit."""
    return RetinaSpec(
        rays=16,
        fov_rad=2.0 * math.pi / 3.0,
        range_m=1.5,
        shading=Shading.COLOUR,
        eyes=2,
        baseline_m=0.2,
        samples=16,
        beams=BeamRule.NEAREST_BEAM,
    )


@dataclass(frozen=True)
class Stereo:
    """Steers by the depth of the edges that both eyes see."""

    ORIGIN: ClassVar[Origin] = Origin(_SOURCE, Fidelity.RECONSTRUCTED)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "contrast": Span(0.02, 0.5, is_log=True),
        "nearest_m": Span(0.05, 0.5, is_log=True),
        "unknown_m": Span(0.1, 1.5),
        "rays": Span(1, 5, is_whole=True),
        "preference_m": Span(1e-3, 2.0, is_log=True),
    }

    contrast: float = 0.048
    """Differences below it are no edge."""
    nearest_m: float = 0.189
    """Z_min: no edge is taken to be nearer."""
    unknown_m: float = 1.23
    """How far away what is seen counts as of which neither edge is matched."""
    rays: int = 1
    """How many rays are looked along for each motion."""
    preference_m: float = 0.527
    """How much farther it must be free along another motion before it leaves its way."""

    @property
    def contract(self) -> PolicyContract:
        """Two eyes, and the reference field's motions."""
        return reference_contract(eye_pair())

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        bearings, headings = bearings_rad(self.contract.retina), headings_rad(self.contract)
        q_values = free_along_m(self.distances_m(retinas), bearings, headings, self.rays)
        q_values[:, STAY] += self.preference_m
        return q_values, q_values.argmax(axis=1)

    def distances_m(self, retinas: RetinaBatch) -> Floats:
        """Of what stands along each ray, by the eye that sees it nearer: (n, rays)."""
        eye = self.contract.retina
        newest = retinas[:, -1].astype(np.float32).mean(axis=-1) / np.float32(FULL_SCALE)
        left, right = newest[:, 0], newest[:, 1]
        edges = [edges_in(view, eye.fov_rad, self.contrast) for view in (left, right)]
        depths = match(edges[0], edges[1], eye.baseline_m, self.nearest_m)
        by_left = self._filled_m(left > _DARK, edges[0], depths.left_m)
        return np.minimum(by_left, self._filled_m(right > _DARK, edges[1], depths.right_m))

    def _filled_m(self, is_lit: Mask, edges: EyeEdges, depths_m: Floats) -> Floats:
        """Distance along each ray of one eye: (n, rays)."""
        eye = self.contract.retina
        rising = np.where(edges.signs > 0, depths_m, np.float32(np.nan))
        falling = np.where(edges.signs < 0, depths_m, np.float32(np.nan))
        is_edge = edges.signs != 0
        from_left = _carried(is_lit, is_edge, rising)
        from_right = _carried(is_lit[:, ::-1], is_edge[:, ::-1], falling[:, ::-1])[:, ::-1]
        along_m = np.fmin(from_left, from_right) / np.cos(bearings_rad(eye))
        known_m = np.where(np.isnan(along_m), np.float32(self.unknown_m), along_m)
        range_m = np.float32(eye.range_m)
        return np.where(is_lit, np.minimum(known_m, range_m), range_m).astype(np.float32)


def _carried(is_lit: Mask, is_edge: Mask, depths_m: Floats) -> Floats:
    """The depth of the edge at which what each ray sees began; NaN where none is known."""
    carried = np.full(is_lit.shape, np.nan, np.float32)
    for ray in range(1, is_lit.shape[1]):
        began = np.where(is_edge[:, ray - 1], depths_m[:, ray - 1], carried[:, ray - 1])
        carried[:, ray] = np.where(is_lit[:, ray], began, np.float32(np.nan))
    return carried
