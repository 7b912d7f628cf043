//! The six cells of the paper's law (physics section 1): a single contactor without friction or cutting is the closed form
//! to round-off, in each layer before and after its rupture.
//!
//! It would fail if damping used a wrong layer's coefficient or length, which are the paper's own misprints.

use law::axial::{AxialSpec, Layer};
use trials::scenes::{AxialRun, make_layer, needle_through};

const SPEED: f64 = 0.002;
const DT: f64 = 0.001;

/// Table I, with thresholds low enough that every cell is visited alone.
fn table_i() -> AxialSpec {
    needle_through(vec![
        make_layer("skin", [0.8, 331.0, 3.0, 0.1, 0.0, 0.0, 0.0]),
        make_layer("fat", [8.4, 83.0, 1.0, 0.3, 0.0, 0.0, 0.0]),
        make_layer("muscle", [39.0, 497.0, 3.0, 1.5, 0.0, 0.0, 0.0]),
    ])
}

/// Σ_{j<i} b_j d_j, in N·s/m.
fn passed(above: &[Layer]) -> f64 {
    above.iter().map(|layer| layer.damping_n_s_per_m2 * layer.thickness_m).sum()
}

/// Force in cell (layer i, before or after its rupture) at displacement x and speed v.
fn cell(layers: &[Layer], i: usize, ruptured: bool, (x, v): (f64, f64)) -> f64 {
    let y = x - layers[..i].iter().map(|layer| layer.thickness_m).sum::<f64>();
    let here = &layers[i];
    if ruptured {
        v * (here.damping_n_s_per_m2 * y.min(here.thickness_m) + passed(&layers[..i]))
    } else {
        here.stiffness_n_per_m * y + v * passed(&layers[..i])
    }
}

#[test]
fn a_single_contactor_is_the_closed_form_in_all_six_cells() {
    let spec = table_i();
    let mut run = AxialRun::new(spec.clone()).expect("a valid scene");
    let mut visited = [[0_u32; 2]; 3];
    let mut x_before = 0.0;
    for tick in 0..24_000 {
        let x = f64::from(tick) * DT * SPEED;
        let output = run.step(f64::from(tick) * DT, x);
        let v = (x - x_before) / (f64::from(tick) * DT - (f64::from(tick) - 1.0) * DT);
        x_before = x;
        let open = run.state.tip_open;
        let reached = |i: usize| x > spec.layers[..i].iter().map(|layer| layer.thickness_m).sum::<f64>();
        let (i, ruptured) = if open < 3 && reached(open) { (open, false) } else { (open.max(1) - 1, true) };
        if tick == 0 || open == 0 && ruptured {
            continue;
        }
        let wanted = cell(&spec.layers, i, ruptured, (x, v));
        assert!((output.total_n() - wanted).abs() <= 1e-14, "x = {x}: {} is not {wanted}", output.total_n());
        visited[i][usize::from(ruptured)] += 1;
    }
    assert!(visited.iter().flatten().all(|&ticks| ticks > 50), "a cell was hardly visited: {visited:?}");
}
