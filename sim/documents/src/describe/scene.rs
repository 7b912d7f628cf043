//! The fields of a scene.

use super::body::{ANATOMY, BODY};
use super::{DescribedField, DescribedTable, FieldKind, Presence, Text};
use crate::mesh::Axes;
use crate::model::{NUMBER_KEYS, NeedleFamily, NumberClass};
use crate::tip::TIP_WORDS;
use law::axial::MAX_BRANCHES;
use law::structures::StructureKind;

/// A scene.
pub(crate) static SCENE: DescribedTable = DescribedTable {
    doc: "A scene: layered tissue, a needle and structures to reach or avoid",
    fields: &[
        DescribedField::text("id", &Text::ID, "Identifier; with the SHA-256 of the bytes it names a revision")
            .required(),
        DescribedField::text("title", &Text::LINE, "Title shown to people").required(),
        DescribedField::text("description", &Text::PROSE, "Content and origin").or_text(""),
        DescribedField::new("law", FieldKind::Integer { min: 1, max: 5 }, "Version of the force law; 1 if left out")
            .or(1.0),
        DescribedField::new(
            "scaling",
            FieldKind::Integer { min: 1, max: 2 },
            "Version of how the needle scales the tissue's numbers, and of the tissues of [anatomy]; 1 if left out, as scenes were before there was another",
        )
        .or(1.0),
        DescribedField::new(
            "anatomy",
            FieldKind::Table(&ANATOMY),
            "A lower back from parameters, which provides the scene's layers and structures; instead of [[layer]] and \
             [skin]",
        ),
        LAYERS,
        DescribedField::new(
            "body",
            FieldKind::Table(&BODY),
            "The body from which the layers, structures and skin were made, for pictures of its inside; a recording has it in place of [anatomy]",
        ),
        DescribedField::new("needle", FieldKind::Table(&NEEDLE), "The needle").with(Presence::Empty),
        DescribedField::new(
            "rate",
            FieldKind::Table(&RATE),
            "Rate dependence of the thresholds: P(v) = P∞ + (P0 − P∞)/(1 + v/v0)",
        ),
        DescribedField::new(
            "skin",
            FieldKind::Table(&SKIN),
            "The skin: its curvature, and a mesh of it for the picture; flat, with a generated back around the needle, if left out",
        ),
        DescribedField::new(
            "structure",
            FieldKind::Tables { table: &STRUCTURE, min: 0, max: 64 },
            "Structures inside the body",
        )
        .with(Presence::Empty),
        DescribedField::new("tissue", FieldKind::Table(&TISSUE), "How the tissue deforms").with(Presence::Empty),
    ],
};

/// The layers; required without an anatomy.
pub(crate) const LAYERS: DescribedField = DescribedField::new(
    "layer",
    FieldKind::Tables { table: &LAYER, min: 1, max: 32 },
    "Layers from the surface down; needed where no [anatomy] gives them",
);

