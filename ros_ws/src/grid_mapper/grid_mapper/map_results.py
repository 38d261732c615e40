"""What a mapping run leaves behind: map, trajectory, picture, figures and a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from floornav_common.grid import OCCUPIED
from floornav_common.report_page import Figures, Picture, Section, Table
from floornav_common.reporting import write_atomic, write_html
from grid_mapper.glass_files import save_layers
from grid_mapper.layers import LayeredMapper
from grid_mapper.map_figures import (
    published_figures,
    relation_figures,
    relation_sections,
    screen_text,
    sonar_figures,
)
from grid_mapper.map_pictures import draw_map
from grid_mapper.map_run import MapRun, peak_memory_mb
from grid_mapper.recordings import Counts, Recording
from grid_mapper.relations import Relation, relation_errors
from grid_mapper.trajectory_metrics import (
    Trajectory,
    format_tum,
    path_length,
    trajectory_errors,
)

SUMMARY_KEYS = (
    "scans", "scans_used", "scans_untrusted", "scans_without_transform", "stamps_backwards",
    "stamps_repeated", "time_jumps", "malformed", "scans_unplaced",
    "ranges", "ranges_placed", "ranges_counted", "ranges_void", "ranges_unplaced",
    "infrared_frames", "glass_cells", "path_m", "duration_s",
    "relations_trans_m", "relations_trans_median_m", "relations_trans_std_m",
    "relations_rot_deg", "relations_rot_median_deg", "relations_rot_std_deg",
    "relations_used", "relations_total", "relations_worst", "relations_published", "ate_m",
    "rpe_m", "gt_poses", "beam_order",
    "nodes", "loops", "loops_refused", "ms_median", "ms_p99", "ms_max", "real_time_factor",
    "ms_per_range_median", "ms_per_range_p99", "peak_mb",
    "input", "input_format", "input_info", "problem",
)  # fmt: skip
NO_MAP = "no scan had enough points to begin a map"
NO_SONAR_MAP = "no sonar reading was an echo"
PICTURE_TEXT = "black: obstacle, white: free, gray: unknown, blue: the robot's path"
NUM_REASONS = 5


@dataclass
class MapInputs:
    """What a run is compared with, and what it was made from.

    Attributes:
        name: Name of the recording.
        title: Its folder and file name; "" for the name alone.
        relations: Known relations; None where not asked for.
        relations_tolerance_ns: How far their stamps may be from a pose.
        relations_offset_ns: Added to the trajectory's stamps.
        truth: Ground truth; None where not asked for.
        format: Format of the recording.
        info: How the recording was read.
    """

    name: str
    relations: list[Relation] | None = None
    relations_tolerance_ns: int = 2_000_000
    relations_offset_ns: int = 0
    truth: Trajectory | None = None
    format: str = ""
    info: tuple[str, ...] = ()
    title: str = ""


def write_results(
    out: Path,
    inputs: MapInputs,
    recording: Recording,
    run: MapRun,
    mapper: LayeredMapper,
    summary: dict[str, Any],
) -> str:
    """Write all files of a run and fill its summary.

    Returns:
        The figures as text for the screen.
    """
    layers = mapper.layers()
    occupancy = layers.occupancy
    summary.update(_figures(inputs, recording, run))
    summary.update(sonar_figures(run, mapper, int((layers.glass.cells == OCCUPIED).sum())))
    write_atomic(out / "trajectory.tum", format_tum(run.trajectory))
    has_map = occupancy.cells.size > 0
    if has_map:
        save_layers(out / "map", layers, keepout_margin=mapper.config.keepout_margin_m)
        what = "scans" if recording.has_laser else "sonar stamps"
        title = (
            f"{inputs.title or inputs.name}: {len(run.trajectory)} {what},"
            f" {summary['path_m']:.1f} m"
        )
        write_atomic(out / "map.png", draw_map(occupancy, run.trajectory, title, layers.glass))
    else:
        nothing = NO_MAP if recording.has_laser else NO_SONAR_MAP
        nothing = nothing if run.trajectory else none_used(recording.counts)
        summary["problem"] = summary["problem"] or nothing
    is_whole = summary["problem"] is None and not run.is_interrupted
    summary.update(ok=is_whole, partial=not is_whole)
    _compare(inputs, run, summary)
    write_html(out, f"Map of {inputs.name}", _sections(out, inputs, summary, run), inputs.format)
    return screen_text(summary)


def none_used(counts: Counts) -> str:
    """Return why not one scan of a recording was used."""
    return (
        f"not one of {counts.scans} scans could be used: {counts.without_transform} without"
        f" transform, {counts.malformed} not readable"
    )


def _compare(inputs: MapInputs, run: MapRun, summary: dict[str, Any]) -> None:
    """Fill in the errors against relations and ground truth, where asked for."""
    if inputs.relations is not None:
        errors = relation_errors(
            run.trajectory,
            inputs.relations,
            inputs.relations_tolerance_ns,
            inputs.relations_offset_ns,
        )
        summary.update(relation_figures(errors) | published_figures(inputs.relations))
        if len(errors.translations) == 0:
            _fail(summary, _no_relation_matched(inputs, run, errors.num_total))
    if inputs.truth is not None:
        _compare_truth(run, inputs.truth, summary)


def _fail(summary: dict[str, Any], problem: str) -> None:
    """Note a problem of what a run was compared with, behind those of the run itself."""
    known = summary["problem"]
    summary.update(ok=False, problem=problem if known is None else f"{known}; {problem}")


def _no_relation_matched(inputs: MapInputs, run: MapRun, num_total: int) -> str:
    text = f"relations: none of {num_total} matched"
    given = [ns for r in inputs.relations or () for ns in (r.stamp1_ns, r.stamp2_ns)]
    poses = [stamp_ns + inputs.relations_offset_ns for stamp_ns, _ in run.trajectory]
    if given and poses:
        text += (
            f": they are of {min(given) * 1e-9:.3f} to {max(given) * 1e-9:.3f} s, the trajectory of"
            f" {min(poses) * 1e-9:.3f} to {max(poses) * 1e-9:.3f} s"
        )
    return f"{text} (--relations-tol, --relations-offset)"


def _figures(inputs: MapInputs, recording: Recording, run: MapRun) -> dict[str, Any]:
    counts, stretches = recording.counts, run.stretches()
    return {
        "scans": counts.scans,
        "scans_used": len(run.trajectory) if recording.has_laser else 0,
        "scans_untrusted": len(run.untrusted),
        "scans_without_transform": counts.without_transform,
        "stamps_backwards": counts.stamps_backwards,
        "stamps_repeated": counts.stamps_repeated,
        "time_jumps": counts.jumps,
        "malformed": counts.malformed,
        "scans_unplaced": counts.unplaced,
        "ranges": run.num_ranges,
        "infrared_frames": sorted(counts.infrared),
        "path_m": sum(map(path_length, stretches), 0.0),
        "duration_s": _seconds(stretches),
        "ms_median": run.ms_quantile(0.5),
        "ms_p99": run.ms_quantile(0.99),
        "ms_max": run.ms_quantile(1.0),
        "real_time_factor": _real_time_factor(run),
        "peak_mb": round(peak_memory_mb(), 1),
        "input": inputs.name,
        "input_format": inputs.format,
        "input_info": list(inputs.info),
        "problem": recording.problem,
    }


def _seconds(stretches: Sequence[Trajectory]) -> float:
    """Return the time recorded, without what lies between one stretch and the next."""
    stamps = [[stamp_ns for stamp_ns, _ in stretch] for stretch in stretches]
    return sum(max(part) - min(part) for part in stamps) * 1e-9


def _real_time_factor(run: MapRun) -> float | None:
    """Return the time that was recorded, of scans that were timed, over what the mapper took."""
    timed = run.scan_ms or run.range_ms
    took = 1e-3 * (sum(run.scan_ms) + sum(run.range_ms) + run.finish_ms)
    first = max(len(run.trajectory) - len(run.scan_ms), 0) if run.scan_ms else 0
    return _seconds(run.stretches(first)) / took if timed and took > 0.0 else None


def _compare_truth(run: MapRun, truth: Trajectory, summary: dict[str, Any]) -> None:
    try:
        errors = trajectory_errors(run.trajectory, truth)
    except ValueError as error:
        summary["gt_poses"] = 0
        _fail(summary, f"ground truth: {error}")
        return
    summary.update(ate_m=errors.ate, rpe_m=errors.rpe, gt_poses=errors.num_compared)


def _sections(out: Path, inputs: MapInputs, summary: dict[str, Any], run: MapRun) -> list[Section]:
    figures = Figures([
        ("scans used", f"{summary['scans_used']} of {summary['scans']}"),
        ("not trusted", str(summary["scans_untrusted"])),
        ("way", f"{summary['path_m']:.1f} m"),
        ("ms per scan", "-" if summary["ms_median"] is None else f"{summary['ms_median']:.2f}"),
    ])  # fmt: skip
    picture = out / "map.png"
    pictures = [Picture(picture, PICTURE_TEXT)] if picture.exists() else []
    sections = [
        Section("Map", [figures, *pictures]),
        Section("How it was read", list(inputs.info)),
        Section("Figures", screen_text(summary).splitlines()),  # type: ignore[arg-type]
        *relation_sections(summary),
    ]
    if run.untrusted:
        rows: list[list[Any]] = [
            [f"{stamp_ns * 1e-9:.3f}", reason] for stamp_ns, reason in run.untrusted[:NUM_REASONS]
        ]
        sections.append(Section("First scans not trusted", [Table(["stamp, s", "why"], rows)]))
    if summary["problem"]:
        title = "Partial" if summary["partial"] else "Problem"
        sections.append(Section(title, [str(summary["problem"])]))
    return sections
