"""Measures our renderer and its peers on the same towels, in turns, in one run. `run` calls this; see README.md."""

import argparse
import json
import os
import platform
import shlex
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")  # reads pictures

import figures
import report
from renderers import Field, Ours, Peer
from tasks import TASKS

# Environment, script, its setting, and whether Open Image Denoise is built in.
PEERS = {
    "mitsuba-llvm": ("mitsuba", "peer_mitsuba.py", "llvm_ad_rgb", False),
    "mitsuba-scalar": ("mitsuba", "peer_mitsuba.py", "scalar_rgb", False),
    "cycles-thick": ("cycles", "peer_cycles.py", "THICK", True),
    "cycles-ribbons": ("cycles", "peer_cycles.py", "RIBBONS", True),
}
OURS = ["single=--method single", "exact=--method exact", "tracked=--method tracked"]
TARGETS = {"relRMSE": 0.2, "FLIP": 0.1}
# The task whose towel grows.
GROWING = "smooth"
# Samples of the pictures that growth is measured with: enough that what a picture costs beside samples hardly counts.
GROWTH_SAMPLES = 4
MOST_SAMPLES = 512


def arguments():
    parser = argparse.ArgumentParser(prog="run", description=__doc__)
    parser.add_argument("--binary", required=True, help="our program, beside which towel-bench lies; run builds both where none is given")
    parser.add_argument("--root", required=True, help="the repository, in which the tasks' presets are")
    parser.add_argument("--tasks", default=",".join(TASKS), help="which towels, with commas between them")
    parser.add_argument("--cache", required=True, help="folder of the peers' environments")
    parser.add_argument("-o", "--output", default="peers-out", help="folder to write to")
    parser.add_argument(
        "--ours",
        action="append",
        metavar="NAME=ARGUMENTS",
        help=f"a way to run ours, with --method and --set as for render; repeat it for several (default: {', '.join(OURS)})",
    )
    parser.add_argument("--peers", default=",".join(PEERS), help="which peers, with commas between them")
    parser.add_argument("--size", type=int, default=512, help="width and height of the pictures, pixels")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--samples", default="1,2,4,8,16")
    parser.add_argument("--truth", type=int, default=64, help="samples of each half of a converged picture")
    parser.add_argument("--growth", default="120,240,480", help="widths of the towels that growth is measured with")
    parser.add_argument("--quick", action="store_true", help="everything once and small: a test that it works")
    parser.add_argument("--verbose", action="store_true", help="show what the peers print")
    given = parser.parse_args()
    if given.quick:
        given.size, given.repeats, given.samples, given.truth, given.growth = 128, 1, "1,4", 4, "120,240"
    return given


def start(given, folder):
    ours = [argument.split("=", 1) for argument in given.ours or OURS]
    renderers = [Ours(name, given.binary, shlex.split(words), given.size, folder) for name, words in ours]
    for name in filter(None, given.peers.split(",")):
        environment, script, setting, has_denoiser = PEERS[name]
        python = str(Path(given.cache) / environment / "bin" / "python")
        renderers.append(Peer(name, python, script, setting, has_denoiser, given.size, given.verbose))
    return renderers