static LAYER: DescribedTable = DescribedTable {
    doc: "A layer, its numbers at 2.0 mm diameter, diamond tip, lubrication 1, toughness 1",
    fields: &[
        DescribedField::text("name", &Text::NAME, "Name, unique in the scene; metric ids end with it").required(),
        DescribedField::number("thickness_mm", "mm", 0.0..=500.0, "Thickness along the surface normal; 0 for a fascia")
            .required(),
        DescribedField::number("thickness_spread_mm", "mm", 0.0..=100.0, "Spread between patients: uniform, ±").or(0.0),
        DescribedField::number("stiffness_n_per_m", "N/m", 0.1..=1e7, "Stiffness k of the layer's upper boundary")
            .required(),
        DescribedField::number("damping_n_s_per_m2", "N·s/m²", 0.0..=1e5, "Damping b per inserted length").or(0.0),
        DescribedField::number(
            "tip_rupture_n",
            "N",
            0.0..=100.0,
            "Force at which the tip opens the boundary; needed where no fracture_energy_j_per_m2 gives it",
        ),
        DescribedField::number(
            "rim_rupture_n",
            "N",
            0.0..=100.0,
            "Force at which the cannula's rim opens it; a trocar needs it",
        ),
        DescribedField::number("friction_n_per_m", "N/m", 0.0..=1e5, "Coulomb friction cap c per inserted length")
            .or(0.0),
        DescribedField::number("cutting_n", "N", 0.0..=100.0, "Force f of cutting new material; with scaling = 2, that of the fracture energy if left out where a layer has one").or(0.0),
        DescribedField::number("density_kg_per_m3", "kg/m³", 100.0..=5000.0, "Density").or(1050.0),
        DescribedField::number("poisson_ratio", "", 0.0..=0.499, "Poisson ratio").or(0.45),
        DescribedField::number(
            "youngs_modulus_pa",
            "Pa",
            10.0..=1e10,
            "Young's modulus; from the stiffness if left out",
        ),
        DescribedField::number("toughness_factor", "", 0.01..=100.0, "Factor on the thresholds, friction and cutting")
            .or(1.0),
        DescribedField::number("recoil_time_s", "s", 1e-4..=10.0, "Recoil time after a rupture"),
        DescribedField::text("texture", &Text::NAME, "Texture of the picture: skin, fat, muscle, fascia, …; fluid runs out of an open hub")
            .or_text("tissue"),
        DescribedField::text("source", &Text::PROSE, "Where the numbers come from").or_text(""),
        DescribedField::new(
            "provenance",
            FieldKind::Tables { table: &PROVENANCE, min: 0, max: NUMBER_KEYS.len() },
            "Class and source of single numbers; a number without is a choice",
        )
        .with(Presence::Empty),
        DescribedField::number(
            "stiffening_n_per_m2",
            "N/m²",
            0.0..=1e8,
            "κ of a boundary that stiffens with its dent: F = k w + κ w². With law = 3",
        )
        .or(0.0),
        DescribedField::new(
            "relaxation",
            FieldKind::Tables { table: &RELAXATION, min: 0, max: MAX_BRANCHES },
            "Relaxation of the force of a held needle: branches parallel to the boundary's spring. With law = 3",
        )
        .with(Presence::Empty),
        DescribedField::new(
            "gives_way_at",
            FieldKind::Choice(&["force", "dent"]),
            "What opens a boundary that relaxes: spring and branches together at its threshold, or its spring alone, so that it is \
             dented alike at any speed and holds the more the faster the needle. With law = 3",
        )
        .or_text("force"),
        DescribedField::number(
            "static_friction_n_per_m",
            "N/m",
            0.0..=1e5,
            "Friction per inserted length until the shaft has slid by the needle's breakaway_mm; friction_n_per_m if left out. With law = 3",
        ),
        DescribedField::number(
            "fracture_energy_j_per_m2",
            "J/m²",
            1.0..=1e6,
            "Toughness that the tip's threshold follows from, with youngs_modulus_pa and the needle's diameter, instead of \
             tip_rupture_n. With law = 3",
        ),
        DescribedField::new(
            "fibres",
            FieldKind::Table(&FIBRES),
            "A sheet of connective tissue, whose other numbers are those under a bevel's edge across the fibres. With law = 3",
        ),
    ],
};

static PROVENANCE: DescribedTable = DescribedTable {
    doc: "Where one number of a layer comes from",
    fields: &[
        DescribedField::new("key", FieldKind::Choice(&NUMBER_KEYS), "The number").required(),
        DescribedField::new(
            "class",
            FieldKind::Choice(&NumberClass::WORDS),
            "Measured, derived from a measurement by the scaling that source states, or a choice for want of one",
        )
        .required(),
        DescribedField::text("source", &Text::PROSE, "The publication, the scaling or the reason").or_text(""),
        DescribedField::number(
            "low",
            "",
            0.0..=1e9,
            "Lower end of the published range, in the number's unit; a measured number needs it",
        ),
        DescribedField::number("high", "", 0.0..=1e9, "Upper end, likewise"),
    ],
};

static RELAXATION: DescribedTable = DescribedTable {
    doc: "A Maxwell branch parallel to a boundary's spring: it adds its share to the stiffness under a sudden dent, and relaxes during a hold",
    fields: &[
        DescribedField::number("share", "", 0.001..=100.0, "Stiffness as a share of the boundary's own").required(),
        DescribedField::number("time_s", "s", 0.001..=1e4, "Time in which its force falls to 1/e, 37 %").required(),
    ],
};

static FIBRES: DescribedTable = DescribedTable {
    doc: "Fibres of a sheet of connective tissue: an edge along them parts them, one across has to cut them",
    fields: &[
        DescribedField::number(
            "angle_deg",
            "°",
            0.0..=180.0,
            "Direction of the fibres in the plane of the skin, from the patient's x towards y",
        )
        .required(),
        DescribedField::number(
            "along_stiffness",
            "",
            0.01..=1.0,
            "Stiffness under an edge along the fibres, as a share of that across",
        )
        .or(1.0),
        DescribedField::number(
            "along_threshold",
            "",
            0.01..=1.0,
            "Thresholds under an edge along the fibres, likewise",
        )
        .or(1.0),
        DescribedField::number("pretension_n_per_m", "N/m", 0.0..=1e4, "Tension of the sheet, alike all round").or(0.0),
        DescribedField::number("held_radius_mm", "mm", 10.0..=500.0, "Distance at which the tense sheet is held")
            .or(20.0),
    ],
};

