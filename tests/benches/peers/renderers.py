"""The renderers as measure.py sees them: all have `open(field)`, `render(samples, seed, picture)`, `denoised(samples, seed,
picture)` and `edit(there, back)`.

Times are {"wall": s, "cpu": s of all cores together}; pictures are linear RGB arrays in .npy files. Denoised are all by
Open Image Denoise: Cycles' by its own, which knows first-hit albedo and normals, the others' by the library from the
picture alone, in this process.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np
import pyoidn

from tasks import HERE
from towel import convert
from worker import Clock, total


def denoise(path):
    """Denoises a picture in place; the time that it took."""
    noisy = np.ascontiguousarray(np.load(path), np.float32)
    clock = Clock()
    clean = pyoidn.denoise(noisy, hdr=True)
    spent = clock.spent()
    np.save(path, clean)
    return spent


class Field:
    """A task's towel: the preset at a size and a loop length, as arguments of our program and as arrays."""

    def __init__(self, program, preset, task, folder, warps=None, length=None):
        warps = warps or task.warps
        scale = warps / task.warps
        wefts = task.wefts * warps // task.warps
        x, y, z = task.target
        self.name = f"{warps}x{wefts}" + (f"-length-{length}" if length else "")
        self.program, self.preset = program, preset
        sets = {}
        if warps != task.warps:
            # The same picture of smaller or larger loops.
            sets |= {"sheet.warps": warps, "sheet.wefts": wefts}
            sets |= {"view.cameras[0].distance": task.distance * scale}
            sets |= {"view.cameras[0].target": f"[{x * scale}, {y * scale}, {z}]"}
        self.length = None if length is None else f"length.value={length}"
        self.sets = [f"--set={path}={value}" for path, value in sets.items()]
        edit = [] if length is None else [f"--set={self.length}"]
        self.arrays = str(folder / f"{task.name}-{self.name}.npz")
        export = str(folder / f"{task.name}-{self.name}.json")
        command = [program, "export", "loops", preset, "-o", export, *self.sets, *edit]
        subprocess.run(command, check=True)
        convert(export, self.arrays, task)
        os.remove(export)


class Ours:
    """Our program with some settings; a process for each picture, timed by itself."""

    is_peer = False

    def __init__(self, name, program, arguments, size, folder):
        self.name, self.program, self.arguments, self.folder = name, program, arguments, folder
        self.size = f"{size}x{size}"
        told = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout
        self.version = told.splitlines()[0] + " " + " ".join(arguments)

    def open(self, field):
        self.field = field
        stats = self.run(1, 0, self.folder / "ours.exr")
        loops = stats["loops"]
        return {"bytes": stats["bytes"]["per_loop"] * loops, "scene_bytes": stats["bytes"]["scene"], "loops": loops}

    def run(self, samples, seed, picture):
        stats = self.folder / "ours.json"
        command = [self.program, "render", self.field.preset, "-o", picture, "--size", self.size, "--samples", samples]
        command += ["--seed", seed, "--stats", stats, "--backend", "cpu", "--quiet", *self.field.sets, *self.arguments]
        subprocess.run([str(word) for word in command], check=True)
        return json.loads(stats.read_text())

    def render(self, samples, seed, picture=None):
        exr = self.folder / "ours.exr"
        stats = self.run(samples, seed, exr)
        if picture:
            form = mi.Bitmap.PixelFormat.RGB
            np.save(picture, np.array(mi.Bitmap(str(exr)).convert(form, mi.Struct.Type.Float32, srgb_gamma=False)))
        return {"wall": stats["seconds"]["render"], "cpu": stats["processor_seconds"]}

    def denoised(self, samples, seed, picture):
        return total([self.render(samples, seed, picture), denoise(picture)])

    def edit(self, there, _back):
        """The edit and taking it back, each after the other was shown."""
        out = self.folder / "edits.json"
        command = [Path(self.program).with_name("towel-bench"), "edits", self.field.preset, "--edit", there.length, "--repeats", "1", "--size", self.size]
        command += ["-o", out, "--backend", "cpu", *self.field.sets, *self.arguments]
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
        times = lambda part: {"wall": part["wall"], "cpu": part["processor"]}
        rows = json.loads(out.read_text())
        names = {"build": "compile", "upload": "upload", "sample": "sample", "total": "total"}
        return [{mine: times(row[theirs]) for mine, theirs in names.items()} for row in rows]

    def close(self):
        pass


class Peer:
    """A peer in a warm process of its own."""

    is_peer = True

    def __init__(self, name, python, script, setting, has_denoiser, size, verbose):
        self.name, self.has_denoiser = name, has_denoiser
        self.process = subprocess.Popen(
            [python, "-W", "ignore", HERE / script, setting, str(size)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=None if verbose else subprocess.DEVNULL,
            text=True,
        )
        self.version = self.answer()["version"]

    def answer(self):
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"{self.name} has ended; --verbose shows what it said")
        return json.loads(line)

    def ask(self, **command):
        self.process.stdin.write(json.dumps(command) + "\n")
        self.process.stdin.flush()
        return self.answer()

    def open(self, field):
        return self.ask(do="open", towel=field.arrays)

    def render(self, samples, seed, picture=None):
        return self.ask(do="render", samples=samples, seed=seed, out=picture and str(picture))

    def denoised(self, samples, seed, picture):
        if self.has_denoiser:
            return self.ask(do="render", samples=samples, seed=seed, out=str(picture), denoise=True)
        return total([self.render(samples, seed, picture), denoise(picture)])

    def edit(self, there, back):
        return [self.ask(do="edit", towel=field.arrays) for field in (there, back)]

    def close(self):
        self.process.stdin.close()
        self.process.wait()
