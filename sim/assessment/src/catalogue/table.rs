//! The rows of the catalogue, in the order in which they are shown.

use super::Direction::{Higher, Lower, Range};
use super::{Definition, Direction, Split};

const ALWAYS: &str = "every recording of at least two samples";
const TOUCHED: &str = "once the needle has touched the skin";
const INSIDE: &str = "once the tip has gone through the skin";
const MOVING: &str = "recordings of at least 0.1 s";
const RUPTURED: &str = "once the boundary has ruptured; the plain form is the largest over all ruptures";
const LEDGER: &str = "once the needle has touched the skin, where the recording holds an energy ledger";

const fn row(id: &'static str, unit: &'static str, direction: Direction) -> Definition {
    Definition {
        id,
        version: 1,
        unit,
        direction,
        label: "",
        definition: "",
        domain: TOUCHED,
        advice: "",
        plain: true,
        split: None,
    }
}

impl Definition {
    const fn says(self, label: &'static str, definition: &'static str, advice: &'static str) -> Self {
        Self { label, definition, advice, ..self }
    }

    const fn applies(self, domain: &'static str) -> Self {
        Self { domain, ..self }
    }

    const fn also_by(self, split: Split) -> Self {
        Self { split: Some(split), ..self }
    }

    const fn only_by(self, split: Split) -> Self {
        Self { plain: false, split: Some(split), ..self }
    }
}