static NEEDLE: DescribedTable = DescribedTable {
    doc: "The needle",
    fields: &[
        DescribedField::new(
            "kind",
            FieldKind::Choice(&["trocar", "needle"]),
            "A trocar has a rim behind its tip, a needle has none",
        )
        .or_text("trocar"),
        DescribedField::new(
            "family",
            FieldKind::Choice(&NeedleFamily::WORDS),
            "Family, which decides with which published figures its forces may be compared; with none if left out",
        ),
        DescribedField::number("diameter_mm", "mm", 0.1..=15.0, "Diameter D").or(2.0),
        DescribedField::number("diameter_exponent", "", 0.8..=2.0, "Exponent p: thresholds and cutting go with D^p")
            .or(1.0),
        DescribedField::new(
            "tip",
            FieldKind::Choice(&TIP_WORDS),
            "Tip, a factor on the thresholds and, with scaling = 2, on cutting; the last three with scaling = 2",
        )
        .or_text("diamond"),
        DescribedField::new(
            "hub",
            FieldKind::Choice(&["stylet", "syringe"]),
            "The object on the hub until the position is confirmed: a picture, without force. The syringe is that of the loss of resistance",
        )
        .or_text("stylet"),
        DescribedField::number(
            "tip_to_rim_mm",
            "mm",
            0.0..=50.0,
            "Tip to rim: 2 for a trocar, 0 for a needle, if left out",
        ),
        DescribedField::number("length_mm", "mm", 10.0..=500.0, "Length of the shaft from tip to hub").or(150.0),
        DescribedField::number(
            "hub_stiffness_n_per_m",
            "N/m",
            100.0..=5000.0,
            "Stiffness of the skin under the hub, which stops the needle when the whole shaft is in; if left out, nothing stops it",
        ),
        DescribedField::number("lubrication", "", 0.1..=3.0, "Factor on friction: 0.5 lubricated, 1, 1.5 dry").or(1.0),
        DescribedField::new("flexible", FieldKind::Flag, "A bending shaft; a trocar is rigid")
            .with(Presence::Flag(false)),
        DescribedField::number(
            "youngs_modulus_pa",
            "Pa",
            1e9..=1e12,
            "Young's modulus of a shaft that bends; steel if left out",
        )
        .or(193e9),
        DescribedField::number(
            "inner_diameter_mm",
            "mm",
            0.0..=9.9,
            "Bore of a shaft that bends; 0.66 D if left out, 0 is solid",
        ),
        DescribedField::number(
            "presliding_stiffness_n_per_m",
            "N/m",
            1.0..=1e7,
            "Stiffness of friction and cutting before they slide",
        )
        .or(2000.0),
        DescribedField::number(
            "speed_window_ms",
            "ms",
            0.0..=50.0,
            "Window over which speed is measured; 0: the last two samples",
        )
        .or(0.0),
        DescribedField::number(
            "damping_time_ms",
            "ms",
            0.0..=50.0,
            "Time of the spring and dashpot that damp along the shaft; 0: a dashpot alone. With law = 5",
        )
        .or(0.0),
        DescribedField::number(
            "lateral_stiffness_n_per_m2",
            "N/m²",
            0.0..=1e7,
            "Sideways foundation per inserted length",
        )
        .or(10_000.0),
        DescribedField::number(
            "breakaway_mm",
            "mm",
            0.001..=50.0,
            "Slid length after which friction falls from static to kinetic; needed where a layer has a static one. With law = 3",
        ),
        DescribedField::number(
            "friction_rest_s",
            "s",
            0.01..=1000.0,
            "Time without sliding after which friction is static again; going back by breakaway_mm does the same",
        )
        .or(1.0),
    ],
};

static RATE: DescribedTable = DescribedTable {
    doc: "Rate dependence of the rupture thresholds, at 2.0 mm diameter and a diamond tip",
    fields: &[
        DescribedField::number("p_infinity_n", "N", 0.0..=100.0, "P∞, the threshold at high speed").required(),
        DescribedField::number("v0_mm_per_s", "mm/s", 1e-3..=1e6, "Speed at which half of the change has happened")
            .required(),
    ],
};

