//! A small picture of an exercise, drawn without a graphics card: the body cut open along the
//! planned path, with layers, structures, path and target. It shows no more than the feedback of
//! the exercise does.

use documents::picture::PicturePixels;
use documents::{Channel, ExerciseBundle, SceneLayer, StructureKind, StructureSpec};
use nalgebra::{Point3, Vector3};
use render::frame::DrawnMaterial;

use super::stage::drawn_material;

/// Width and height of the picture, in pixels.
pub const SECTION_SIZE: [u32; 2] = [192, 120];
/// Share of the height above the skin, and of the body down to the target.
const AIR: f64 = 0.24;
const DOWN_TO_TARGET: f64 = 0.52;
/// Least depth of a target for the scale, in m.
const LEAST_DEPTH_M: f64 = 5e-3;
/// Distance of the needle's tip from the skin, half the widths of needle and path, radius of the
/// target and length of a dash, in pixels.
const TIP_GAP: f64 = 9.0;
const HALF_NEEDLE: f64 = 2.2;
const HALF_PATH: f64 = 1.7;
const TARGET_RADIUS: f64 = 7.0;
const DASH: f64 = 7.0;
/// Least height of a layer, in pixels: a fascia is as thin as paper.
const LEAST_HEIGHT: f64 = 2.0;

const SKY: Colour = [226.0, 232.0, 238.0];
const NEEDLE: Colour = [120.0, 132.0, 142.0];
const PATH: Colour = [0.0, 150.0, 140.0];
const TARGET: Colour = [32.0, 138.0, 206.0];

/// Red, green and blue, 0 to 255.
type Colour = [f64; 3];

/// Draws the picture of an exercise.
pub fn draw_section(bundle: &ExerciseBundle) -> PicturePixels {
    let exercise = &bundle.exercise;
    let cut = Cut::new(bundle);
    let shows_inside = exercise.feedback.gives(Channel::Inside);
    let mut canvas = SectionCanvas::with_layers(&cut, if shows_inside { &bundle.scene.layers } else { &[] });
    for structure in bundle.scene.structures.iter().filter(|_| shows_inside) {
        canvas.fill_structure(&cut, &structure.spec);
    }
    let (entry, target) = (cut.pixel(&exercise.entry_m()), cut.pixel(&exercise.target_m()));
    let gives_target = exercise.feedback.gives(Channel::Target);
    if gives_target {
        canvas.draw(PATH, |at| {
            let (off, along) = off_line(at, entry, target);
            if along.rem_euclid(2.0 * DASH) < DASH { HALF_PATH - off } else { -1.0 }
        });
        canvas.draw(TARGET, |at| TARGET_RADIUS - libm::hypot(at[0] - target[0], at[1] - target[1]));
    }
    let tip = further(entry, target, -TIP_GAP);
    let hub = further(entry, target, -f64::from(SECTION_SIZE[1]));
    canvas.draw(NEEDLE, |at| HALF_NEEDLE - off_line(at, tip, hub).0);
    PicturePixels { size: SECTION_SIZE, rgba: canvas.rgba }
}

/// The plane of the cut: through the planned path, upright.
struct Cut {
    entry_m: Point3<f64>,
    /// Direction of the lean along the skin, of unit length; the picture shows it to the right.
    aside: Vector3<f64>,
    m_per_pixel: f64,
    /// Pixel of the planned entry.
    entry: [f64; 2],
}

impl Cut {
    fn new(bundle: &ExerciseBundle) -> Self {
        let exercise = &bundle.exercise;
        let (entry_m, way_m) = (exercise.entry_m(), exercise.target_m() - exercise.entry_m());
        let level = Vector3::new(way_m.x, way_m.y, 0.0);
        let aside = level.try_normalize(1e-6).unwrap_or_else(Vector3::x);
        let [width, height] = SECTION_SIZE.map(f64::from);
        let m_per_pixel = (-way_m.z).max(LEAST_DEPTH_M) / (DOWN_TO_TARGET * height);
        let entry = [0.5 * (width - level.norm() / m_per_pixel), AIR * height];
        Self { entry_m, aside, m_per_pixel, entry }
    }

    /// Returns the pixel at which the picture shows a point of the patient frame, in m.
    fn pixel(&self, point_m: &Point3<f64>) -> [f64; 2] {
        let off = (point_m - self.entry_m) / self.m_per_pixel;
        [self.entry[0] + off.dot(&self.aside), self.entry[1] - off.z]
    }

    /// Returns the distance of a point, in m, from the plane: positive in front of it.
    fn before_m(&self, point_m: &Point3<f64>) -> f64 {
        (point_m - self.entry_m).dot(&self.aside.cross(&Vector3::z()))
    }
}

