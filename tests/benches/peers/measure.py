"""Measures our renderer and its peers on the same towel, in turns, in one run. `run` calls this; see README.md."""

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
from renderers import WARPS, Field, Ours, Peer

PEERS = {
    "mitsuba-llvm": ("mitsuba", "peer_mitsuba.py", "llvm_ad_rgb"),
    "mitsuba-scalar": ("mitsuba", "peer_mitsuba.py", "scalar_rgb"),
    "cycles-thick": ("cycles", "peer_cycles.py", "THICK"),
    "cycles-ribbons": ("cycles", "peer_cycles.py", "RIBBONS"),
}
OURS = ["single=--method single", "exact=--method exact", "tracked=--method tracked"]
TARGET = 0.2
# Lengths of the preset's loops after the edit, mm; the preset has 2.
EDITED_LENGTH = 2.3
# Samples of the pictures that growth is measured with: enough that what a picture costs beside samples hardly counts.
GROWTH_SAMPLES = 4
MOST_SAMPLES = 512


def arguments():
    parser = argparse.ArgumentParser(prog="run", description=__doc__)
    parser.add_argument("--binary", required=True, help="our program, beside which towel-bench lies; run builds both where none is given")
    parser.add_argument("--preset", required=True)
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
        environment, script, setting = PEERS[name]
        python = str(Path(given.cache) / environment / "bin" / "python")
        renderers.append(Peer(name, python, script, setting, given.size, given.verbose))
    return renderers


class Run:
    """What is measured, in turns, so that a disturbance of the machine hits all alike."""

    def __init__(self, given, renderers, folder):
        self.given, self.renderers, self.folder = given, renderers, folder
        self.picture = folder / "picture.npy"
        self.seed = 0
        self.results = {r.name: {"version": r.version, "peer": r.is_peer} for r in renderers}

    def say(self, text):
        print(f"[load {os.getloadavg()[0]:.1f}] {text}", flush=True)

    def render(self, renderer, samples):
        """Renders with a seed that nobody had before."""
        self.seed += 1
        spent = renderer.render(samples, self.seed, self.picture)
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

    def one(self, renderer, samples):
        spent, picture = self.render(renderer, samples)
        spent["squared_error"] = self.truth[renderer.name].squared_error(picture)
        pictures = self.results[renderer.name].setdefault("pictures", {})
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
                    self.one(renderer, samples)
            self.say(f"pictures of all numbers of samples, {repeat + 1} of {self.given.repeats}")
        for renderer in self.renderers:
            samples = counts[-1]
            while self.error(renderer, samples) > TARGET and samples < MOST_SAMPLES and not self.given.quick:
                samples *= 2
                self.one(renderer, samples)
                self.say(f"{renderer.name}: {samples} samples too")

    def error(self, renderer, samples):
        squares = [p["squared_error"] for p in self.results[renderer.name]["pictures"][samples]]
        return max(float(np.mean(squares)), 0.0) ** 0.5

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


def main():
    given = arguments()
    output = Path(given.output)
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="towel-peers-") as folder:
        folder = Path(folder)
        make = lambda **what: Field(given.binary, given.preset, folder, **what)
        base, edited = make(), make(length=EDITED_LENGTH)
        widths = [int(width) for width in given.growth.split(",")]
        fields = [base if width == WARPS else make(warps=width) for width in widths]
        renderers = start(given, folder)
        run = Run(given, renderers, folder)
        loads = [os.getloadavg()[0]]
        run.open(base)
        run.truths()
        loads.append(os.getloadavg()[0])
        run.errors()
        loads.append(os.getloadavg()[0])
        run.edits(edited, base)
        run.growth(fields)
        loads.append(os.getloadavg()[0])
        for renderer in renderers:
            renderer.close()
    pictures = {name: truth.picture for name, truth in run.truth.items()}
    for name, picture in pictures.items():
        save_picture(output / f"{name}.png", picture)
    alike = {
        a: {b: figures.correlation(pictures[a], pictures[b]) for b in pictures if run.results[b]["peer"]} for a in pictures
    }
    results = {
        "machine": machine() | {"loads": loads},
        "target": TARGET,
        "size": given.size,
        "repeats": given.repeats,
        "edited_length": EDITED_LENGTH,
        "alike": alike,
        "renderers": run.results,
    }
    (output / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    # Numbers of samples are text in JSON: what is reported is what was written.
    text = report.write(json.loads((output / "results.json").read_text()))
    (output / "results.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
