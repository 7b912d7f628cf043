//! What a picture is of: plain data, in SI units and the patient frame (skin at z = 0 or touching it, the body below, x to the right, y away).
//!
//! A [`Stage`] is constant for an attempt and goes to the graphics card once; a [`Frame`] is one moment of it.

/// What is constant for an attempt.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stage {
    /// Layers from the skin down.
    pub layers: Vec<DrawnLayer>,
    /// The needle.
    pub needle: DrawnNeedle,
    /// Structures inside the body.
    pub structures: Vec<DrawnStructure>,
    /// How every boundary gives way under the field's loads.
    pub field: FieldTable,
    /// Planned entry on the skin, in m.
    pub entry_m: [f32; 3],
    /// Planned direction into the body, unit length.
    pub axis: [f32; 3],
    /// Where the tip should come to rest, in m; none where that is not to be seen.
    pub target_m: Option<[f32; 3]>,
    /// How skin and layers bend.
    pub bend: DrawnBend,
    /// A mesh of the skin, where the scene brings one. One that is closed is a whole patient.
    pub skin: Option<Mesh>,
}

impl Stage {
    /// Depth of the lowest boundary, in m.
    #[must_use]
    pub fn depth_m(&self) -> f32 {
        self.layers.iter().map(|layer| layer.top_m + layer.thickness_m).fold(0.0, f32::max)
    }

    /// The skin of the whole patient, where this is to be seen.
    #[must_use]
    pub fn patient(&self, view: View) -> Option<&Mesh> {
        self.skin.as_ref().filter(|_| view == View::Patient)
    }
}

/// How skin and layers bend away from z = 0, which the skin touches at the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DrawnBend {
    /// They do not.
    #[default]
    Flat,
    /// Concentric with a sphere of this radius, in m.
    Sphere(f32),
    /// Concentric with a cylinder.
    Cylinder {
        /// Radius, in m.
        radius_m: f32,
        /// Direction of its line in the plane z = 0, of unit length.
        line: [f32; 2],
    },
}

impl DrawnBend {
    /// Four numbers for the shaders: the radius in m, 0 where nothing bends; the line's direction; 1 for a cylinder.
    #[must_use]
    pub fn packed(&self) -> [f32; 4] {
        match *self {
            Self::Flat => [0.0; 4],
            Self::Sphere(radius_m) => [radius_m, 0.0, 0.0, 0.0],
            Self::Cylinder { radius_m, line: [x, y] } => [radius_m, x, y, 1.0],
        }
    }

    /// Height of the skin at a place in plan, in m. `concentric` in `scene.wgsl` does the same for every layer.
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

/// So far aside, in radii, a layer goes straight on, at 49°: a picture shows the neighbourhood of an entry, not a whole ball.
const TURNED: f32 = 0.75;

/// A layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnLayer {
    /// Name shown beside its band.
    pub name: String,
    /// What it is made of.
    pub material: DrawnMaterial,
    /// Depth of its upper boundary, in m.
    pub top_m: f32,
    /// Thickness, in m; 0 for a membrane.
    pub thickness_m: f32,
}

/// What a layer or structure looks like.
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

/// The needle: a cannula, and inside it a stylet whose tip stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawnNeedle {
    /// Length from tip to hub, in m.
    pub length_m: f32,
    /// Outer diameter of the cannula, in m.
    pub diameter_m: f32,
    /// Distance from the stylet's tip to the cannula's rim, in m; 0 is a needle without cannula.
    pub tip_to_rim_m: f32,
    /// Shape of the tip.
    pub tip: Tip,
    /// What is on the hub while it is not open.
    pub hub: OnHub,
}

/// What is on a needle's hub.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnHub {
    /// The knob of the stylet that fills the needle.
    #[default]
    Stylet,
    /// A syringe of glass, whose plunger yields when resistance is lost.
    Syringe,
}

/// Shape of a tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tip {
    /// Three facets, as trocars have.
    #[default]
    Diamond,
    /// A slanted cut.
    Bevel,
    /// A cone.
    Conical,
    /// A rounded end.
    Blunt,
}