/// The pixels of the picture, opaque.
struct SectionCanvas {
    rgba: Vec<u8>,
}

impl SectionCanvas {
    /// Fills the sky, and each layer down to the next; without layers the body is closed.
    fn with_layers(cut: &Cut, layers: &[SceneLayer]) -> Self {
        let mut bottom = cut.entry[1];
        let mut bands = vec![(bottom, SKY)];
        for layer in layers {
            bottom += (layer.thickness_mm * 1e-3 / cut.m_per_pixel).max(LEAST_HEIGHT);
            bands.push((bottom, material_colour(drawn_material(&layer.texture))));
        }
        let last = bands.last().filter(|_| bands.len() > 1).map(|(_, colour)| *colour);
        let below = last.unwrap_or_else(|| material_colour(DrawnMaterial::Skin));
        let [width, height] = SECTION_SIZE;
        let rows = (0..height).map(|row| {
            let at = f64::from(row) + 0.5;
            bands.iter().find(|(bottom, _)| at < *bottom).map_or(below, |(_, colour)| *colour)
        });
        let pixels =
            rows.flat_map(|[red, green, blue]| (0..width).flat_map(move |_| [red as u8, green as u8, blue as u8, 255]));
        Self { rgba: pixels.collect() }
    }

    /// Fills the section of a structure: a pixel is inside where a row crosses its surface an odd
    /// number of times.
    fn fill_structure(&mut self, cut: &Cut, structure: &StructureSpec) {
        let (corners_m, triangles) = structure.surface();
        let place = |index: u32| corners_m.get(index as usize).map(|at| (cut.pixel(at), cut.before_m(at)));
        let lines: Vec<[[f64; 2]; 2]> = triangles
            .iter()
            .filter_map(|[a, b, c]| Some([place(*a)?, place(*b)?, place(*c)?]))
            .filter_map(|corners| cut_triangle(&corners))
            .collect();
        let colour = structure_colour(structure.kind);
        let [width, height] = SECTION_SIZE;
        for row in 0..height {
            let y = f64::from(row) + 0.5;
            if y < cut.entry[1] {
                continue;
            }
            let mut crossed: Vec<f64> = lines.iter().filter_map(|line| cross_row(line, y)).collect();
            crossed.sort_by(f64::total_cmp);
            for pair in crossed.chunks_exact(2) {
                let [from, to] = [pair[0], pair[1]].map(|x| x.clamp(0.0, f64::from(width)));
                for column in from.round() as u32..to.round() as u32 {
                    self.blend(row * width + column, colour, 1.0);
                }
            }
        }
    }

    /// Draws a shape: `inside` returns how far a pixel is within its edge, in pixels.
    fn draw(&mut self, colour: Colour, inside: impl Fn([f64; 2]) -> f64) {
        let [width, height] = SECTION_SIZE;
        for pixel in 0..width * height {
            let at = [pixel % width, pixel / width].map(|part| f64::from(part) + 0.5);
            self.blend(pixel, colour, (inside(at) + 0.5).clamp(0.0, 1.0));
        }
    }

    fn blend(&mut self, pixel: u32, colour: Colour, share: f64) {
        let parts = self.rgba.iter_mut().skip(4 * pixel as usize);
        for (part, wanted) in parts.zip(colour) {
            *part = (f64::from(*part) + share * (wanted - f64::from(*part))).round() as u8;
        }
    }
}

/// Returns the line, in pixels, in which the plane cuts a triangle. A corner on the plane counts as
/// behind it, so that a closed surface gives closed lines.
fn cut_triangle(corners: &[([f64; 2], f64); 3]) -> Option<[[f64; 2]; 2]> {
    let edges = [(0, 1), (1, 2), (2, 0)].into_iter().filter_map(|(from, to)| {
        let ((a, before), (b, after)) = (corners[from], corners[to]);
        let share = before / (before - after);
        ((before > 0.0) != (after > 0.0)).then(|| [0, 1].map(|part| a[part] + share * (b[part] - a[part])))
    });
    let ends: Vec<[f64; 2]> = edges.collect();
    ends.try_into().ok()
}

