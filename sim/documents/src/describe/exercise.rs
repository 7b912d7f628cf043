//! The fields of an exercise.

use super::{DescribedField, DescribedTable, FieldKind, Presence, Text};
use crate::picture::MOST_PICTURES;

/// An exercise.
pub(crate) static EXERCISE: DescribedTable = DescribedTable {
    doc: "An exercise: the task in a scene and how it is scored. Schools set the thresholds",
    fields: &[
        DescribedField::text("id", &Text::ID, "Identifier; with the SHA-256 of the bytes it names a revision")
            .required(),
        DescribedField::said_line("title", "Title shown to people").required(),
        DescribedField::languages(),
        DescribedField::said_prose("briefing", "Shown before the attempt").or_text(""),
        DescribedField::text("scene", &Text::LINE, "Scene document, relative to this one").required(),
        DescribedField::new("difficulty", FieldKind::Integer { min: 1, max: 5 }, "Difficulty").or(1.0),
        DescribedField::number("pass_mark", "", 0.0..=100.0, "Score needed to pass").or(70.0),
        DescribedField::number("time_limit_s", "s", 1.0..=3600.0, "Time limit").or(300.0),
        DescribedField::new(
            "feedback",
            FieldKind::Choice(&["force", "picture", "overlay", "fluoroscopy", "both"]),
            "Feedback for the trainee: force in the hand, the inside of the body in the picture, depth and force as \
             numbers and plots, force and X-rays, or all of these",
        )
        .or_text("both"),
        DescribedField::new("entry", FieldKind::Table(&ENTRY), "Planned entry").with(Presence::Empty),
        DescribedField::new("target", FieldKind::Table(&TARGET), "Where to stop").required(),
        DescribedField::new(
            "fluoroscopy",
            FieldKind::Table(&FLUOROSCOPY),
            "A C-arm at the patient, whose body the scene makes by `[anatomy]`",
        ),
        DescribedField::new(
            "required",
            FieldKind::Table(&REQUIRED),
            "What must be done to earn points. With this table, a rubric line for a layer that was not reached, or a \
             boundary that was not opened, earns no points; without it, full points",
        ),
        DescribedField::new("rubric", FieldKind::Tables { table: &RUBRIC, min: 1, max: 40 }, "The lines of the score")
            .required(),
        DescribedField::new(
            "hard_fail",
            FieldKind::Tables { table: &HARD_FAIL, min: 0, max: 40 },
            "Conditions that fail an attempt at any score",
        )
        .with(Presence::Empty),
        DescribedField::new(
            "coaching",
            FieldKind::Tables { table: &COACHING, min: 0, max: 40 },
            "Messages during the attempt",
        )
        .with(Presence::Empty),
        DescribedField::new(
            "picture",
            FieldKind::Tables { table: &PICTURE, min: 0, max: MOST_PICTURES },
            "Pictures of the briefing. They do not affect scores, and are not part of a recording",
        )
        .with(Presence::Empty),
    ],
};

static ENTRY: DescribedTable = DescribedTable {
    doc: "Planned entry and direction",
    fields: &[
        DescribedField::new(
            "point_mm",
            FieldKind::Vector { unit: "mm", len: 2, min: -200.0, max: 200.0 },
            "Entry on the skin, x and y; the origin if left out",
        ),
        DescribedField::number("angle_deg", "°", 0.0..=60.0, "Angle between the needle and the surface normal").or(0.0),
        DescribedField::number(
            "azimuth_deg",
            "°",
            -360.0..=360.0,
            "Heading of the tip seen from outside, from +x to +y",
        )
        .or(0.0),
    ],
};

static TARGET: DescribedTable = DescribedTable {
    doc: "Where to stop",
    fields: &[
        DescribedField::number("depth_mm", "mm", 0.1..=500.0, "Depth along the needle's axis from the skin").required()
    ],
};

