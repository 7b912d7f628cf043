//! The fields of a document that gives the labels of a segmentation their meaning.

use super::{DescribedField, DescribedTable, FieldKind, Text};

/// The meaning of a segmentation's labels.
pub(crate) static SEGMENTATION: DescribedTable = DescribedTable {
    doc: "The meaning of the labels of a segmentation, and the entry of the needle, for `stylet anatomy import`",
    fields: &[
        DescribedField::text("title", &Text::LINE, "Title of the new scene").or_text("Imported anatomy"),
        DescribedField::new("entry", FieldKind::Table(&ENTRY), "Where the needle enters").required(),
        DescribedField::new(
            "label",
            FieldKind::Tables { table: &LABEL, min: 1, max: 96 },
            "A label of the map; 0 is outside the body, and unnamed labels are unclassified tissue",
        )
        .required(),
    ],
};

static ENTRY: DescribedTable = DescribedTable {
    doc: "Entry of the needle, in the image's world coordinates (right, anterior, superior)",
    fields: &[
        DescribedField::place(
            "point_mm",
            10_000.0,
            "A point within 20 mm of the skin; the nearest point of the skin is used",
        )
        .required(),
        DescribedField::new(
            "up",
            FieldKind::Vector { unit: "", len: 3, min: -1.0, max: 1.0 },
            "Direction out of the body, which becomes +z: [0, -1, 0] is posterior; the skin's normal if left out",
        ),
    ],
};

static LABEL: DescribedTable = DescribedTable {
    doc: "A label of the map",
    fields: &[
        DescribedField::new("number", FieldKind::Integer { min: 1, max: 65_535 }, "Value of its voxels; unique")
            .required(),
        DescribedField::text("name", &Text::NAME, "Name of the structure or layer, unique").required(),
        DescribedField::new(
            "kind",
            FieldKind::Choice(&["target", "vessel", "nerve", "bone", "organ", "skin", "layer"]),
            "Role of a structure in the exercise, or a layer: skin is the layer of that tissue",
        )
        .required(),
        DescribedField::new(
            "tissue",
            FieldKind::Choice(&["skin", "fat", "fascia", "muscle", "ligament"]),
            "Tissue of a layer, which determines its mechanical properties; required for a layer",
        ),
        DescribedField::number(
            "smoothing_voxels",
            "",
            0.0..=2.0,
            "Largest displacement of a vertex by smoothing, in voxels",
        )
        .or(0.5),
        DescribedField::number(
            "wall_stiffness_n_per_m",
            "N/m",
            1.0..=1e5,
            "Stiffness of its wall against the tip; none is felt if left out",
        ),
        DescribedField::number("wall_rupture_n", "N", 0.01..=100.0, "Force at which its wall gives way"),
    ],
};
