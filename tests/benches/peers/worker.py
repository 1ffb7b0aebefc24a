"""A peer as a process of its own that stays warm: a command a line in, an answer a line out, both JSON.

Commands: {"do": "open", "towel": NPZ}, {"do": "render", "samples": N, "seed": N, "out": NPY or null,
"denoise": true or left out}, {"do": "edit", "towel": NPZ}. Answers have times as {"wall": s, "cpu": s of all cores together}.
"""

import json
import os
import sys
import time

import numpy as np

from towel import Towel


class Clock:
    """Time since it was made, by the clock and of this process on all cores."""

    def __init__(self):
        self.wall, self.cpu = time.perf_counter(), time.process_time()

    def spent(self):
        return {"wall": time.perf_counter() - self.wall, "cpu": time.process_time() - self.cpu}


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def total(parts):
    return {key: sum(part[key] for part in parts) for key in ("wall", "cpu")}


class Worker:
    """Answers commands for a renderer, which has `prepare(towel, strands)`, `open(towel, prepared)`, `edit(prepared)`,
    `render(samples, seed)`, with `denoise` where it has a denoiser built in, and `pixels()`; `pieces` tells into how many pieces legs and arch of a strand are cut.

    What comes before `open` and `edit` is not counted against a peer: its user might have it from elsewhere.
    """

    def __init__(self, renderer):
        self.renderer = renderer

    def strands(self, path):
        towel = Towel(path)
        clock = Clock()
        prepared = self.renderer.prepare(towel, towel.strands(*self.renderer.pieces))
        return towel, prepared, clock.spent()

    def open(self, command):
        towel, prepared, generate = self.strands(command["towel"])
        before, clock = resident_bytes(), Clock()
        self.renderer.open(towel, prepared)
        # Some renderers build when they first render.
        self.renderer.render(1, 0)
        return {"generate": generate, "build": clock.spent(), "bytes": resident_bytes() - before, "loops": towel.count}

    def render(self, command):
        clock = Clock()
        denoise = {"denoise": True} if command.get("denoise") else {}
        self.renderer.render(command["samples"], command["seed"], **denoise)
        spent = clock.spent()
        if command.get("out"):
            np.save(command["out"], self.renderer.pixels())
        return spent

    def edit(self, command):
        _, prepared, generate = self.strands(command["towel"])
        clock = Clock()
        self.renderer.edit(prepared)
        build, clock = clock.spent(), Clock()
        self.renderer.render(1, command.get("seed", 0))
        sample = clock.spent()
        return {"generate": generate, "build": build, "sample": sample, "total": total([build, sample])}


def serve(make):
    """Answers commands on the standard input until it ends; what the renderer prints goes to stderr."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    worker = Worker(make())
    print(json.dumps({"version": worker.renderer.version}), file=answers, flush=True)
    for line in sys.stdin:
        command = json.loads(line)
        answer = getattr(worker, command["do"])(command)
        print(json.dumps(answer), file=answers, flush=True)
