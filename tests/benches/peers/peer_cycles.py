"""Blender's Cycles draws the towel: hair curves, the scene kept from picture to picture.

Run by measure.py: peer_cycles.py THICK|RIBBONS SIZE
"""

import os
import sys
import tempfile

import bpy
import numpy as np
from mathutils import Matrix, Vector

import worker


class Cycles:
    pieces = (2, 3)

    def __init__(self, shape, size):
        self.version = f"Cycles {bpy.app.version_string} {shape.lower()}"
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.size = size
        self.scene = scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = size
        scene.render.resolution_percentage = 100
        scene.render.use_persistent_data = True
        scene.render.use_compositing = scene.render.use_sequencer = False
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.render.image_settings.exr_codec = "NONE"
        scene.cycles_curves.shape = shape
        cycles = scene.cycles
        cycles.device = "CPU"
        cycles.use_adaptive_sampling = False
        cycles.denoiser = "OPENIMAGEDENOISE"
        # Measured: two lights need no tree, and blue noise has 0.93 of the squared error of plain Sobol points.
        cycles.use_light_tree = False
        cycles.sampling_pattern = "BLUE_NOISE"
        cycles.pixel_filter_type = "BOX"
        cycles.filter_width = 1.0
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0

    def prepare(self, _towel, strands):
        return strands.astype(np.float32)

    def open(self, towel, points):
        self.radius = towel.radius
        cycles = self.scene.cycles
        cycles.max_bounces = cycles.diffuse_bounces = towel.bounces - 1
        for material in list(bpy.data.materials):
            bpy.data.materials.remove(material)
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing)
        self.camera(towel.camera)
        self.lights(towel)
        self.ground(towel)
        self.towel_material = matt("loops", towel.albedo[0])
        self.loops = None
        self.edit(points)

    def add(self, name, data):
        thing = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(thing)
        return thing

    def camera(self, view):
        camera = bpy.data.cameras.new("camera")
        camera.sensor_fit = "VERTICAL"
        camera.angle = np.radians(view["fov"])
        camera.clip_start, camera.clip_end = 0.1, 1e5
        thing = self.add("camera", camera)
        axes = [view["right"], view["up"], [-x for x in view["forward"]], view["eye"]]
        thing.matrix_world = Matrix([[axis[row] for axis in axes] for row in range(3)] + [[0, 0, 0, 1]])
        self.scene.camera = thing

    def lights(self, towel):
        sun = bpy.data.lights.new("sun", "SUN")
        sun.angle = np.radians(towel.sun["angular_diameter"])
        irradiance = np.array(towel.sun["irradiance"])
        sun.energy = float(irradiance.max())
        sun.color = irradiance / irradiance.max()
        thing = self.add("sun", sun)
        thing.rotation_mode = "QUATERNION"
        # Lights shine along their −z.
        thing.rotation_quaternion = Vector(towel.sun["direction"]).to_track_quat("Z", "Y")
        world = self.scene.world or bpy.data.worlds.new("world")
        self.scene.world = world
        world.use_nodes = True
        background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
        background.inputs["Color"].default_value = [*towel.sky, 1.0]
        background.inputs["Strength"].default_value = 1.0

    def ground(self, towel):
        vertices, quads = towel.ground()
        mesh = bpy.data.meshes.new("ground")
        mesh.from_pydata(vertices.tolist(), [], quads.tolist())
        mesh.materials.append(matt("ground", towel.rest["ground"]["albedo"]))
        self.add("ground", mesh)

    def edit(self, points):
        loops, each, _ = points.shape
        if self.loops is None:
            self.loops = bpy.data.hair_curves.new("loops")
            self.loops.add_curves([each] * loops)
            self.loops.materials.append(self.towel_material)
            self.add("loops", self.loops)
            radius = self.loops.attributes.get("radius") or self.loops.attributes.new("radius", "FLOAT", "POINT")
            radius.data.foreach_set("value", np.full(loops * each, self.radius, np.float32))
        self.loops.attributes["position"].data.foreach_set("vector", points.ravel())
        self.loops.update_tag()

    def render(self, samples, seed, denoise=False):
        # With first-hit albedo and normals, as Cycles does unless told otherwise.
        self.scene.cycles.use_denoising = denoise
        self.scene.cycles.samples = samples
        self.scene.cycles.seed = seed
        # Settings of Cycles alone do not tell Blender that anything has changed; one of its own does, and is the cheapest.
        self.scene.render.resolution_percentage = 100
        bpy.ops.render.render()

    def pixels(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "picture.exr")
            bpy.data.images["Render Result"].save_render(path, scene=self.scene)
            image = bpy.data.images.load(path)
            pixels = np.empty(self.size**2 * 4, np.float32)
            image.pixels.foreach_get(pixels)
            bpy.data.images.remove(image)
        # From the lowest row up.
        return pixels.reshape(self.size, self.size, 4)[::-1, :, :3]


def matt(name, albedo):
    """A Lambertian material."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = [*map(float, albedo), 1.0]
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
    return material


if __name__ == "__main__":
    worker.serve(lambda: Cycles(sys.argv[1], int(sys.argv[2])))
