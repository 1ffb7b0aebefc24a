"""What is drawn: one towel of smooth strands in direct light, and one of fluffy loops in light that goes on."""

from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Task:
    """A towel, and what the peers draw in place of its loops. Lengths in mm."""

    name: str
    # What it shows, for the report.
    about: str
    # Below the repository's root.
    preset: str
    # The size that the preset has, in cells, and its camera.
    warps: int
    wefts: int
    distance: float
    target: tuple
    # The length of all loops after the edit; the preset has another.
    edited_length: float
    # Scatterings of a path.
    bounces: int
    # Curves of a loop, and their radius; none: one as thick as the yarn.
    fibres: int = 1
    fibre_radius: float | None = None
    # The peers' albedo in ours: so that converged pictures are equally bright.
    albedo_scale: float = 1.0
    # Turns of the fibres around the yarn in a mm of it.
    fibre_turns: float = 0.0


TASKS = {
    task.name: task
    for task in (
        Task(
            name="smooth",
            about="240 x 280 loops of one smooth strand, direct light of a sun of 5 degrees and a constant sky",
            preset="presets/peer-towel.toml",
            warps=240,
            wefts=280,
            distance=310,
            target=(0, -34, 1),
            edited_length=2.3,
            bounces=1,
        ),
        Task(
            name="fluffy",
            about="120 x 140 loops of 16 fibres, a sun of 5 degrees and a constant sky, 8 bounces",
            preset="tests/benches/peers/fluffy.toml",
            warps=120,
            wefts=140,
            distance=155,
            target=(0, -17, 1),
            edited_length=2.9,
            bounces=8,
            fibres=16,
            fibre_radius=0.05,
            fibre_turns=0.1,
            albedo_scale=0.81,
        ),
    )
}
