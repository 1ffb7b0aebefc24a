"""From results.json to tables; `report.py results.json` writes them again.

Times are given by the clock and as processor time over cores: what the clock would tell on idle cores if all of them had
work all the time. On a busy machine the second is the one to believe; it flatters what runs on one core.
"""

import json
import sys

from figures import median, time_to

KINDS = {"wall": "by the clock", "cpu": "processor time / cores"}


class Figures:
    """What the tables tell of one renderer in one task, one kind of time."""

    def __init__(self, renderer, kind, results):
        scale = 1 / results["machine"]["cores"] if kind == "cpu" else 1.0
        self.plain = Curve(renderer["pictures"], kind, scale, results["targets"])
        self.denoised = Curve(renderer["denoised"], kind, scale, results["targets"])
        self.first_sample = self.plain.points[0][1]
        edits = renderer["edits"]
        part = lambda name: median([edit[name] for edit in edits if name in edit], kind) * scale
        self.rebuild = part("build") + (part("upload") if "upload" in edits[0] else 0.0)
        self.edit = part("total")
        self.growth = {name: median(rows, kind) * scale for name, rows in renderer.get("growth", {}).items()}

    def to_target(self, measure, denoised=False):
        """Seconds of rendering until the error by a measure is at its target."""
        return (self.denoised if denoised else self.plain).to_target[measure]

    def from_edit(self, measure, denoised=False):
        """The same from an edit of all lengths on."""
        time = self.to_target(measure, denoised)
        return None if time is None else self.rebuild + time


class Curve:
    """Samples, seconds, relRMSE and FLIP of pictures, fewest samples first."""

    def __init__(self, pictures, kind, scale, targets):
        self.points = []
        for samples, rows in sorted((int(n), rows) for n, rows in pictures.items()):
            mean = lambda key: sum(row[key] for row in rows) / len(rows)
            error = max(mean("squared_error"), 1e-12) ** 0.5
            self.points.append((samples, median(rows, kind) * scale, error, mean("flip")))
        place = {"relRMSE": 2, "FLIP": 3}
        self.to_target = {
            measure: time_to(target, [(point[1], point[place[measure]]) for point in self.points])
            for measure, target in targets.items()
        }


def seconds(time):
    return "never" if time is None else f"{time:.3f}"


def write(results):
    machine, tasks = results["machine"], results["tasks"]
    renderers = next(iter(tasks.values()))["renderers"]
    lines = [
        "# Ours and the peers on the same towels",
        "",
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}. "
        f"Medians of {results['repeats']}. {results['size']} x {results['size']} pixels.",
        "",
    ]
    lines += [f"- `{name}`: {renderer['version']}" for name, renderer in renderers.items()]
    for name, task in tasks.items():
        lines += ["", f"# Task `{name}`: {task['about']}", ""] + of_task(task, results)
    return "\n".join(lines) + "\n"


def of_task(task, results):
    renderers = task["renderers"]
    lines = [f"Load during the run: {', '.join(f'{load:.1f}' for load in task['loads'])}."]
    if max(task["loads"]) > results["machine"]["cores"]:
        lines += ["The machine had other work: believe processor time rather than the clock."]
    for kind, title in KINDS.items():
        table = {name: Figures(renderer, kind, results) for name, renderer in renderers.items()}
        lines += ["", f"## Seconds, {title}", ""] + times(table, results) + [""] + ratios(table, renderers, results)
    lines += ["", "## Errors against its own converged picture, relRMSE and FLIP", ""] + errors(renderers, results)
    if any("growth" in renderer for renderer in renderers.values()):
        lines += ["", "## Growth, memory", ""] + growth(renderers, results)
    return lines + ["", "## The pictures", ""] + pictures(task)


def row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def head(*cells):
    return [row(*cells), row(*["---"] * len(cells))]


def targets(results):
    return [f"{measure} {target}" for measure, target in results["targets"].items()]


def times(table, results):
    to = [f"to {target}" for target in targets(results)]
    lines = head("", *to, *[f"{t}, denoised" for t in to], "one sample", "edit: rebuild", "edit: rebuild + one sample")
    for name, f in table.items():
        reached = [f.to_target(measure, denoised) for denoised in (False, True) for measure in results["targets"]]
        lines.append(row(name, *map(seconds, (*reached, f.first_sample, f.rebuild, f.edit))))
    return lines


def ratios(table, renderers, results):
    """How many times faster ours is than the fastest peer; below 1 the peer is the faster one."""
    peers = [name for name, renderer in renderers.items() if renderer["peer"]]
    if not peers:
        return ["No peer was measured."]
    columns = {"one sample": lambda f: f.first_sample, "edit + one sample": lambda f: f.edit}
    for measure, title in zip(results["targets"], targets(results)):
        columns[f"to {title}"] = lambda f, measure=measure: f.to_target(measure)
        columns[f"edit to {title}"] = lambda f, measure=measure: f.from_edit(measure)
        columns[f"edit to {title}, denoised"] = lambda f, measure=measure: f.from_edit(measure, True)
    lines = head("faster than the fastest peer, times", *columns)
    for name, renderer in renderers.items():
        if renderer["peer"]:
            continue
        cells = []
        for figure in columns.values():
            theirs = {peer: figure(table[peer]) for peer in peers}
            theirs = {peer: time for peer, time in theirs.items() if time is not None}
            mine = figure(table[name])
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
    table = {name: Figures(renderer, "cpu", results) for name, renderer in renderers.items()}
    curves = {}
    for name, f in table.items():
        curves |= {name: f.plain, f"{name}, denoised": f.denoised}
    counts = sorted({point[0] for curve in curves.values() for point in curve.points})
    lines = head("samples", *counts, "noise of the converged picture, taken out of relRMSE")
    for name, curve in curves.items():
        known = {samples: f"{error:.3f}, {flip:.3f}" for samples, _, error, flip in curve.points}
        noise = renderers[name.removesuffix(", denoised")]["truth_noise"]
        lines.append(row(name, *[known.get(n, "") for n in counts], f"{noise:.3f}"))
    return lines


def pictures(task):
    alike, renderers = task["alike"], task["renderers"]
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
