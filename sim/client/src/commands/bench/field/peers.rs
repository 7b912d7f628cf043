//! What other solvers reach on `lower_back` with the load at the surface, and how many times less time we take.
//!
//! Their figures were measured on two cores, one thread, no GPU, for one static answer after set-up, by an independent
//! comparison; they are quoted, not measured here, and another machine was under them.

use super::Row;
use crate::commands::bench::sheet::Sheet;

/// One figure of another solver.
struct Peer {
    solver: &'static str,
    unknowns: u32,
    error: f64,
    time_s: f64,
    /// It solves in three dimensions, and our 3-D model is held against it too.
    is_3d: bool,
}

const fn peer(solver: &'static str, unknowns: u32, error: f64, time_s: f64, is_3d: bool) -> Peer {
    Peer { solver, unknowns, error, time_s, is_3d }
}

const PEERS: [Peer; 15] = [
    peer("scikit-fem, axisymmetric Q2, back-substitution", 150, 0.059, 10e-6, false),
    peer("scikit-fem, axisymmetric Q2, back-substitution", 558, 0.0078, 33e-6, false),
    peer("scikit-fem, axisymmetric Q2, back-substitution", 2142, 0.000_85, 150e-6, false),
    peer("the same factor, back-substitution in plain C", 558, 0.0078, 14e-6, false),
    peer("CalculiX, CAX8, whole process", 280, 0.022, 26e-3, false),
    peer("CalculiX, CAX8, whole process", 2360, 0.0011, 106e-3, false),
    peer("dolfinx, 3-D P2 tetrahedra, Cholesky re-solve", 7840, 0.056, 4.8e-3, true),
    peer("dolfinx, 3-D P2 tetrahedra, Cholesky re-solve", 23200, 0.029, 21e-3, true),
    peer("dolfinx, 3-D P2 tetrahedra, Cholesky re-solve", 47424, 0.020, 52e-3, true),
    peer("warp.fem, hexahedra degree 2, CG", 2800, 0.048, 2.7, true),
    peer("warp.fem, hexahedra degree 2, CG", 7840, 0.016, 6.7, true),
    peer("MuJoCo flex, Euler, to rest", 2800, 0.30, 0.3, true),
    peer("MuJoCo flex, Euler, to rest", 11776, 0.14, 1.9, true),
    peer("springs, Van Gelder, static", 6734, 0.12, 1.9e-3, true),
    peer("springs, cubic lattice, static", 22040, 0.16, 49e-3, true),
];

/// The table: for each figure, our cheapest answer that is no less accurate, of any model and of the 3-D one.
pub fn markdown(rows: &[Row]) -> String {
    let header = [
        "solver",
        "unknowns",
        "error",
        "its time",
        "our best model: re-solve",
        "superposed",
        "our volumetric: re-solve",
    ];
    let mut sheet = Sheet::new(header);
    let ours: Vec<&Row> = rows.iter().filter(|row| row.is_surface_load_on("lower_back")).collect();
    for peer in &PEERS {
        let good = |volumetric: bool| {
            let fits = move |row: &&&Row| row.error <= peer.error && (!volumetric || row.model == "volumetric");
            ours.iter().filter(fits).min_by(|a, b| a.solve_s.total_cmp(&b.solve_s))
        };
        let times = |time_s: f64| format!("{} ({} ×)", super::human_time(time_s), ratio(peer.time_s / time_s));
        let best = good(false);
        let volumetric = if peer.is_3d { good(true) } else { None };
        sheet.row([
            peer.solver.to_owned(),
            peer.unknowns.to_string(),
            format!("{:.3} %", peer.error * 1e2),
            super::human_time(peer.time_s),
            best.map_or_else(|| "–".to_owned(), |row| times(row.solve_s)),
            best.map_or_else(|| "–".to_owned(), |row| times(row.answer_s)),
            volumetric.map_or_else(|| "–".to_owned(), |row| times(row.solve_s)),
        ]);
    }
    sheet.markdown()
}

/// A ratio with the digits that count.
fn ratio(ratio: f64) -> String {
    match ratio {
        r if r < 10.0 => format!("{r:.1}"),
        r if r < 1e4 => format!("{r:.0}"),
        r => format!("{r:.0e}"),
    }
}
