//! Other starts from a scene: its ruptures in every order that its layers allow, at the drops of
//! the curve or hidden between them.
//!
//! A drop does not identify its rupture. Tips open their boundaries from the skin down, and so do
//! rims, each behind its tip; the interleaving of the two rows depends on every parameter of the
//! scene, so that parameters a quarter off may change it. Several boundaries may open at one drop,
//! and one that new friction and cutting compensate shows none.

use law::axial::{AxialSpec, Contactor};

use super::drops::{Drop, Front};
use super::guess::{Leader, find_leaders, largest_drops, move_place};
use super::model::Guess;

/// Number of beginnings that are followed, and of complete assignments that are tried: those that
/// move ruptures least.
const FOLLOWED: usize = 400;
const TRIED: usize = 200;
/// Penalty for a rupture that shows no drop, or shares one, as a distance that it would have to
/// move, in m (choice).
const HIDDEN_M: f64 = 1e-3;
const SHARED_M: f64 = 1e-3;

/// An assignment of the first ruptures of either row to the beginning of a curve.
#[derive(Clone)]
struct Beginning {
    /// Number of assigned tips and rims.
    told: [usize; 2],
    /// Number of assigned drops.
    drops: usize,
    /// Each rupture, in order, with its drop; `None` if it is hidden.
    ruptures: Vec<(Leader, Option<usize>)>,
    /// Total distance by which ruptures are moved, in m.
    moved_m: f64,
}

/// Guesses from a scene, ordered by how little they move its ruptures.
pub(super) fn in_every_order(front: &Front, start: &AxialSpec) -> Vec<Guess> {
    let ruptures = find_leaders(front, start);
    let rows = [Contactor::Tip, Contactor::Rim]
        .map(|contactor| ruptures.iter().filter(|leader| leader.contactor == contactor).copied().collect::<Vec<_>>());
    let drops = largest_drops(front.drops(), ruptures.len());
    let none = Beginning { told: [0; 2], drops: 0, ruptures: Vec::new(), moved_m: 0.0 };
    let mut tellings = vec![none];
    for _ in 0..ruptures.len() {
        tellings = tellings.iter().flat_map(|telling| telling.longer(front, &rows, &drops)).collect();
        tellings.sort_by(|a, b| a.moved_m.total_cmp(&b.moved_m));
        tellings.truncate(FOLLOWED);
    }
    let whole = tellings.into_iter().filter(|telling| telling.drops == drops.len());
    whole.take(TRIED).map(|telling| telling.guess(front, start, &drops)).collect()
}

impl Beginning {
    /// All extensions by one rupture.
    fn longer(&self, front: &Front, rows: &[Vec<Leader>; 2], drops: &[Drop]) -> Vec<Self> {
        let mut longer = Vec::new();
        for (row, leaders) in rows.iter().enumerate() {
            let Some(&leader) = leaders.get(self.told[row]) else { continue };
            let is_behind = |(told, _): &(Leader, Option<usize>)| told.boundary >= leader.boundary;
            let opens = leader.contactor == Contactor::Tip
                || self.ruptures.iter().filter(|told| told.0.contactor == Contactor::Tip).any(is_behind);
            if !opens {
                continue;
            }
            let way_m = |drop: usize| drops.get(drop).map(|drop| (front.middle_m(drop.gap) - leader.x_m).abs());
            let last = self.ruptures.last().and_then(|(_, drop)| *drop);
            let own = way_m(self.drops).map(|way_m| (Some(self.drops), way_m));
            let shared = last.and_then(|last| Some((Some(last), way_m(last)? + SHARED_M)));
            for (drop, way_m) in own.into_iter().chain(shared).chain([(None, HIDDEN_M)]) {
                let mut next = self.clone();
                next.told[row] += 1;
                next.drops = next.drops.max(drop.map_or(0, |drop| drop + 1));
                next.ruptures.push((leader, drop));
                next.moved_m += way_m;
                longer.push(next);
            }
        }
        longer
    }

    /// The scene with its ruptures as assigned; hidden ones evenly between those that are not.
    fn guess(&self, front: &Front, start: &AxialSpec, drops: &[Drop]) -> Guess {
        let shown = |at: usize| {
            let drop = self.ruptures.get(at).and_then(|(_, drop)| *drop)?;
            Some(front.middle_m(drops.get(drop)?.gap))
        };
        let to_m = |at: usize| {
            let before = (0..=at).rev().find_map(|at| Some((at + 1, shown(at)?))).unwrap_or((0, front.middle_m(0)));
            let count = self.ruptures.len();
            let last_m = front.middle_m(front.gaps() - 1);
            let behind = (at..count).find_map(|at| Some((at + 1, shown(at)?))).unwrap_or((count + 1, last_m));
            let part = (at + 1 - before.0) as f64 / (behind.0 - before.0).max(1) as f64;
            before.1 + part * (behind.1 - before.1)
        };
        move_place(front, start, self.ruptures.iter().enumerate().map(|(at, (leader, _))| (*leader, to_m(at))))
    }
}