class Run:
    """What is measured of one task, in turns, so that a disturbance of the machine hits all alike."""

    def __init__(self, given, renderers, folder):
        self.given, self.renderers, self.folder = given, renderers, folder
        self.picture = folder / "picture.npy"
        self.seed = 0
        self.results = {r.name: {"version": r.version, "peer": r.is_peer} for r in renderers}

    def say(self, text):
        print(f"[load {os.getloadavg()[0]:.1f}] {text}", flush=True)

    def render(self, renderer, samples, denoised=False):
        """Renders with a seed that nobody had before."""
        self.seed += 1
        draw = renderer.denoised if denoised else renderer.render
        spent = draw(samples, self.seed, self.picture)
        return spent, np.load(self.picture)

    def open(self, field):
        for renderer in self.renderers:
            result = self.results[renderer.name]
            opened = renderer.open(field)
            # Only what a fresh process takes tells its memory.
            result.setdefault("memory", opened)

    def truths(self):
        self.truth = {}
        for renderer in self.renderers:
            halves = [self.render(renderer, self.given.truth)[1] for _ in range(2)]
            truth = self.truth[renderer.name] = figures.Truth(*halves)
            self.results[renderer.name]["mean"] = [float(c) for c in truth.picture.mean(axis=(0, 1))]
            self.results[renderer.name]["truth_noise"] = truth.relative_noise
            self.say(f"{renderer.name}: converged picture, noise {truth.relative_noise:.3f}")

    def one(self, renderer, samples, denoised):
        spent, picture = self.render(renderer, samples, denoised)
        truth = self.truth[renderer.name]
        spent |= {"squared_error": truth.squared_error(picture), "flip": truth.flip(picture)}
        pictures = self.results[renderer.name].setdefault("denoised" if denoised else "pictures", {})
        pictures.setdefault(samples, []).append(spent)

    def errors(self):
        counts = [int(n) for n in self.given.samples.split(",")]
        for samples in counts:
            for renderer in filter(lambda renderer: renderer.is_peer, self.renderers):
                # Warms up what is compiled for a number of samples; ours is a new process each time anyhow.
                renderer.render(samples, 0)
        for repeat in range(self.given.repeats):
            for samples in counts:
                for renderer in self.renderers:
                    for denoised in (False, True):
                        self.one(renderer, samples, denoised)
            self.say(f"pictures of all numbers of samples, {repeat + 1} of {self.given.repeats}")
        for renderer in self.renderers:
            samples = counts[-1]
            while not self.is_quiet(renderer, samples) and samples < MOST_SAMPLES and not self.given.quick:
                samples *= 2
                self.one(renderer, samples, False)
                self.say(f"{renderer.name}: {samples} samples too")

    def is_quiet(self, renderer, samples):
        """Whether plain pictures of so many samples meet both targets."""
        rows = self.results[renderer.name]["pictures"][samples]
        square, flip = (np.mean([row[key] for row in rows]) for key in ("squared_error", "flip"))
        return square <= TARGETS["relRMSE"] ** 2 and flip <= TARGETS["FLIP"]

    def edits(self, there, back):
        for repeat in range(self.given.repeats + 1):
            for renderer in self.renderers:
                times = renderer.edit(there, back)
                # The first is for warming up.
                if repeat > 0 or self.given.quick:
                    self.results[renderer.name].setdefault("edits", []).extend(times)
        self.say("edits of all loop lengths")

    def growth(self, fields):
        for field in fields:
            self.open(field)
            for _ in range(self.given.repeats):
                for renderer in self.renderers:
                    self.seed += 1
                    spent = renderer.render(GROWTH_SAMPLES, self.seed)
                    per_sample = {key: spent[key] / GROWTH_SAMPLES for key in spent}
                    grown = self.results[renderer.name].setdefault("growth", {})
                    grown.setdefault(field.name, []).append(per_sample)
            self.say(f"growth: {field.name}")


def save_picture(path, picture):
    """As displayed: sRGB, hard clip."""
    bitmap = mi.Bitmap(np.ascontiguousarray(picture, np.float32))
    bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True).write(str(path))


def machine():
    with open("/proc/cpuinfo") as file:
        model = next((line.split(":")[1].strip() for line in file if line.startswith("model name")), "unknown processor")
    return {"processor": model, "cores": os.cpu_count(), "system": platform.platform()}


def measure(given, task, renderers, folder, output):
    """All that is measured of one task."""
    preset = str(Path(given.root) / task.preset)
    make = lambda **what: Field(given.binary, preset, task, folder, **what)
    base, edited = make(), make(length=task.edited_length)
    widths = [int(width) for width in given.growth.split(",")] if task.name == GROWING else []
    fields = [base if width == task.warps else make(warps=width) for width in widths]
    run = Run(given, renderers, folder)
    loads = [os.getloadavg()[0]]
    for step in (lambda: run.open(base), run.truths, run.errors, lambda: run.edits(edited, base), lambda: run.growth(fields)):
        step()
        loads.append(os.getloadavg()[0])
    pictures = {name: truth.picture for name, truth in run.truth.items()}
    for name, picture in pictures.items():
        save_picture(output / f"{task.name}-{name}.png", picture)
    alike = {
        a: {b: figures.correlation(pictures[a], pictures[b]) for b in pictures if run.results[b]["peer"]} for a in pictures
    }
    return {"about": task.about, "loads": loads, "alike": alike, "renderers": run.results}


def main():
    given = arguments()
    output = Path(given.output)
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="towel-peers-") as folder:
        folder = Path(folder)
        renderers = start(given, folder)
        tasks = {name: measure(given, TASKS[name], renderers, folder, output) for name in given.tasks.split(",")}
        for renderer in renderers:
            renderer.close()
    results = {"machine": machine(), "targets": TARGETS, "size": given.size, "repeats": given.repeats, "tasks": tasks}
    (output / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    # Numbers of samples are text in JSON: what is reported is what was written.
    text = report.write(json.loads((output / "results.json").read_text()))
    (output / "results.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
