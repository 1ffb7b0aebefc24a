"""The towel that every renderer draws: what `export loops` tells, as arrays, and the strand or fibres of each loop.

Lengths in mm, world space with z up from the cloth, linear RGB.
"""

import json

import numpy as np

# The program leaves this share of the strand's diameter free on both sides of it, for stray fibres.
MARGIN = 0.12
# Legs stand up to 12 % closer than there is room for, so that no two loops are alike; this is the mean.
LEG_SPACING = 0.94
# Facets of each half round warp of the ground.
GROUND_FACETS = 6


# Fibres are spread over a yarn's section like the seeds of a sunflower.
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def convert(json_path, npz_path, task):
    """Writes the loops and all else of an export, and what of a task peers must know, as arrays, which load in no time."""
    with open(json_path) as file:
        export = json.load(file)
    export["fibres"] = {"count": task.fibres, "radius": task.fibre_radius, "turns": task.fibre_turns}
    export["bounces"], export["albedo_scale"] = task.bounces, task.albedo_scale
    loops = export.pop("loops")
    corners = np.array([[loop[f"p{k}"] for k in range(4)] for loop in loops])
    albedo = np.array([loop["albedo"] for loop in loops])
    np.savez(npz_path, corners=corners, albedo=albedo, rest=json.dumps(export))


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


class Towel:
    """What one export tells."""

    def __init__(self, npz_path):
        with np.load(npz_path) as file:
            self.corners = file["corners"]
            self.albedo = file["albedo"]
            self.rest = json.loads(str(file["rest"]))
        self.albedo = np.minimum(self.albedo * self.rest["albedo_scale"], 1.0)
        self.bounces = self.rest["bounces"]
        self.camera = self.rest["cameras"][0]
        [self.sun] = self.rest["suns"]
        self.sky = self.rest["environment"]["radiance"]
        yarn = self.rest["yarn"]
        self.yarn_radius = yarn["diameter"] / 2
        self.fibres = self.rest["fibres"]
        self.radius = self.fibres["radius"] or self.yarn_radius
        self.is_supported(yarn)

    def is_supported(self, yarn):
        """Refuses what the peers' scenes leave out."""
        if yarn["kind"] != "terry":
            raise SystemExit(f"the pile's kind is {yarn['kind']}, the peers draw terry alone")
        if self.rest["environment"]["kind"] != "constant":
            raise SystemExit("the environment varies, the peers' is constant")
        if np.ptp(self.albedo, axis=0).max() > 0:
            raise SystemExit("loops have several colours, the peers' have one")

    @property
    def count(self):
        return len(self.corners)

    def centre_line(self, leg_pieces, arch_pieces):
        """Points (u, v) of the strand inside its patch: a leg, half an ellipse, a leg.

        Pieces of a leg grow towards the root, so that a smooth curve through the points does not swing where the arch
        begins.
        """
        yarn = self.rest["yarn"]
        width, length, _ = yarn["reference_size"]
        margin = yarn["diameter"] * (0.5 + MARGIN)
        half = 0.5 * LEG_SPACING * max(width - 2 * margin, 0)
        top = max(length - margin, 0.3 * length)
        rise = min(half, top)
        leg = top - rise
        growth = np.arange(leg_pieces + 1) / leg_pieces
        up = leg * (1 - (1 - growth) ** 2) if leg_pieces > 1 else leg * growth
        angle = np.pi * np.arange(1, arch_pieces) / arch_pieces
        x = np.concatenate([np.full(len(up), -half), -half * np.cos(angle), np.full(len(up), half)])
        y = np.concatenate([up, leg + rise * np.sin(angle), up[::-1]])
        return 0.5 + x / width, y / length

    def strands(self, leg_pieces, arch_pieces):
        """Points of all curves, an array of curves x points x 3: one in the middle of each loop's yarn, or its fibres."""
        u, v = self.centre_line(leg_pieces, arch_pieces)
        # Bilinear in the corners: P0, P1, P2, P3 around the patch.
        weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
        lines = np.einsum("kc,ncx->nkx", weights, self.corners)
        if self.fibres["count"] == 1:
            return lines
        along_u = np.einsum("kc,ncx->nkx", np.stack([v - 1, 1 - v, v, -v], axis=1), self.corners)
        along_v = np.einsum("kc,ncx->nkx", np.stack([u - 1, -u, u, 1 - u], axis=1), self.corners)
        out_of_patch = unit(np.cross(along_u, along_v))
        beside = unit(np.cross(out_of_patch, np.gradient(lines, axis=1)))
        steps = np.linalg.norm(np.diff(lines, axis=1), axis=2)
        arc = np.concatenate([np.zeros((len(lines), 1)), np.cumsum(steps, axis=1)], axis=1)
        curves = []
        for fibre in range(self.fibres["count"]):
            reach = (self.yarn_radius - self.radius) * np.sqrt((fibre + 0.5) / self.fibres["count"])
            angle = (fibre * GOLDEN_ANGLE + 2 * np.pi * self.fibres["turns"] * arc)[..., None]
            curves.append(lines + reach * (np.cos(angle) * beside + np.sin(angle) * out_of_patch))
        return np.concatenate(curves)

    def ground(self):
        """Vertices and quads of the warps' upper halves; wefts lie below them."""
        ground, (px, py) = self.rest["ground"], self.rest["pitch"]
        warps, wefts = self.rest["warps"], self.rest["wefts"]
        # Where neighbours meet.
        reach = min(ground["warp_radius"], px / 2)
        across = np.linspace(-reach, reach, GROUND_FACETS + 1)
        height = ground["crimp"] + np.sqrt(ground["warp_radius"] ** 2 - across**2)
        centres = (np.arange(warps) + 0.5 - warps / 2) * px
        x = (centres[:, None] + across).ravel()
        z = np.tile(height, warps)
        far = wefts / 2 * py
        near_edge = np.stack([x, np.full_like(x, -far), z], axis=1)
        far_edge = near_edge * [1, -1, 1]
        vertices = np.concatenate([near_edge, far_edge])
        first = (np.arange(warps)[:, None] * (GROUND_FACETS + 1) + np.arange(GROUND_FACETS)).ravel()
        quads = np.stack([first, first + 1, first + 1 + len(x), first + len(x)], axis=1)
        return vertices, quads
