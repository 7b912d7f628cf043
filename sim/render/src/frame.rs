//! The content of an image: plain data, in SI units and the patient frame (skin at z = 0 or
//! touching it, the body below, x to the right, y away).
//!
//! A [`Stage`] is constant for an attempt and is uploaded to the GPU once; a [`Frame`] is one
//! moment of it.

/// The constant data of an attempt.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stage {
    /// Layers from the skin down.
    pub layers: Vec<DrawnLayer>,
    /// The needle.
    pub needle: DrawnNeedle,
    /// Structures inside the body.
    pub structures: Vec<DrawnStructure>,
    /// Response of every boundary to the field's loads.
    pub field: FieldTable,
    /// Planned entry on the skin, in m.
    pub entry_m: [f32; 3],
    /// Planned direction into the body, unit length.
    pub axis: [f32; 3],
    /// Target position of the tip, in m; `None` if it is not shown.
    pub target_m: Option<[f32; 3]>,
    /// Curvature of skin and layers.
    pub bend: DrawnBend,
    /// A mesh of the skin, if the scene has one. A closed mesh is a whole patient.
    pub skin: Option<Mesh>,
}

impl Stage {
    /// Depth of the lowest boundary, in m.
    #[must_use]
    pub fn depth_m(&self) -> f32 {
        self.layers.iter().map(|layer| layer.top_m + layer.thickness_m).fold(0.0, f32::max)
    }

    /// The skin of the whole patient, if the view shows it.
    #[must_use]
    pub fn patient(&self, view: View) -> Option<&Mesh> {
        self.skin.as_ref().filter(|_| view == View::Patient)
    }
}

/// Curvature of skin and layers relative to z = 0, which the skin touches at the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DrawnBend {
    /// Not curved.
    #[default]
    Flat,
    /// Concentric with a sphere of this radius, in m.
    Sphere(f32),
    /// Concentric with a cylinder.
    Cylinder {
        /// Radius, in m.
        radius_m: f32,
        /// Direction of its axis in the plane z = 0, of unit length.
        line: [f32; 2],
    },
}

impl DrawnBend {
    /// Four numbers for the shaders: the radius in m, 0 if flat; the axis direction; 1 for a
    /// cylinder.
    #[must_use]
    pub fn packed(&self) -> [f32; 4] {
        match *self {
            Self::Flat => [0.0; 4],
            Self::Sphere(radius_m) => [radius_m, 0.0, 0.0, 0.0],
            Self::Cylinder { radius_m, line: [x, y] } => [radius_m, x, y, 1.0],
        }
    }

    /// Height of the skin at a position in plan view, in m. `concentric` in `scene.wgsl` does the
    /// same for every layer.
    #[must_use]
    pub fn height_m(&self, place: [f32; 2]) -> f32 {
        let [radius_m, x, y, is_cylinder] = self.packed();
        if radius_m <= 0.0 {
            return 0.0;
        }
        let along = is_cylinder * (place[0] * x + place[1] * y);
        let aside = place[0] * place[0] + place[1] * place[1] - along * along;
        let (aside_m, turned_m) = (aside.max(0.0).sqrt(), TURNED * radius_m);
        let round_m = aside_m.min(turned_m);
        let up_m = (radius_m * radius_m - round_m * round_m).sqrt();
        up_m - radius_m - (aside_m - round_m) * round_m / up_m
    }
}

/// Distance from the axis, in radii, beyond which a layer continues straight, at 49°: an image
/// shows the neighbourhood of an entry, not a whole sphere.
const TURNED: f32 = 0.75;

/// A layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnLayer {
    /// Name shown next to its band.
    pub name: String,
    /// Material.
    pub material: DrawnMaterial,
    /// Depth of its upper boundary, in m.
    pub top_m: f32,
    /// Thickness, in m; 0 for a membrane.
    pub thickness_m: f32,
}

/// Appearance of a layer or structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrawnMaterial {
    /// Skin.
    #[default]
    Skin,
    /// Fat.
    Fat,
    /// Muscle.
    Muscle,
    /// Fascia, ligament and other sheets.
    Fascia,
    /// Bone.
    Bone,
    /// Fluid.
    Fluid,
}

/// The needle: a cannula with a stylet inside whose tip protrudes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawnNeedle {
    /// Length from tip to hub, in m.
    pub length_m: f32,
    /// Outer diameter of the cannula, in m.
    pub diameter_m: f32,
    /// Distance from the stylet's tip to the cannula's rim, in m; 0 for a needle without cannula.
    pub tip_to_rim_m: f32,
    /// Shape of the tip.
    pub tip: Tip,
    /// The part on the hub while it is not open.
    pub hub: OnHub,
}

/// The part on a needle's hub.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnHub {
    /// The knob of the stylet that fills the needle.
    #[default]
    Stylet,
    /// A glass syringe, whose plunger moves at loss of resistance.
    Syringe,
}