static STRUCTURE: DescribedTable = DescribedTable {
    doc: "A structure in the patient frame: origin on the planned skin, +z out of the body, so z is negative inside",
    fields: &[
        DescribedField::text("name", &Text::NAME, "Name, unique in the scene; metric ids end with it").required(),
        DescribedField::new("kind", FieldKind::Choice(&StructureKind::WORDS), "Its role in the exercise").required(),
        DescribedField::new("shape", FieldKind::Choice(&["sphere", "capsule", "box", "mesh"]), "Its shape").required(),
        DescribedField::place("position_mm", FARTHEST_MM, "Its centre; for a mesh, where the mesh's origin goes")
            .required(),
        DescribedField::number("radius_mm", "mm", 0.05..=500.0, "Radius of a sphere or capsule"),
        DescribedField::place("half_axis_mm", 500.0, "Half of a capsule's axis, from its centre to one end"),
        DescribedField::place("half_extents_mm", 500.0, "Half of each edge of a box, each above 0"),
        DescribedField::number(
            "wall_stiffness_n_per_m",
            "N/m",
            1.0..=1e5,
            "Stiffness of its wall against the tip; none is felt if left out",
        ),
        DescribedField::number("wall_rupture_n", "N", 0.01..=100.0, "Force at which its wall gives way"),
        DescribedField::number(
            "youngs_modulus_pa",
            "Pa",
            10.0..=1e9,
            "Young's modulus of a sphere or capsule that is softer or harder than the layers around it: the field \
             includes it, and with tissue.coupling = field the needle feels it",
        ),
        DescribedField::number("poisson_ratio", "", 0.0..=0.499, "Poisson ratio of it; 0.45 if left out"),
        DescribedField::text("file", &Text::LINE, "STL or OBJ file of a mesh, relative to the scene"),
        UNIT,
        AXES,
    ],
};

/// Largest distance between a scanner's coordinate origin and the body, in mm.
const FARTHEST_MM: f64 = 1500.0;

const UNIT: DescribedField = DescribedField::new(
    "unit",
    FieldKind::Choice(&["mm", "m"]),
    "Unit of the mesh's coordinates, which its file does not contain",
);

const AXES: DescribedField = DescribedField::new(
    "axes",
    FieldKind::Choice(Axes::WORDS),
    "Where the mesh's coordinates point: patient (x right, y superior, z posterior; if left out), RAS (right, anterior, \
     superior) or LPS (left, posterior, superior)",
);

static SKIN: DescribedTable = DescribedTable {
    doc: "The skin. Its curvature and that of its layers affect the forces; a mesh is only for the picture, within 5 \
         mm of z = 0 at the origin",
    fields: &[
        DescribedField::new(
            "shape",
            FieldKind::Choice(&["flat", "sphere", "cylinder"]),
            "How it bends away from z = 0, which it touches at the origin; the layers follow it",
        )
        .or_text("flat"),
        DescribedField::number(
            "radius_mm",
            "mm",
            20.0..=10_000.0,
            "Radius of a sphere or cylinder, at least 1.25 times the layers of the thickest patient",
        ),
        DescribedField::number(
            "along_deg",
            "°",
            -360.0..=360.0,
            "Direction of a cylinder's line, from the patient's x towards y: 90, along the spine, if left out",
        )
        .or(90.0),
        DescribedField::text(
            "file",
            &Text::LINE,
            "STL or OBJ file of a mesh, relative to the scene; it may be open. Needed where no shape is given",
        ),
        UNIT,
        AXES,
        DescribedField::place(
            "position_mm",
            FARTHEST_MM,
            "Where the mesh's origin goes in the patient frame; 0 if left out",
        ),
    ],
};

static TISSUE: DescribedTable = DescribedTable {
    doc: "How the tissue deforms",
    fields: &[
        DescribedField::new(
            "model",
            FieldKind::Choice(&["auto", "axisymmetric", "mass-spring", "volumetric", "none"]),
            "Model of the deformation; auto lets the planner choose",
        )
        .or_text("auto"),
        DescribedField::number("tolerance", "", 1e-6..=1.0, "Tolerated relative error of the displacement").or(0.05),
        DescribedField::new(
            "coupling",
            FieldKind::Choice(&["none", "field"]),
            "Whether the field sets the boundaries' stiffness",
        )
        .or_text("none"),
    ],
};
