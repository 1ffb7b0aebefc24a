"""From results.json to tables; `report.py results.json` writes them again.

Times are given by the clock and as processor time over cores: what the clock would tell on idle cores if all of them had
work all the time. On a busy machine the second is the one to believe; it flatters what runs on one core.
"""

import json
import sys

from figures import median, time_to

KINDS = {"wall": "by the clock", "cpu": "processor time / cores"}


class Figures:
    """What the table tells of one renderer, one kind of time."""

    def __init__(self, renderer, kind, results):
        scale = 1 / results["machine"]["cores"] if kind == "cpu" else 1.0
        pictures = {int(n): rows for n, rows in renderer["pictures"].items()}
        self.points = []
        for samples, rows in sorted(pictures.items()):
            square = sum(row["squared_error"] for row in rows) / len(rows)
            self.points.append((samples, median(rows, kind) * scale, max(square, 1e-12) ** 0.5))
        self.to_target = time_to(results["target"], [point[1:] for point in self.points])
        self.first_sample = self.points[0][1]
        edits = renderer["edits"]
        part = lambda name: median([edit[name] for edit in edits if name in edit], kind) * scale
        self.rebuild = part("build") + (part("upload") if "upload" in edits[0] else 0.0)
        self.edit = part("total")
        self.growth = {name: median(rows, kind) * scale for name, rows in renderer["growth"].items()}


def seconds(time):
    return "never" if time is None else f"{time:.3f}"


def write(results):
    machine, renderers = results["machine"], results["renderers"]
    loads = ", ".join(f"{load:.1f}" for load in machine["loads"])
    lines = [
        "# Ours and the peers on one towel",
        "",
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}; load during the run {loads}. "
        f"Medians of {results['repeats']}. {results['size']} x {results['size']} pixels, 240 x 280 loops, direct light, sun of 5 degrees.",
        "",
    ]
    lines += [f"- `{name}`: {renderer['version']}" for name, renderer in renderers.items()]
    if max(machine["loads"]) > machine["cores"]:
        lines += ["", "The machine had other work: believe processor time rather than the clock."]
    for kind, title in KINDS.items():
        table = {name: Figures(renderer, kind, results) for name, renderer in renderers.items()}
        lines += ["", f"## Seconds, {title}", ""] + times(table, results) + [""] + ratios(table, renderers)
    lines += ["", "## Growth, memory", ""] + growth(renderers, results)
    lines += ["", "## relRMSE against its own converged picture", ""] + errors(renderers, results)
    lines += ["", "## The pictures", ""] + pictures(results)
    return "\n".join(lines) + "\n"


def row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def head(*cells):
    return [row(*cells), row(*["---"] * len(cells))]


def times(table, results):
    lines = head("", f"to relRMSE {results['target']}", "one sample", "edit: rebuild", "edit: rebuild + one sample")
    for name, f in table.items():
        lines.append(row(name, *map(seconds, (f.to_target, f.first_sample, f.rebuild, f.edit))))
    return lines


def ratios(table, renderers):
    """How many times faster ours is than the faster peer; below 1 the peer is the faster one."""
    peers = [name for name, renderer in renderers.items() if renderer["peer"]]
    if not peers:
        return ["No peer was measured."]
    lines = head("faster than the fastest peer, times", "to the error", "one sample", "edit")
    for name, renderer in renderers.items():
        if renderer["peer"]:
            continue
        cells = []
        for figure in ("to_target", "first_sample", "edit"):
            theirs = {peer: getattr(table[peer], figure) for peer in peers}
            theirs = {peer: time for peer, time in theirs.items() if time is not None}
            mine = getattr(table[name], figure)
            if not theirs or mine is None:
                cells.append("-")
                continue
            best = min(theirs, key=theirs.get)
            ratio = theirs[best] / mine
            cells.append(f"{ratio:.2f} ({best}{' is faster' if ratio < 1 else ''})")
        lines.append(row(name, *cells))
    return lines


def growth(renderers, results):
    sizes = list(next(iter(renderers.values()))["growth"])
    lines = head("", *[f"{size}: processor s a sample" for size in sizes], "largest / smallest", "bytes a loop")
    for name, renderer in renderers.items():
        grown = Figures(renderer, "cpu", results).growth
        memory = renderer["memory"]
        share = grown[sizes[-1]] / grown[sizes[0]]
        lines.append(row(name, *[seconds(grown[s]) for s in sizes], f"{share:.2f}", f"{memory['bytes'] / memory['loops']:.0f}"))
    lines += ["", "Bytes a loop: ours counts the records of loops, lists and bounds; peers by the growth of the process."]
    return lines


def errors(renderers, results):
    table = {name: Figures(renderer, "cpu", results).points for name, renderer in renderers.items()}
    counts = sorted({samples for points in table.values() for samples, _, _ in points})
    lines = head("samples", *counts, "noise of the converged picture, taken out")
    for name, points in table.items():
        known = {samples: f"{error:.3f}" for samples, _, error in points}
        lines.append(row(name, *[known.get(n, "") for n in counts], f"{renderers[name]['truth_noise']:.3f}"))
    return lines


def pictures(results):
    alike, renderers = results["alike"], results["renderers"]
    peers = [name for name, renderer in renderers.items() if renderer["peer"]]
    lines = head("", "mean radiance, red green blue", *[f"like {peer}" for peer in peers])
    for name, renderer in renderers.items():
        mean = " ".join(f"{channel:.3f}" for channel in renderer["mean"])
        lines.append(row(name, mean, *[f"{alike[name][peer]:.2f}" for peer in peers]))
    lines += ["", "Like: correlation of the brightness of 4 x 4 pixels in the converged pictures."]
    return lines


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        print(write(json.load(file)), end="")
