//! The documents of an imported scene and of an exercise in it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use documents::{NeedleScaling, Scene, StructureKind, TissueFeel};
use law::structures::Surface;
use nalgebra::Vector3;

use super::super::files::{self, Folder};
use super::{ImportArgs, Imported, ImportedLayer};
use crate::exit::Failure;

/// Name of the scene's file.
pub const SCENE_FILE: &str = "scene.toml";
/// Name of the exercise's file.
pub const EXERCISE_FILE: &str = "exercise.toml";
/// Name of the skin's file.
pub const SKIN_FILE: &str = "skin.stl";

/// Maximum angle of a path in a scene, in degrees to the skin's normal.
const MOST_ANGLE_DEG: f64 = 60.0;
/// A component of a target counts if it has at least this fraction of the largest one's vertices:
/// one in ten. Our choice.
const LEAST_PIECE: usize = 10;
/// Depth of the exercise without a target, in mm, limited by the layers.
const DEPTH_MM: f64 = 25.0;

/// A threshold that had to be lowered below the table's because of the layers' order and thickness.
pub struct LoweredThreshold {
    /// The layer's name.
    pub layer: String,
    /// `tip` or `rim`.
    pub contactor: &'static str,
    /// Value in the table, in N.
    pub from_n: f64,
    /// Value in the scene, in N.
    pub to_n: f64,
}

/// The result of an import.
pub struct WrittenImport {
    /// Thresholds below those of the table.
    pub lowered: Vec<LoweredThreshold>,
    /// The path of the exercise.
    pub way: Way,
}

/// The straight path of the exercise.
pub struct Way {
    /// Angle to the skin's normal, in degrees.
    pub angle_deg: f64,
    /// Azimuth from +x to +y, in degrees.
    pub azimuth_deg: f64,
    /// Depth along the needle, in mm.
    pub depth_mm: f64,
    /// Description of the target.
    pub to: String,
    /// Number of connected components of the target.
    pub pieces: usize,
}

/// Rupture thresholds of a layer, in N.
#[derive(Clone, Copy, PartialEq)]
struct Thresholds {
    tip_n: f64,
    rim_n: f64,
}

/// Writes the scene, with thresholds that are sound on the exercise's path, and the exercise.
pub fn write(args: &ImportArgs, imported: &Imported) -> Result<WrittenImport, Failure> {
    let way = Way::new(imported);
    let named: Vec<Thresholds> = imported.layers.iter().map(thresholds).collect();
    let sound = find_sound(args, imported, &named, way.angle_deg)?;
    let mut folder = Folder::create(&args.out, args.force)?;
    folder.write(SCENE_FILE, scene_text(args, imported, &sound).as_bytes())?;
    folder.write(EXERCISE_FILE, exercise_text(args, imported, &way).as_bytes())?;
    folder.keep()?;
    let lowered = imported.layers.iter().zip(named.iter().zip(&sound)).flat_map(|(layer, (old, new))| {
        let pairs = [("tip", old.tip_n, new.tip_n), ("rim", old.rim_n, new.rim_n)];
        let lower = pairs.into_iter().filter(|(_, from_n, to_n)| to_n < from_n);
        lower.map(|(contactor, from_n, to_n)| LoweredThreshold { layer: layer.name.clone(), contactor, from_n, to_n })
    });
    Ok(WrittenImport { lowered: lowered.collect(), way })
}

fn feel_of(layer: &ImportedLayer) -> &'static TissueFeel {
    TissueFeel::of(layer.label.tissue().unwrap_or_default(), NeedleScaling::Version2)
}

fn thresholds(layer: &ImportedLayer) -> Thresholds {
    let feel = feel_of(layer);
    Thresholds { tip_n: feel.tip_n, rim_n: feel.rim_n }
}

/// Thresholds that are sound on the exercise's path.
fn find_sound(
    args: &ImportArgs,
    imported: &Imported,
    named: &[Thresholds],
    angle_deg: f64,
) -> Result<Vec<Thresholds>, Failure> {
    let path = args.out.join(SCENE_FILE);
    let mut scene: Scene = documents::load::read_scene_text(&path, &scene_text(args, imported, named))?;
    if !scene.lower_to_sound(angle_deg).map_err(|why| Failure::refused(&path, why))? {
        return Err(Failure::work(format_args!("{}: no sound thresholds were found for these layers", path.display())));
    }
    let lowered =
        scene.layers.iter().map(|layer| Thresholds { tip_n: layer.tip_rupture_n, rim_n: layer.rim_rupture_n });
    Ok(lowered.collect())
}

/// A quoted string, valid in both TOML and JSON.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn id(args: &ImportArgs) -> String {
    let folder = args.out.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let id: String = files::plain(&folder).chars().take(50).collect();
    if id.is_empty() { "imported".to_owned() } else { id }
}