/// Returns where a line crosses the row at a height.
fn cross_row([a, b]: &[[f64; 2]; 2], y: f64) -> Option<f64> {
    ((a[1] > y) != (b[1] > y)).then(|| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
}

/// Returns the distance of a pixel from a line between two others, and its distance along it.
fn off_line(at: [f64; 2], from: [f64; 2], to: [f64; 2]) -> (f64, f64) {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let length = libm::hypot(x, y).max(f64::MIN_POSITIVE);
    let along = ((at[0] - from[0]) * x + (at[1] - from[1]) * y) / length;
    let nearest = along.clamp(0.0, length);
    (libm::hypot(at[0] - from[0] - nearest * x / length, at[1] - from[1] - nearest * y / length), along)
}

/// Returns the point on a line through two others, at a distance from the first.
fn further(from: [f64; 2], to: [f64; 2], distance: f64) -> [f64; 2] {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let share = distance / libm::hypot(x, y).max(f64::MIN_POSITIVE);
    [from[0] + share * x, from[1] + share * y]
}

fn material_colour(material: DrawnMaterial) -> Colour {
    match material {
        DrawnMaterial::Skin => [206.0, 122.0, 102.0],
        DrawnMaterial::Fat => [253.0, 228.0, 132.0],
        DrawnMaterial::Fascia => [236.0, 231.0, 216.0],
        DrawnMaterial::Muscle => [158.0, 48.0, 44.0],
        DrawnMaterial::Bone => [212.0, 204.0, 180.0],
        DrawnMaterial::Fluid => [150.0, 192.0, 216.0],
    }
}

fn structure_colour(kind: StructureKind) -> Colour {
    match kind {
        StructureKind::Target => TARGET,
        StructureKind::Vessel => [196.0, 30.0, 38.0],
        StructureKind::Nerve => [206.0, 220.0, 234.0],
        StructureKind::Bone => [212.0, 204.0, 180.0],
        StructureKind::Organ => [112.0, 50.0, 84.0],
    }
}

#[cfg(test)]
mod tests {
    //! Fails if the picture shows another exercise, or more than the exercise's feedback does.

    use documents::Feedback;

    use super::*;

    fn bundle(file: &str) -> ExerciseBundle {
        let curricula = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula");
        ExerciseBundle::read(&curricula.join(file)).expect("a shipped exercise")
    }

    fn has(picture: &PicturePixels, colour: Colour) -> bool {
        let wanted = colour.map(|part| part as u8);
        picture.rgba.as_chunks::<4>().0.iter().any(|pixel| pixel[..3] == wanted)
    }

    #[test]
    fn section_shows_layers_structures_needle_and_target() {
        let bundle = bundle("lower-back-basics/6-avoid-the-vessel.toml");
        let picture = draw_section(&bundle);
        assert_eq!(picture.rgba.len(), 4 * 192 * 120);
        let materials = [DrawnMaterial::Skin, DrawnMaterial::Fat, DrawnMaterial::Muscle].map(material_colour);
        let structures = [StructureKind::Vessel, StructureKind::Bone].map(structure_colour);
        for colour in materials.into_iter().chain(structures).chain([SKY, NEEDLE, PATH, TARGET]) {
            assert!(has(&picture, colour), "{colour:?} is missing");
        }
    }

    #[test]
    fn section_of_an_oblique_path_leans_to_the_right() {
        let cut = Cut::new(&bundle("lower-back-basics/5-oblique-approach.toml"));
        let exercise = bundle("lower-back-basics/5-oblique-approach.toml").exercise;
        let [[entry, skin], [target, deep]] = [exercise.entry_m(), exercise.target_m()].map(|at| cut.pixel(&at));
        let angle_deg = libm::atan2(target - entry, deep - skin).to_degrees();
        assert!((angle_deg - exercise.angle_deg).abs() < 0.01 && exercise.angle_deg > 5.0, "{angle_deg}°");
        assert!(cut.before_m(&exercise.target_m()).abs() < 1e-12, "the cut contains the path");
    }

    #[test]
    fn section_hides_what_the_feedback_withholds() {
        let mut bundle = bundle("lower-back-basics/6-avoid-the-vessel.toml");
        bundle.exercise.feedback = Feedback::Force;
        let picture = draw_section(&bundle);
        let vessel = structure_colour(StructureKind::Vessel);
        for hidden in [vessel, material_colour(DrawnMaterial::Fat), TARGET, PATH] {
            assert!(!has(&picture, hidden), "{hidden:?} is shown");
        }
        assert!(has(&picture, material_colour(DrawnMaterial::Skin)) && has(&picture, NEEDLE));
    }

    #[test]
    fn a_solid_is_filled_where_the_plane_cuts_it() {
        let bundle = bundle("lower-back-basics/6-avoid-the-vessel.toml");
        let cut = Cut::new(&bundle);
        let vessel = bundle.scene.structures.iter().find(|it| it.kind() == StructureKind::Vessel).expect("a vessel");
        let [x, y] = cut.pixel(&vessel.spec.position_m);
        let picture = draw_section(&bundle);
        let at = 4 * (y as usize * SECTION_SIZE[0] as usize + x as usize);
        assert_eq!(picture.rgba[at..at + 3], structure_colour(StructureKind::Vessel).map(|part| part as u8));
    }
}