/// Something inside the body.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnStructure {
    /// Name shown beside it.
    pub name: String,
    /// What it is to the exercise.
    pub kind: DrawnStructureKind,
    /// Its surface, in m, patient frame.
    pub mesh: Mesh,
}

/// What a structure is to the exercise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnStructureKind {
    /// What should be reached.
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

/// Triangles with outward faces counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners, in m.
    pub positions_m: Vec<[f32; 3]>,
    /// Three corners a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Axial displacement of every boundary under 1 N of every load, at some distances from the needle. The displacement at a moment
/// is the sum over the loads of the frame; the graphics card adds it up for every corner of every boundary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldTable {
    /// Distances from the needle's axis, rising from 0, in m.
    pub radii_m: Vec<f32>,
    /// Loads: a contactor at each boundary, then the drag along each layer.
    pub loads: usize,
    /// Displacement into the body, in m/N: boundary by boundary, in it load by load, in it radius by radius.
    pub axial_m_per_n: Vec<f32>,
}

/// One moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time since the start, in s. Nothing in the picture depends on any other clock.
    pub t_s: f32,
    /// Tip, in m.
    pub tip_m: [f32; 3],
    /// Orientation patient_from_needle, a unit quaternion x, y, z, w; +z of the needle points from hub to tip.
    pub orientation: [f32; 4],
    /// What the tip of a needle that bends is off `tip_m`, in m; the hub stays.
    pub bend_m: [f32; 3],
    /// Loads that the field carries, in N, in the table's order.
    pub loads_n: Vec<f32>,
    /// How far every boundary stands from its rest where the needle's line meets it, in m along the needle, positive into the body. A
    /// boundary without one stands as the loads have it.
    pub dents_m: Vec<f32>,
    /// Where the needle went in, the last one open.
    pub entry_m: Option<[f32; 3]>,
    /// Every puncture so far, the open ones too.
    pub punctures: Vec<DrawnPuncture>,
    /// What is seen at the hub.
    pub hub: DrawnHub,
    /// How far the body is faded to show what is inside: 0 opaque, 1 as clear as it gets.
    pub fade: f32,
    /// Draw the planned line, entry and target.
    pub guide: bool,
    /// Structure that the needle is in, to be lit up.
    pub touched: Option<usize>,
    /// The body is seen from outside: the block is not cut open.
    pub closed: bool,
    /// Another needle, drawn as a ghost.
    pub ghost: Option<Ghost>,
    /// From where.
    pub view: View,
    /// The person's own turn and zoom, on top of the view's.
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

/// A hole that the needle made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawnPuncture {
    /// On the skin, in m.
    pub entry_m: [f32; 3],
    /// Direction of its track into the body, unit length.
    pub axis: [f32; 3],
    /// Deepest that the tip went along it, in m.
    pub depth_m: f32,
    /// Boundaries that the tip has gone through.
    pub opened: u32,
    /// Blood at the skin: 0 none, 1 as much as it gets. Follows depth and damage.
    pub blood: f32,
}

/// What is seen at the hub.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawnHub {
    /// Nothing is on it.
    pub open: bool,
    /// Blood in it: 0 none, 1 full.
    pub blood: f32,
    /// How far a syringe's plunger has gone in: 0 where the hand holds it, 1 as far as it goes.
    pub plunger: f32,
    /// Radius of the drop that forms at it, as a share of that at which it falls; 0 without one.
    pub drop: f32,
    /// How far below the hub a drop has fallen, in m; 0 where none is in the air.
    pub fallen_m: f32,
}

/// From where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// Body, needle and hand's room: a block of the lower back, cut open in front.
    #[default]
    Whole,
    /// The whole patient, where the scene brings its skin: not cut open, and fading to what is inside.
    Patient,
    /// The tip, close.
    Tip,
    /// A flat section through the needle, layer by layer, with bands and names' places.
    Section,
}

/// A turn around what the view looks at.
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

/// Layers that a picture takes.
pub const MOST_LAYERS: usize = 16;