fn source_name(args: &ImportArgs) -> String {
    args.segmentation.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn scene_text(args: &ImportArgs, imported: &Imported, thresholds: &[Thresholds]) -> String {
    let description = format!(
        "Imported from {} by stylet anatomy import. Shapes and thicknesses are measured; what the layers feel like is a choice for training and \
         was not measured on anybody. Simulated tissue for practice, not a patient.",
        source_name(args)
    );
    let mut text = format!(
        "# Made by stylet anatomy import. Patient frame: the origin is on the skin at the entry, +z points out of the body.\n\nid = {}\nlaw = \
         5\nscaling = 2\ntitle = {}\ndescription = {}\n",
        quoted(&id(args)),
        quoted(imported.title),
        quoted(&description)
    );
    for (layer, thresholds) in imported.layers.iter().zip(thresholds) {
        write_layer(&mut text, layer, *thresholds);
    }
    text += "\n# Our choice: the trocar of a percutaneous renal access.\n[needle]\nkind = \"trocar\"\ndiameter_mm = 1.27\ntip = \"diamond\"\ntip_to_rim_mm = \
             1.5\nlength_mm = 150\nhub_stiffness_n_per_m = 2500\nspeed_window_ms = 12\ndamping_time_ms = 10\n";
    // Writing to a string has no way to fail.
    let _ = write!(text, "\n[skin]\nfile = \"{SKIN_FILE}\"\nunit = \"mm\"\n");
    for structure in &imported.structures {
        let label = structure.label;
        let _ = write!(
            text,
            "\n[[structure]]\nname = {}\nkind = \"{}\"\nshape = \"mesh\"\nfile = \"{}\"\nunit = \"mm\"\nposition_mm = [0, 0, 0]\n",
            quoted(&label.name),
            label.kind(),
            structure.file
        );
        if let (Some(stiffness), Some(rupture_n)) = (label.wall_stiffness_n_per_m, label.wall_rupture_n) {
            let _ = write!(text, "wall_stiffness_n_per_m = {stiffness:?}\nwall_rupture_n = {rupture_n:?}\n");
        }
    }
    text
}

fn write_layer(text: &mut String, layer: &ImportedLayer, thresholds: Thresholds) {
    let feel = feel_of(layer);
    let lowered = if thresholds == self::thresholds(layer) {
        ""
    } else {
        " Thresholds lowered until no rupture raises the force in these layers."
    };
    let source = format!(
        "Thickness: measured along the skin's normal at the entry. The rest are the numbers of {}. {}{lowered}",
        feel.tissue, feel.source
    );
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "\n[[layer]]\nname = {}\nthickness_mm = {:.2}\nstiffness_n_per_m = {:?}\ndamping_n_s_per_m2 = {:?}\nstiffening_n_per_m2 = {:?}\ntip_rupture_n = {:.3}\nrim_rupture_n = \
         {:.3}\nfriction_n_per_m = {:?}\ncutting_n = {:?}\ndensity_kg_per_m3 = {:?}\npoisson_ratio = 0.45\ntexture = \"{}\"\nsource = {}\n",
        quoted(&layer.name),
        layer.measured.thickness_m * 1e3,
        feel.stiffness_n_per_m,
        feel.damping_n_s_per_m2,
        feel.stiffening_n_per_m2,
        thresholds.tip_n,
        thresholds.rim_n,
        feel.friction_n_per_m,
        feel.cutting_n,
        feel.density_kg_per_m3,
        feel.texture,
        quoted(&source)
    );
}

impl Way {
    /// The straight path to the middle of the nearest reachable component of the first target;
    /// otherwise perpendicular to the skin.
    fn new(imported: &Imported) -> Self {
        let targets = imported.structures.iter().filter(|s| s.label.structure() == Some(StructureKind::Target));
        for target in targets {
            let mut middles_mm = middles_of_pieces(&target.placed);
            let pieces = middles_mm.len();
            middles_mm.sort_by(|one, other| one.norm().total_cmp(&other.norm()));
            let angle_deg =
                |middle_mm: &Vector3<f64>| libm::acos((-middle_mm.z / middle_mm.norm()).clamp(-1.0, 1.0)).to_degrees();
            if let Some(middle_mm) = middles_mm.iter().find(|middle_mm| angle_deg(middle_mm) <= MOST_ANGLE_DEG) {
                let azimuth_deg = libm::atan2(middle_mm.y, middle_mm.x).to_degrees();
                let (angle_deg, depth_mm) = (angle_deg(middle_mm), middle_mm.norm());
                return Self { angle_deg, azimuth_deg, depth_mm, to: target.label.name.clone(), pieces };
            }
        }
        let whole_mm: f64 = imported.layers.iter().map(|layer| layer.measured.thickness_m * 1e3).sum();
        let depth_mm = DEPTH_MM.min(0.6 * whole_mm);
        Self { angle_deg: 0.0, azimuth_deg: 0.0, depth_mm, to: reached(imported, depth_mm, 0.0).to_owned(), pieces: 1 }
    }
}

