//! The rows of the catalogue, in display order.

use super::Direction::{Higher, Lower, Range};
use super::{Definition, Direction, Split};

const ALWAYS: &str = "every recording of at least two samples";
const TOUCHED: &str = "once the needle has touched the skin";
const INSIDE: &str = "once the tip has punctured the skin";
const MOVING: &str = "recordings of at least 0.1 s";
const RUPTURED: &str = "once the boundary has ruptured; the plain form is the largest over all ruptures";
const LEDGER: &str = "once the needle has touched the skin, if the recording contains an energy ledger";

const fn metric_definition(id: &'static str, unit: &'static str, direction: Direction) -> Definition {
    Definition {
        id,
        version: 1,
        unit,
        direction,
        label: "",
        definition: "",
        domain: TOUCHED,
        advice: "",
        source: "",
        unoffered: "",
        plain: true,
        split: None,
    }
}

impl Definition {
    const fn described(self, label: &'static str, definition: &'static str, advice: &'static str) -> Self {
        Self { label, definition, advice, ..self }
    }

    /// Derives version 2 from the row above, with another definition.
    const fn anew(self, definition: &'static str, source: &'static str) -> Self {
        Self { version: 2, definition, source, ..self }
    }

    const fn after(self, source: &'static str) -> Self {
        Self { source, ..self }
    }