/// Shape of a tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tip {
    /// Three facets, as on trocars.
    #[default]
    Diamond,
    /// A bevel.
    Bevel,
    /// A cone.
    Conical,
    /// A rounded end.
    Blunt,
}

/// A structure inside the body.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnStructure {
    /// Name shown next to it.
    pub name: String,
    /// Its role in the exercise.
    pub kind: DrawnStructureKind,
    /// Its surface, in m, patient frame.
    pub mesh: Mesh,
}

/// Role of a structure in the exercise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnStructureKind {
    /// The target of the puncture.
    Target,
    /// A blood vessel.
    Vessel,
    /// A nerve.
    Nerve,
    /// Bone.
    Bone,
    /// Another organ.
    Organ,
}

/// Triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices, in m.
    pub positions_m: Vec<[f32; 3]>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Axial displacement of every boundary under 1 N of every load, at some distances from the needle.
/// The displacement in a frame is the sum over its loads; the GPU computes it for every vertex of
/// every boundary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldTable {
    /// Distances from the needle's axis, ascending from 0, in m.
    pub radii_m: Vec<f32>,
    /// Number of loads: a contactor at each boundary, then the drag along each layer.
    pub loads: usize,
    /// Displacement into the body, in m/N, ordered by boundary, then load, then radius.
    pub axial_m_per_n: Vec<f32>,
}

/// One moment of an attempt.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time since the start, in s. The image depends on no other clock.
    pub t_s: f32,
    /// Tip, in m.
    pub tip_m: [f32; 3],
    /// Orientation patient_from_needle, a unit quaternion x, y, z, w; +z of the needle points from
    /// hub to tip.
    pub orientation: [f32; 4],
    /// Offset of a bent needle's tip from `tip_m`, in m; the hub does not move.
    pub bend_m: [f32; 3],
    /// Loads on the field, in N, in the table's order.
    pub loads_n: Vec<f32>,
    /// Displacement of every boundary from rest on the needle's line, in m along the needle,
    /// positive into the body. A missing one follows from the loads.
    pub dents_m: Vec<f32>,
    /// Entry point of the needle; the latest one that is open.
    pub entry_m: Option<[f32; 3]>,
    /// All punctures so far, including open ones.
    pub punctures: Vec<DrawnPuncture>,
    /// State of the hub.
    pub hub: DrawnHub,
    /// Fade of the body to show the inside: 0 for opaque, 1 for the most transparent.
    pub fade: f32,
    /// Whether to draw the planned line, entry and target.
    pub guide: bool,
    /// Index of the structure that contains the needle, to be highlighted.
    pub touched: Option<usize>,
    /// Whether the body is shown from outside: the block is not cut open.
    pub closed: bool,
    /// Another needle, drawn transparent.
    pub ghost: Option<Ghost>,
    /// The view.
    pub view: View,
    /// The user's rotation and zoom, added to the view's own.
    pub orbit: Orbit,
}

/// A needle of another attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ghost {
    /// Tip, in m.
    pub tip_m: [f32; 3],
    /// Orientation patient_from_needle, a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
}

/// A hole made by the needle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawnPuncture {
    /// Position on the skin, in m.
    pub entry_m: [f32; 3],
    /// Direction of its track into the body, unit length.
    pub axis: [f32; 3],
    /// Maximum depth of the tip along it, in m.
    pub depth_m: f32,
    /// Number of boundaries that the tip has passed.
    pub opened: u32,
    /// Blood on the skin: 0 for none, 1 for the maximum. Follows depth and damage.
    pub blood: f32,
}

/// State of the hub.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawnHub {
    /// Whether nothing is on it.
    pub open: bool,
    /// Blood in it: 0 for none, 1 for full.
    pub blood: f32,
    /// Position of a syringe's plunger: 0 where the hand holds it, 1 at full travel.
    pub plunger: f32,
    /// Radius of the forming drop, as a fraction of that at which it falls; 0 without one.
    pub drop: f32,
    /// Distance that a drop has fallen below the hub, in m; 0 without one.
    pub fallen_m: f32,
}

/// Viewpoint of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// Body, needle and space for the hand: a block of the lower back, cut open in front.
    #[default]
    Whole,
    /// The whole patient, if the scene has its skin: not cut open, and fading to show the inside.
    Patient,
    /// Close-up of the tip.
    Tip,
    /// A flat section through the needle, layer by layer, with bands and label positions.
    Section,
}

/// A rotation around the view's target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// To the right, in rad.
    pub yaw_rad: f32,
    /// Up, in rad.
    pub pitch_rad: f32,
    /// Distance, as a multiple of the view's own.
    pub distance: f32,
}

impl Default for Orbit {
    fn default() -> Self {
        Self { yaw_rad: 0.0, pitch_rad: 0.0, distance: 1.0 }
    }
}

/// Maximum number of layers.
pub const MOST_LAYERS: usize = 16;