/// Every metric of version 1.
pub const DEFINITIONS: &[Definition] = &[
    row("depth_error_mm", "mm", Range).says(
        "depth error",
        "Axial displacement from the skin entry at confirm, less the target depth; without a confirm, at the last moment of largest displacement.",
        "watch the depth",
    ),
    row("overshoot_mm", "mm", Lower).says(
        "overshoot",
        "Largest axial displacement from the skin entry, less the target depth, and at least 0.",
        "brace the hand and stop sooner",
    ),
    row("tip_error_mm", "mm", Lower).says(
        "distance of the tip to the target",
        "Distance in space between the tip and the target at confirm.",
        "check entry point, angle and depth",
    ),
    row("entry_error_mm", "mm", Lower).says(
        "distance of the entry to the planned one",
        "Distance between the planned entry and the last contact with the skin before confirm.",
        "place the tip on the mark before you push",
    ),
    row("angle_error_deg", "°", Lower).says(
        "angle error",
        "Angle between the needle's axis at that contact and the planned direction.",
        "line the needle up before you touch the skin",
    ),
    row("peak_force_n", "N", Lower).says(
        "peak force",
        "Largest axial force on the hand, contact with bone included, and the force just before each rupture.",
        "push more gently",
    ),
    row("peak_force_layer_n", "N", Lower).only_by(Split::Layer).applies("layers whose boundary the tip has tented").says(
        "peak force",
        "Largest axial force while the tip tents the layer's boundary or is in the layer.",
        "push more gently",
    ),
    row("rupture_force_n", "N", Lower).also_by(Split::Boundary).applies(RUPTURED).says(
        "force at the pop",
        "Elastic force of the tip or the rim on the boundary just before it ruptured.",
        "advance more slowly up to the boundary",
    ),
    row("over_insertion_mm", "mm", Lower).also_by(Split::Boundary).applies(RUPTURED).says(
        "advance after the pop",
        "Furthest advance beyond the rupture in the second that follows it.",
        "brace the hand and expect the pop",
    ),
    row("stop_time_s", "s", Lower).also_by(Split::Boundary).applies(RUPTURED).says(
        "time to stop after the pop",
        "Time from a rupture to the first moment at which the axial speed is below 0.5 mm/s.",
        "stop as soon as you feel the pop",
    ),
    row("force_impulse_ns", "N·s", Lower).says(
        "force impulse",
        "Integral over time of the axial force on the hand.",
        "push no longer and no harder than you must",
    ),
    row("force_rate_peak_n_per_s", "N/s", Lower).says(
        "peak force rate",
        "Largest rate of rise of the low-passed axial force, the falls at ruptures and 0.05 s on either side taken out.",
        "build the force up smoothly",
    ),
    row("rupture_energy_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).says(
        "rupture energy",
        "Elastic energy dissipated by ruptures.",
        "open each boundary once and slowly",
    ),
    row("cutting_energy_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).says(
        "cutting energy",
        "Energy spent cutting new material.",
        "go no deeper and no more often than you must",
    ),
    row("friction_energy_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).says(
        "friction energy",
        "Energy spent on friction along the shaft.",
        "avoid moving back and forth",
    ),
    row("lateral_work_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).says(
        "lateral work",
        "Integral of the lateral force over the sideways displacement of the shaft.",
        "keep the needle on its line",
    ),
    row("lateral_peak_n", "N", Lower).says(
        "peak lateral force",
        "Largest magnitude of the lateral force on the hand.",
        "keep the needle on its line",
    ),
    row("sweep_area_mm2", "mm²", Lower).applies(INSIDE).says(
        "area swept sideways",
        "Area swept by the shaft inside tissue: two triangles between consecutive segments from the skin to the tip.",
        "withdraw before you change direction",
    ),
    row("skin_entries", "count", Lower).says(
        "skin punctures",
        "Number of times the tip went through intact skin.",
        "plan the entry and puncture once",
    ),
    row("redirections", "count", Lower).applies(INSIDE).says(
        "changes of direction",
        "Number of times the axis left the direction it last held by more than 5° while inserted; a direction is held below 5°/s.",
        "choose the direction before you puncture",
    ),
    row("structure_hits", "count", Lower).also_by(Split::Kind).says(
        "structures hit",
        "Number of times the needle met a structure that is not a target; by kind, of that kind.",
        "keep clear of the structures on the plan",
    ),
    row("structure_clearance_mm", "mm", Higher).only_by(Split::Structure).says(
        "clearance",
        "Least distance between the structure and the shaft inside the body, or the tip outside it; for a target, lower is better.",
        "keep to the planned line",
    ),
    row("time_total_s", "s", Lower).applies(ALWAYS).says(
        "total time",
        "Time from the first sample to the last.",
        "work without pauses",
    ),
    row("time_in_tissue_s", "s", Lower).applies(INSIDE).says(
        "time in tissue",
        "Time with the tip deeper than 0.",
        "work without pauses once inside",
    ),
    row("path_length_mm", "mm", Lower).applies(MOVING).says(
        "path length",
        "Length of the low-passed path of the tip.",
        "move directly to the entry and the target",
    ),
    row("path_in_tissue_mm", "mm", Lower).applies(INSIDE).says(
        "path length in tissue",
        "Length of the low-passed path of the tip while deeper than 0.",
        "move directly to the target",
    ),
    row("axis_travel_mm", "mm", Lower).applies(MOVING).says(
        "travel along the axis",
        "Sum of the magnitudes of the low-passed displacements of the tip along the needle's axis.",
        "avoid pumping in and out",
    ),
    row("path_deviation_sd_mm", "mm", Lower).applies(INSIDE).says(
        "spread about the planned line",
        "Standard deviation of the tip's distance to the planned line while deeper than 0.",
        "keep the needle on the planned line",
    ),
    row("smoothness_ldlj", "1", Higher).applies("once the tip has moved for 0.1 s inside tissue").says(
        "smoothness",
        "Log dimensionless jerk of the tip while deeper than 0: −ln(T³/v² ∫‖jerk‖² dt), T the time in tissue and v the peak speed there.",
        "move steadily",
    ),
    row("idle_fraction", "1", Lower).applies(INSIDE).says(
        "share of idle time",
        "Share of the time in tissue with the tip slower than 0.2 mm/s.",
        "know the next step before you start",
    ),
    row("translational_actions", "count", Lower).applies(MOVING).says(
        "translational actions",
        "Number of runs longer than 0.2 s with the tip faster than 5 mm/s.",
        "move slowly and directly",
    ),
    row("rotational_actions", "count", Lower).applies(MOVING).says(
        "rotational actions",
        "Number of runs longer than 0.2 s with the needle turning faster than 50°/s.",
        "turn the needle slowly and seldom",
    ),
];
