//! The law against an independent implementation: every component of every sample of `tests/data/force/*.csv` to a relative
//! 1e-9 (absolute 1e-12), and the same events in the same order.
//!
//! It would fail on another order of ruptures and forces within a tick, another first-sample rule, or another idea
//! of when the tip cuts.

use law::axial::{AxialOutput, AxialSpec};
use trials::scenes::AxialRun;

fn close(found: f64, wanted: f64) -> bool {
    (found - wanted).abs() <= 1e-12_f64.max(1e-9 * wanted.abs())
}

fn columns(output: &AxialOutput) -> [f64; 8] {
    [
        output.v_m_per_s,
        output.total_n(),
        output.tip_n,
        output.rim_n,
        output.viscous_n,
        output.friction_n,
        output.cutting_n,
        output.depth_m,
    ]
}

/// Replays a reference file and returns how many samples were compared and how many carried events.
fn replay(scene_json: &str, csv: &str) -> (usize, usize) {
    let spec: AxialSpec = serde_json::from_str(scene_json).expect("a scene");
    let mut run = AxialRun::new(spec).expect("a valid scene");
    let (mut samples, mut with_events) = (0, 0);
    for (line, row) in csv.lines().enumerate().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        let numbers: Vec<f64> = fields[..10].iter().map(|field| field.parse().expect("a number")).collect();
        let output = run.step(numbers[0], numbers[1]);
        for (column, (found, wanted)) in columns(&output).into_iter().zip(&numbers[2..]).enumerate() {
            assert!(close(found, *wanted), "line {}, column {}: {found} is not {wanted}", line + 1, column + 2);
        }
        assert_eq!(run.events(), fields[10], "line {}", line + 1);
        if let Some(lost_j) = fields.get(11) {
            let found_j: f64 = run.state.ledger.layers.iter().map(|layer| layer.viscous_j).sum();
            let wanted_j: f64 = lost_j.parse().expect("a number");
            assert!(
                (found_j - wanted_j).abs() <= 1e-14_f64.max(1e-9 * wanted_j),
                "line {}: {found_j} J is not {wanted_j} J",
                line + 1
            );
        }
        samples += 1;
        with_events += usize::from(!fields[10].is_empty());
    }
    (samples, with_events)
}

#[test]
fn the_papers_six_cells() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/table_i.json"),
        include_str!("../../../../tests/data/force/table_i.csv"),
    );
    assert_eq!((samples, events), (2463, 3));
}

#[test]
fn the_trocar() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/trocar.json"),
        include_str!("../../../../tests/data/force/trocar.csv"),
    );
    assert_eq!((samples, events), (2463, 6));
}

#[test]
fn training_in_hold_out_in() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/training_in_hold_out_in.json"),
        include_str!("../../../../tests/data/force/training_in_hold_out_in.csv"),
    );
    assert_eq!((samples, events), (3452, 6));
}

/// Positions in steps of 55 µm, speed over a window of 7.5 ms: most ticks bring no new position.
#[test]
fn an_encoder_in_steps_of_55_um() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/encoder_55um.json"),
        include_str!("../../../../tests/data/force/encoder_55um.csv"),
    );
    assert_eq!((samples, events), (3858, 6));
}

/// Branches integrated by an ODE solver, held and drawn back a little, and what their dashpots lost by each sample.
#[test]
fn tents_that_relax() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/relaxing.json"),
        include_str!("../../../../tests/data/force/relaxing.csv"),
    );
    assert_eq!((samples, events), (2886, 6));
}

/// Boundaries that give way where their spring alone holds the threshold, whatever the branches beside it add.
#[test]
fn tents_that_give_way_at_a_dent() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/yielding.json"),
        include_str!("../../../../tests/data/force/yielding.csv"),
    );
    assert_eq!((samples, events), (1651, 6));
}

#[test]
fn tents_that_stiffen() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/stiffening.json"),
        include_str!("../../../../tests/data/force/stiffening.csv"),
    );
    assert_eq!((samples, events), (1851, 6));
}

/// Static friction until the shaft has slid, renewed by a long rest and by going back, not by a short rest.
#[test]
fn friction_that_breaks_away() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/breakaway.json"),
        include_str!("../../../../tests/data/force/breakaway.csv"),
    );
    assert_eq!((samples, events), (1541, 1));
}

/// Damping by a spring and a dashpot, integrated by an ODE solver: in and out through two layers, held, trembling, and what is lost by each sample.
#[test]
fn damping_by_a_spring_and_a_dashpot() {
    let (samples, events) = replay(
        include_str!("../../../../tests/data/force/damping.json"),
        include_str!("../../../../tests/data/force/damping.csv"),
    );
    assert_eq!((samples, events), (1501, 2));
}
