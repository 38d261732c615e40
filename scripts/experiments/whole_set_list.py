"""What `evaluate.py all` runs: each experiment with its quick choice, its recordings, its cores."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

DATA = Path("../shared/data")
LEFT_OUT = ("faults", "soak", "all")  # real time; and the set itself


@dataclass(frozen=True, kw_only=True)
class Item:
    """One run of the set.

    Attributes:
        experiment: As `evaluate.py` names it.
        kind: "spread" takes `--jobs`; "one" uses one core; "alone" has nothing beside it.
        quick: Words of the quick choice.
        full: Words of the whole experiment.
        recordings: Files or folders of the recordings, which are given where {} stands.
        part: Added to the name, where an experiment is run twice.
    """

    experiment: str
    kind: str = "one"
    quick: str = ""
    full: str = ""
    recordings: tuple[str, ...] = ()
    part: str = ""

    @property
    def name(self) -> str:
        """Return the name in the report."""
        return f"{self.experiment}-{self.part}" if self.part else self.experiment

    def missing(self, data: Path) -> Path | None:
        """Return the first recording that is not in this folder."""
        paths = (data / name for name in self.recordings)
        return next((path for path in paths if not path.exists()), None)

    def words(self, data: Path, *, is_full: bool) -> list[str]:
        """Return the command line after `evaluate.py`."""
        given = iter(self.recordings)
        chosen = (self.full if is_full else self.quick).split()
        filled = [str(data / next(given)) if word == "{}" else word for word in chosen]
        return [self.experiment, *filled]


HOTEL = "pedestrians/seq_hotel/obsmat.txt.gz"
ZARA = "pedestrians/zara01/obsmat.txt.gz"
INTEL = "intel-lab/intel_keyframes_rawodom_corrected.log.gz"
TSUKUBA = tuple(f"stereo/tsukuba/{name}" for name in ("im3.png", "im4.png", "disp3.pgm"))
CONES = tuple(f"stereo/cones/{name}" for name in ("im2.png", "im6.png", "disp2.png"))

SET = (
    Item(experiment="long-run", quick="--laps 8"),
    Item(experiment="sensor-models", quick="--scans 160 --runs 16"),
    Item(experiment="free-space", quick="--scenes 20"),
    Item(experiment="floor-images", quick="--images {}", full="--images {}",
         recordings=("msl-fisheye",)),
    Item(experiment="floor-localization", quick="--poses 10"),
    Item(experiment="landmark-localization", quick="--headings 2"),
    Item(experiment="stereo-localization", quick="--quick"),
    Item(experiment="stereo-matching", quick="--views 10"),
    Item(experiment="stereo-matching", part="tsukuba", recordings=TSUKUBA,
         quick="--pair {} {} --gt {} --scale 16 --disparities 16",
         full="--pair {} {} --gt {} --scale 16 --disparities 16"),
    Item(experiment="stereo-matching", part="cones", recordings=CONES,
         quick="--pair {} {} --gt {} --scale 4", full="--pair {} {} --gt {} --scale 4"),
    Item(experiment="mrclam", quick="--data {}", full="--data {} --noise",
         recordings=("mrclam6",)),
    Item(experiment="laser-drives", kind="spread", quick="--runs 2"),
    Item(experiment="loop-drives", kind="spread", quick="--runs 1"),
    Item(experiment="slam", kind="spread", quick="--quick"),
    Item(experiment="relocalization", kind="spread", quick="--quick"),
    Item(experiment="free-space-odometry", kind="spread", quick="--runs 1"),
    Item(experiment="velocity-avoidance", kind="spread", quick="--quick"),
    Item(experiment="sjmc-thesis", kind="spread", quick="--quick"),
    Item(experiment="glass-map", kind="spread", quick="--floors 2"),
    Item(experiment="glass-drives", kind="spread", quick="--quick"),
    Item(experiment="team-localization", kind="spread", quick="--layouts 10"),
    Item(experiment="people-tracking", kind="spread", quick="--quick"),
    Item(experiment="crowd", kind="spread", quick="--quick"),
    Item(experiment="crowd", part="recorded", kind="spread", recordings=(HOTEL, ZARA),
         quick="--quick --scenes --people {} {}", full="--scenes --people {} {}"),
    Item(experiment="determinism", kind="alone", recordings=(INTEL,),
         quick="--recording {} --runs 3 --loaded 1", full="--recording {}"),
    Item(experiment="live-team", kind="alone"),
    Item(experiment="live-mapping", kind="alone", recordings=("rosbag2/olin_mac_floor1",
         "rosbag2/pioneer_trace0"), quick="--bag {}", full="--bag {} {}"),
)  # fmt: skip
