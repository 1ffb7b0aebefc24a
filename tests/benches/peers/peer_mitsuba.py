"""Mitsuba 3 draws the towel: B-spline curves on Embree, one thread a core.

Run by measure.py: peer_mitsuba.py llvm_ad_rgb|scalar_rgb SIZE
"""

import os
import sys
import tempfile

import mitsuba as mi
import numpy as np

import worker

# The sun is a disc so far away that all of the cloth sees it under the same angle, to a thousandth.
SUN_DISTANCE = 1000.0


def interpolating(points):
    """Control points (loops x points + 2 x 3) of uniform cubic B-splines through `points`, straight at their ends."""
    count = points.shape[1]
    matrix = np.zeros((count + 2, count + 2))
    for row in range(count):
        matrix[row + 1, row : row + 3] = [1 / 6, 4 / 6, 1 / 6]
    matrix[0, :3] = matrix[-1, -3:] = [1, -2, 1]
    return np.einsum("ck,nkx->ncx", np.linalg.inv(matrix)[:, 1:-1], points)


def set_array(parameters, key, value):
    """What `parameters[key] = value` does, which in scalar variants cannot change the length of an array."""
    current, kind, _, _ = parameters.properties[key]
    parameters.set_dirty(key)
    if kind is None:
        parameters.set_property(current, value)
    else:
        parameters.set_property(current, kind, value)


def integrator(bounces):
    """One sample of a light at each scattering, and one of the surface, which alone finds the sky."""
    if bounces == 1:
        return {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1}
    # Depth counts the light as well; roulette from the fifth scattering on, as ours.
    return {"type": "path", "max_depth": bounces + 1, "rr_depth": 5}


class Mitsuba:
    pieces = (2, 3)

    def __init__(self, variant, size):
        mi.set_variant(variant)
        self.version = f"Mitsuba {mi.__version__} {variant}"
        self.size = size

    def prepare(self, towel, strands):
        """Control points with radii of all strands."""
        control = interpolating(strands)
        rows = np.full((*control.shape[:2], 4), towel.radius, np.float32)
        rows[..., :3] = control
        return rows

    def open(self, towel, rows):
        camera, distance = towel.camera, SUN_DISTANCE * np.linalg.norm(towel.rest["pitch"]) * towel.rest["warps"]
        eye, forward = np.array(camera["eye"]), np.array(camera["forward"])
        half_angle = np.radians(towel.sun["angular_diameter"] / 2)
        sun_at = distance * np.array(towel.sun["direction"])
        radiance = np.array(towel.sun["irradiance"]) / (np.pi * np.sin(half_angle) ** 2)
        vector = lambda v: mi.ScalarPoint3f(*map(float, v))
        rgb = lambda c: {"type": "rgb", "value": [float(x) for x in c]}
        with tempfile.TemporaryDirectory() as folder:
            # Curves come from a file alone; their points are set when the scene stands.
            curve = os.path.join(folder, "curve.txt")
            np.savetxt(curve, [[0, 0, z, 1] for z in range(4)])
            self.scene = mi.load_dict(
                {
                    "type": "scene",
                    "integrator": integrator(towel.bounces),
                    "sensor": {
                        "type": "perspective",
                        "fov": camera["fov"],
                        "fov_axis": "y",
                        "to_world": mi.ScalarTransform4f().look_at(
                            origin=vector(eye), target=vector(eye + forward), up=vector(camera["up"])
                        ),
                        "film": {
                            "type": "hdrfilm",
                            "width": self.size,
                            "height": self.size,
                            "rfilter": {"type": "box"},
                            "pixel_format": "rgb",
                            "component_format": "float32",
                        },
                        "sampler": {"type": "multijitter"},
                    },
                    # Samples of all of the sky are wasted on what is below the surface: at equal time this has 0.7 of the
                    # squared error that equal weights for sun and sky have.
                    "sky": {"type": "constant", "radiance": rgb(towel.sky), "sampling_weight": 0.0},
                    "sun": {
                        "type": "disk",
                        "to_world": mi.ScalarTransform4f().look_at(
                            origin=vector(sun_at), target=vector(0 * sun_at), up=vector([0.0, 1.0, 0.1])
                        )
                        @ mi.ScalarTransform4f().scale(float(distance * np.tan(half_angle))),
                        "emitter": {"type": "area", "radiance": rgb(radiance)},
                    },
                    "loops": {
                        "type": "bsplinecurve",
                        "filename": curve,
                        "bsdf": {"type": "diffuse", "reflectance": rgb(towel.albedo[0])},
                    },
                    "ground": self.ground(towel),
                }
            )
        self.edit(rows)

    def ground(self, towel):
        vertices, quads = towel.ground()
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        albedo = [float(x) for x in towel.rest["ground"]["albedo"]]
        bsdf = mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": albedo}}})
        properties = mi.Properties()
        properties["ground_bsdf"] = bsdf
        mesh = mi.Mesh("ground", len(vertices), len(triangles), props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = vertices.astype(np.float32).ravel()
        parameters["faces"] = triangles.astype(np.uint32).ravel()
        parameters.update()
        return mesh

    def edit(self, rows):
        loops, each, _ = rows.shape
        first = (np.arange(loops, dtype=np.uint32)[:, None] * each + np.arange(each - 3, dtype=np.uint32)).ravel()
        parameters = mi.traverse(self.scene)
        parameters["loops.control_point_count"] = loops * each
        set_array(parameters, "loops.control_points", rows.ravel())
        set_array(parameters, "loops.segment_indices", first)
        parameters.update()

    def render(self, samples, seed):
        self.image = mi.render(self.scene, spp=samples, seed=seed)
        # Without this, work is only queued.
        self.image = np.array(self.image)

    def pixels(self):
        return self.image.reshape(self.size, self.size, 3)


if __name__ == "__main__":
    worker.serve(lambda: Mitsuba(sys.argv[1], int(sys.argv[2])))