static FLUOROSCOPY: DescribedTable = DescribedTable {
    doc: "A C-arm and its position at the start, around the target",
    fields: &[
        DescribedField::number(
            "orbital_deg",
            "°",
            -45.0..=90.0,
            "Orbital angle; positive turns the detector to the patient's right",
        )
        .or(0.0),
        DescribedField::number("tilt_deg", "°", -45.0..=45.0, "Tilt; positive turns the detector to the head").or(0.0),
        DescribedField::number("field_mm", "mm", 60.0..=300.0, "Edge of the collimated field at the detector")
            .or(300.0),
        DescribedField::number("pulses_per_s", "1/s", 1.0..=15.0, "Pulses per second while the pedal is pressed")
            .or(7.5),
    ],
};

static REQUIRED: DescribedTable = DescribedTable {
    doc: "An attempt that does not meet all of these earns no points and fails",
    fields: &[
        DescribedField::text("reached", &Text::NAME, "Layer whose upper boundary the tip must have opened"),
        DescribedField::number(
            "within_mm",
            "mm",
            0.1..=500.0,
            "Largest difference between the depth at confirmation and the target depth",
        ),
        DescribedField::new(
            "confirmed",
            FieldKind::Flag,
            "The position must have been confirmed with the tip in the body",
        )
        .with(Presence::Flag(false)),
        DescribedField::new("withdrawn", FieldKind::Flag, "The needle must have left the body by the end")
            .with(Presence::Flag(false)),
    ],
};

/// Version of the metric that a line refers to. Documents written before metrics had versions have
/// no such key.
const VERSION: DescribedField = DescribedField::new(
    "version",
    FieldKind::Integer { min: 1, max: 9 },
    "Version of the metric's definition; a document without it uses the first",
)
.or(1.0);

static RUBRIC: DescribedTable = DescribedTable {
    doc: "100 % at full, 0 % at zero, linear between, clamped; the score is the weighted mean",
    fields: &[
        DescribedField::text("metric", &Text::LINE, "Metric id; its unit is that of full and zero").required(),
        VERSION,
        DescribedField::number(
            "full",
            "",
            -1e9..=1e9,
            "Value for full points; for a range metric, the distance from 0",
        )
        .required(),
        DescribedField::number("zero", "", -1e9..=1e9, "Value for no points; must differ from full").required(),
        DescribedField::number("weight", "", 1e-3..=1e3, "Relative weight").or(1.0),
    ],
};

static HARD_FAIL: DescribedTable = DescribedTable {
    doc: "A limit that fails the attempt at any score",
    fields: &[
        DescribedField::text("metric", &Text::LINE, "Metric id; its unit is that of above").required(),
        VERSION,
        DescribedField::number("above", "", -1e9..=1e9, "The attempt fails when the value is above this").required(),
        DescribedField::said_line("why", "Shown to the trainee").required(),
    ],
};

static COACHING: DescribedTable = DescribedTable {
    doc: "Shown when a live quantity rises above a limit; rearmed when it falls",
    fields: &[
        DescribedField::new(
            "quantity",
            FieldKind::Choice(&[
                "depth_mm",
                "force_n",
                "speed_mm_per_s",
                "angle_error_deg",
                "fluoroscopy_time_s",
                "kerma_mgy",
            ]),
            "Live quantity; its unit is that of above and rearm_below",
        )
        .required(),
        DescribedField::number("above", "", 0.0..=1e6, "Shown when the quantity rises above this").required(),
        DescribedField::number("rearm_below", "", 0.0..=1e6, "Rearmed below this; `above` if left out"),
        DescribedField::said_line("message", "The message").required(),
    ],
};

static PICTURE: DescribedTable = DescribedTable {
    doc: "A picture of the briefing: a PNG or JPEG file in the folder of the document, at most 1 MiB and 4 million pixels, without Exif or XMP",
    fields: &[
        DescribedField::text("file", &Text::PICTURE, "Its name, which ends in .png or .jpg").required(),
        DescribedField::said_line("alt", "Description for people who cannot see it").required(),
        DescribedField::said_line("caption", "Caption below it"),
    ],
};