    const fn unoffered(self, why: &'static str) -> Self {
        Self { unoffered: why, ..self }
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

const BEHIND_4_HZ: &str =
    "physiological tremor is at 8 to 12 Hz (Elble and Koller 1990, Tremor); a 4 Hz low-pass leaves at most 6 % of it";
const PATH_OF_TREMOR: &str = "most of it comes from tremor; version 2 filters at 4 Hz";
const FOLLOWS_THE_TIME: &str = "it mostly follows the duration, which time_total_s measures";
const STOPS_UNFELT: &str = "after a rupture too weak to be felt, experts and novices alike stop only at the next one; \
     over_insertion_mm separates them";
const NEVER_SEEN: &str =
    "no virtual hand does this, neither expert nor novice, so there is no evidence that it distinguishes them";
const ARM: &str = "exercises with a C-arm";
const ARM_UNUSED: &str =
    "no virtual hand uses the C-arm, neither expert nor novice, so there is no evidence that it distinguishes them";
const PERKTUTOR: &str = "PerkTutor, PythonMetrics: threshold and debounce (Ungi and others 2012, Perk Tutor: an open-source training platform for ultrasound-guided needle insertions)";

const STOP_TIME: Definition =
    metric_definition("stop_time_s", "s", Lower).also_by(Split::Boundary).applies(RUPTURED).described(
        "time to stop after the pop",
        "Time from a rupture to the first moment at which the axial speed is below 0.5 mm/s.",
        "stop as soon as you feel the pop",
    );

const STRUCTURE_HITS: Definition = metric_definition("structure_hits", "count", Lower).also_by(Split::Kind).described(
    "structures hit",
    "Number of times the needle touched a structure that is not a target; with a kind, only those of that kind.",
    "keep clear of the structures on the plan",
);

const PATH_LENGTH: Definition = metric_definition("path_length_mm", "mm", Lower).applies(MOVING).described(
    "path length",
    "Length of the low-pass filtered path of the tip.",
    "move directly to the entry and the target",
);

const PATH_IN_TISSUE: Definition = metric_definition("path_in_tissue_mm", "mm", Lower).applies(INSIDE).described(
    "path length in tissue",
    "Length of the low-pass filtered path of the tip while deeper than 0.",
    "move directly to the target",
);

const AXIS_TRAVEL: Definition = metric_definition("axis_travel_mm", "mm", Lower).applies(MOVING).described(
    "travel along the axis",
    "Sum of the magnitudes of the low-pass filtered displacements of the tip along the needle's axis.",
    "avoid pumping in and out",
);

const IDLE: Definition = metric_definition("idle_fraction", "1", Lower).applies(INSIDE).described(
    "share of idle time",
    "Share of the time in tissue with the tip slower than 0.2 mm/s.",
    "know the next step before you start",
);

const TRANSLATIONAL: Definition = metric_definition("translational_actions", "count", Lower).applies(MOVING).described(
    "translational actions",
    "Number of periods longer than 0.2 s with the tip faster than 5 mm/s.",
    "move slowly and directly",
);

const ROTATIONAL: Definition = metric_definition("rotational_actions", "count", Lower).applies(MOVING).described(
    "rotational actions",
    "Number of periods longer than 0.2 s with the needle turning faster than 50°/s.",
    "turn the needle slowly and rarely",
);

/// Every version of every metric.
pub const DEFINITIONS: &[Definition] = &[
    metric_definition("depth_error_mm", "mm", Range).described(
        "depth error",
        "Axial displacement from the skin entry at confirmation, minus the target depth; without a confirmation, at \
         the last moment of largest displacement.",
        "watch the depth",
    ),
    metric_definition("overshoot_mm", "mm", Lower).described(
        "overshoot",
        "Largest axial displacement from the skin entry, minus the target depth; at least 0.",
        "brace the hand and stop sooner",
    ),
    metric_definition("tip_error_mm", "mm", Lower).described(
        "distance of the tip from the target",
        "Three-dimensional distance between the tip and the target at confirmation.",
        "check entry point, angle and depth",
    ),
    metric_definition("entry_error_mm", "mm", Lower).described(
        "distance of the entry from the planned one",
        "Distance between the planned entry and the last contact with the skin before the confirmation.",
        "place the tip on the mark before you push",
    ),
    metric_definition("angle_error_deg", "°", Lower).described(
        "angle error",
        "Angle between the needle's axis at that contact and the planned direction.",
        "line the needle up before you touch the skin",
    ),
    metric_definition("peak_force_n", "N", Lower).described(
        "peak force",
        "Largest axial force on the hand, including contact with bone and the force just before each rupture.",
        "push more gently",
    ),
    metric_definition("peak_force_layer_n", "N", Lower).only_by(Split::Layer).applies("layers whose boundary the tip has tented").described(
        "peak force",
        "Largest axial force while the tip tents the layer's boundary or is in the layer.",
        "push more gently",
    ),
    metric_definition("rupture_force_n", "N", Lower).also_by(Split::Boundary).applies(RUPTURED).described(
        "force at the pop",
        "Elastic force of the tip or the rim on the boundary just before it ruptured.",
        "advance more slowly up to the boundary",
    ),
    metric_definition("over_insertion_mm", "mm", Lower).also_by(Split::Boundary).applies(RUPTURED).described(
        "advance after the pop",
        "Furthest advance beyond the rupture in the second that follows it.",
        "brace the hand and expect the pop",
    ),
    STOP_TIME.unoffered("with tremor, the first slow moment comes earlier than any reaction; version 2 requires a \
         lasting stop"),
    STOP_TIME.anew(
        "Time from a rupture to the first moment after which the advance, low-pass filtered at 4 Hz, stays within 0.1 \
         mm for 0.2 s.",
        "the band is as fast as the limit of version 1, 0.5 mm/s; its 0.2 s are PerkTutor's for an action",
    )
    .unoffered(STOPS_UNFELT),
    metric_definition("force_impulse_ns", "N·s", Lower).described(
        "force impulse",
        "Integral over time of the axial force on the hand.",
        "push no longer and no harder than necessary",
    )
    .unoffered(FOLLOWS_THE_TIME),
    metric_definition("force_rate_peak_n_per_s", "N/s", Lower).described(
        "peak force rate",
        "Largest rate of rise of the low-pass filtered axial force, excluding the drops at ruptures and 0.05 s before \
         and after each.",
        "build the force up smoothly",
    ),
    metric_definition("rupture_energy_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).described(
        "rupture energy",
        "Elastic energy dissipated by ruptures.",
        "open each boundary once and slowly",
    ),
    metric_definition("cutting_energy_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).described(
        "cutting energy",
        "Energy spent cutting new material.",
        "insert no deeper and no more often than necessary",
    ),
    metric_definition("friction_energy_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).described(
        "friction energy",
        "Energy spent on friction along the shaft.",
        "avoid moving back and forth",
    ),
    metric_definition("lateral_work_mj", "mJ", Lower).also_by(Split::Layer).applies(LEDGER).described(
        "lateral work",
        "Integral of the lateral force over the sideways displacement of the shaft.",
        "keep the needle on its line",
    ),
    metric_definition("lateral_peak_n", "N", Lower).described(
        "peak lateral force",
        "Largest magnitude of the lateral force on the hand.",
        "keep the needle on its line",
    ),
    metric_definition("max_lateral_force_n", "N", Lower)
        .only_by(Split::Layer)
        .applies("layers whose boundary the tip has tented")
        .described(
            "peak lateral force",
            "Largest magnitude of the lateral force on the hand while the tip tents the layer's boundary or is in the layer.",
            "keep the needle on its line",
        ),
    metric_definition("sweep_area_mm2", "mm²", Lower).applies(INSIDE).described(
        "area swept sideways",
        "Area swept by the shaft inside tissue: two triangles between consecutive segments from the skin to the tip.",
        "withdraw before you change direction",
    ),
    metric_definition("skin_entries", "count", Lower).described(
        "skin punctures",
        "Number of times the tip punctured intact skin.",
        "plan the entry and puncture once",
    ),
    metric_definition("redirections", "count", Lower).applies(INSIDE).described(
        "changes of direction",
        "Number of times the axis deviated by more than 5° from the last held direction while inserted; a direction \
         counts as held below 5°/s.",
        "choose the direction before you puncture",
    ),
    STRUCTURE_HITS.unoffered("with tremor, a needle on a surface touches it again and again; version 2 counts contacts"),
    STRUCTURE_HITS.anew(
        "Number of contacts of the needle with structures that are not targets; with a kind, only those of that kind. \
         A contact ends once the needle is clear by 0.5 mm or has been clear for 0.3 s.",
        "our choice: three periods of a tremor of 8 to 12 Hz, and more than its width",
    ),
    metric_definition("structure_clearance_mm", "mm", Higher).only_by(Split::Structure).described(
        "clearance",
        "Smallest distance between the structure and the shaft inside the body, or the tip outside it; for a target, \
         lower is better.",
        "keep to the planned line",
    ),
    metric_definition("time_total_s", "s", Lower).applies(ALWAYS).described(
        "total time",
        "Time from the first sample to the last.",
        "work without pauses",
    ),
    metric_definition("time_in_tissue_s", "s", Lower).applies(INSIDE).described(
        "time in tissue",
        "Time with the tip deeper than 0.",
        "work without pauses once inside",
    )
    .unoffered(FOLLOWS_THE_TIME),
    PATH_LENGTH.unoffered(PATH_OF_TREMOR),
    PATH_LENGTH.anew(
        "Length of the path of the tip, low-pass filtered at 4 Hz.",
        BEHIND_4_HZ,
    ),
    PATH_IN_TISSUE.unoffered(PATH_OF_TREMOR),
    PATH_IN_TISSUE.anew(
        "Length of the path of the tip, low-pass filtered at 4 Hz, while deeper than 0.",
        BEHIND_4_HZ,
    ),
    AXIS_TRAVEL.unoffered(PATH_OF_TREMOR),
    AXIS_TRAVEL.anew(
        "Sum of the magnitudes of the displacements of the tip along the needle's axis, low-pass filtered at 4 Hz.",
        BEHIND_4_HZ,
    ),
    metric_definition("path_deviation_sd_mm", "mm", Lower).applies(INSIDE).described(
        "spread about the planned line",
        "Standard deviation of the tip's distance to the planned line while deeper than 0.",
        "keep the needle on the planned line",
    ),
    metric_definition("smoothness_ldlj", "1", Higher).applies("once the tip has moved for 0.1 s inside tissue").described(
        "smoothness",
        "Log dimensionless jerk of the tip while deeper than 0: −ln(T³/v² ∫‖jerk‖² dt), T the time in tissue and v the peak speed there.",
        "move steadily",
    ).after("Balasubramanian and others 2015, On the analysis of movement smoothness")
    .unoffered("jerk comes mostly from tremor and grows with duration; use smoothness_sparc"),
    metric_definition("smoothness_sparc", "1", Higher).applies("once the tip has moved for 0.1 s inside tissue").described(
        "smoothness of the speed",
        "Spectral arc length of the speed of the tip, low-pass filtered at 4 Hz and sampled at 50 Hz, from its first \
         to its last moment deeper than 0: zero-padded to at least 16 times the length, up to 10 Hz, amplitude \
         threshold 0.05 of the largest.",
        "move steadily",
    )
    .after("Balasubramanian and others 2015, On the analysis of movement smoothness: SPARC with the authors' own settings"),
    IDLE.unoffered("a hand with tremor is never slower than 0.2 mm/s; version 2 filters at 4 Hz"),
    IDLE.anew(
        "Share of the time in tissue with the tip, low-pass filtered at 4 Hz, slower than 0.5 mm/s.",
        "D'Angelo and others 2015, Idle time: an underdeveloped performance metric for assessing surgical skill; the limit is ours",
    ),
    TRANSLATIONAL.unoffered("tremor alone reaches 5 mm/s"),
    TRANSLATIONAL.anew(
        "Number of times the tip, low-pass filtered at 4 Hz, began to move faster than 50 mm/s; changes of at most 0.2 \
         s do not count.",
        PERKTUTOR,
    )
    .unoffered(NEVER_SEEN),
    ROTATIONAL.unoffered("a movement interrupted by tremor counts twice"),
    ROTATIONAL.anew(
        "Number of times the needle, low-pass filtered at 4 Hz, began to turn faster than 50°/s; changes of at most \
         0.2 s do not count.",
        PERKTUTOR,
    )
    .unoffered(NEVER_SEEN),
    metric_definition("reached", "1", Higher).only_by(Split::Layer).described(
        "reached",
        "1 if the tip opened the layer's upper boundary, otherwise 0.",
        "advance until you feel the layer open",
    ),
    metric_definition("confirmed", "1", Higher).described(
        "position confirmed",
        "1 if the position was confirmed with the tip in the body, otherwise 0.",
        "confirm the position where you believe the target is, before you withdraw",
    ),
    metric_definition("withdrawn", "1", Higher).applies(INSIDE).described(
        "needle withdrawn",
        "1 if the needle was out of the body at the end, otherwise 0.",
        "withdraw the needle before you end the attempt",
    ),
    metric_definition("fluoroscopy_time_s", "s", Lower).applies(ARM).described(
        "fluoroscopy time",
        "Number of pulses by the pedal, divided by the pulses per second; single shots do not count.",
        "press the pedal only while you look, and not while nothing moves",
    )
    .unoffered(ARM_UNUSED),
    metric_definition("fluoroscopy_shots", "count", Lower).applies(ARM).described(
        "single shots",
        "Number of single shots, each with the tube load of ten pulses.",
        "look at the saved pictures before you take another one",
    )
    .unoffered(ARM_UNUSED),
    metric_definition("kerma_mgy", "mGy", Lower).applies(ARM).described(
        "air kerma",
        "Air kerma at the reference point, 150 mm from the isocentre towards the tube, over all pulses.",
        "take fewer pulses, and avoid long ways through the body",
    )
    .unoffered(ARM_UNUSED),
    metric_definition("kerma_area_gycm2", "Gy·cm²", Lower).applies(ARM).described(
        "kerma–area product",
        "Air kerma times the area of the field, over all pulses.",
        "close the collimator around what you need to see",
    )
    .unoffered(ARM_UNUSED),
    metric_definition("mean_field_cm2", "cm²", Lower).applies("exercises with a C-arm, once there was a pulse").described(
        "mean field",
        "Mean area of the collimated field at the detector over all pulses.",
        "close the collimator around what you need to see",
    )
    .unoffered(ARM_UNUSED),
    metric_definition("views_before_skin", "count", Higher).applies(ARM).described(
        "views before the skin",
        "Number of views, at least 10° apart, in which a pulse was taken before the first contact with the skin.",
        "look from two directions before you puncture",
    )
    .unoffered(ARM_UNUSED),
];