/// The middles of the connected components of a surface, in mm, except small ones.
fn middles_of_pieces((vertices_m, triangles): &Surface) -> Vec<Vector3<f64>> {
    let mut parent: Vec<usize> = (0..vertices_m.len()).collect();
    for [a, b, c] in triangles.iter().map(|triangle| triangle.map(|v| v as usize)) {
        for other in [b, c] {
            let (one, other) = (find_root(&mut parent, a), find_root(&mut parent, other));
            parent[one] = other;
        }
    }
    let mut pieces: BTreeMap<usize, (usize, Vector3<f64>)> = BTreeMap::new();
    for (at, vertex) in vertices_m.iter().enumerate() {
        let (count, sum) = pieces.entry(find_root(&mut parent, at)).or_default();
        *count += 1;
        *sum += vertex.coords;
    }
    let most = pieces.values().map(|(count, _)| *count).max().unwrap_or_default();
    let whole = pieces.into_values().filter(|(count, _)| *count * LEAST_PIECE >= most);
    whole.map(|(count, sum)| sum * (1e3 / count as f64)).collect()
}

/// The representative vertex of a component.
fn find_root(parent: &mut [usize], mut at: usize) -> usize {
    while parent[at] != at {
        parent[at] = parent[parent[at]];
        at = parent[at];
    }
    at
}

/// The layer at a depth along a path.
fn reached<'i>(imported: &'i Imported, depth_mm: f64, angle_deg: f64) -> &'i str {
    let deep_mm = depth_mm * libm::cos(angle_deg.to_radians());
    let mut bottom_mm = 0.0;
    let below = imported.layers.iter().find(|layer| {
        bottom_mm += layer.measured.thickness_m * 1e3;
        bottom_mm > deep_mm
    });
    below.or(imported.layers.last()).map_or("", |layer| &layer.name)
}

fn exercise_text(args: &ImportArgs, imported: &Imported, way: &Way) -> String {
    let Way { angle_deg, azimuth_deg, depth_mm, to, .. } = way;
    let reached = reached(imported, *depth_mm, *angle_deg);
    let lean = match *angle_deg {
        angle if angle < 1.0 => "straight in".to_owned(),
        angle => format!("at {angle:.0}° to the skin's normal"),
    };
    let briefing = format!(
        "Advance {lean}, {depth_mm:.0} mm along the needle, to: {to}. Confirm there, then withdraw. Without both nothing is earned."
    );
    let mut text = format!(
        "# Made by stylet anatomy import, as a first exercise to change. Its limits are our choice; they judge simulated performance and say \
         nothing about competence with patients.\n\nid = {}\ntitle = {}\nscene = \"{SCENE_FILE}\"\ndifficulty = 3\npass_mark = 70\ntime_limit_s = \
         300\nbriefing = {}\n\n[entry]\npoint_mm = [0, 0]\nangle_deg = {angle_deg:.1}\nazimuth_deg = {azimuth_deg:.1}\n\n[target]\ndepth_mm = \
         {depth_mm:.1}\n\n[required]\nreached = {}\nwithin_mm = 4\nconfirmed = true\nwithdrawn = true\n",
        quoted(&format!("{}-reach", id(args))),
        quoted(&format!("{}: reach {to}", imported.title)),
        quoted(&briefing),
        quoted(reached)
    );
    let structures = imported.structures.iter().filter_map(|s| s.label.structure());
    let is_avoided = |kind: StructureKind| kind != StructureKind::Target;
    let mut lines = vec![
        ("depth_error_mm", 1, [0.5, 4.0], 4),
        ("overshoot_mm", 1, [0.5, 5.0], 2),
        ("lateral_work_mj", 1, [1.0, 5.0], 1),
    ];
    if structures.into_iter().any(is_avoided) {
        lines.push(("structure_hits", 2, [0.0, 2.0], 2));
    }
    for (metric, version, [full, zero], weight) in lines {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[[rubric]]\nmetric = \"{metric}\"\nversion = {version}\nfull = {full:?}\nzero = {zero:?}\nweight = {weight}\n"
        );
    }
    text
}

/// Path of the scene in a folder.
pub fn scene_path(folder: &Path) -> String {
    folder.join(SCENE_FILE).display().to_string()
}

#[cfg(test)]
mod tests {
    //! Fails if a path aims between the components of a target.

    use nalgebra::Point3;

    use super::*;

    /// Adds a tetrahedron of 10 mm around a point.
    fn tetrahedron(at_mm: [f64; 3], surface: &mut Surface) {
        let first = surface.0.len() as u32;
        for corner in [[-5.0, -5.0, -5.0], [5.0, 5.0, -5.0], [5.0, -5.0, 5.0], [-5.0, 5.0, 5.0]] {
            surface.0.push(Point3::from([0, 1, 2].map(|axis| (at_mm[axis] + corner[axis]) / 1e3)));
        }
        surface
            .1
            .extend([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|corner| corner + first)));
    }

    #[test]
    fn each_piece_of_a_target_has_its_own_middle() {
        let mut both = Surface::default();
        tetrahedron([-30.0, 0.0, -60.0], &mut both);
        tetrahedron([40.0, 0.0, -60.0], &mut both);
        let middles = middles_of_pieces(&both);
        assert_eq!(middles.len(), 2);
        for (middle, wanted_x) in middles.iter().zip([-30.0, 40.0]) {
            assert!((middle - Vector3::new(wanted_x, 0.0, -60.0)).norm() < 1e-9, "{middle}");
        }
    }
}
