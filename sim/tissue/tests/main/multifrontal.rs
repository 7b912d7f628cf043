//! The direct solver of the tissue models: it solves what its elements add up to, whatever their order, and says so
//! when something can move freely. It could fail where a front loses a row, or an element's share is added twice.

use proptest::prelude::*;
use tissue::multifrontal::{Cholesky, Connectivity, FIXED};

/// A block of `n` × `m` square elements of `degree`, two unknowns a node, clamped along one side.
struct Block {
    unknowns: usize,
    elements: Vec<Vec<u32>>,
    centroids_m: Vec<[f64; 3]>,
}

impl Block {
    fn new(n: u32, m: u32, degree: u32) -> Self {
        let rows = m * degree + 1;
        let node = |i: u32, j: u32| i.checked_sub(1).map_or(FIXED, |i| i * rows + j);
        let (mut elements, mut centroids_m) = (Vec::new(), Vec::new());
        for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
            let nodes = (0..=degree).flat_map(|a| (0..=degree).map(move |b| (i * degree + a, j * degree + b)));
            let unknowns =
                nodes.map(|(a, b)| node(a, b)).flat_map(|n| if n == FIXED { [FIXED; 2] } else { [2 * n, 2 * n + 1] });
            elements.push(unknowns.collect());
            centroids_m.push([f64::from(i), f64::from(j), 0.0]);
        }
        Self { unknowns: 2 * (n * degree * rows) as usize, elements, centroids_m }
    }

    fn connectivity(&self) -> Connectivity<'_> {
        Connectivity { unknowns: self.unknowns, elements: &self.elements, centroids_m: &self.centroids_m }
    }

    /// A positive definite matrix that differs from element to element: I + v vᵀ.
    fn stiffness(&self, element: usize, matrix: &mut [f64]) {
        let n = self.elements[element].len();
        for (at, value) in matrix.iter_mut().enumerate() {
            let v = |i: usize| libm::sin((1 + i * i + 3 * element) as f64);
            *value = v(at % n) * v(at / n) + if at % n == at / n { 1.0 } else { 0.0 };
        }
    }

    /// The sum of the elements' matrices times x, in the plainest way.
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.unknowns];
        for (element, unknowns) in self.elements.iter().enumerate() {
            let mut matrix = vec![0.0; unknowns.len() * unknowns.len()];
            self.stiffness(element, &mut matrix);
            for (column, &from) in unknowns.iter().enumerate().filter(|&(_, &u)| u != FIXED) {
                for (row, &to) in unknowns.iter().enumerate().filter(|&(_, &u)| u != FIXED) {
                    product[to as usize] += matrix[column * unknowns.len() + row] * x[from as usize];
                }
            }
        }
        product
    }

    fn solve(&self, b: &[f64]) -> Vec<f64> {
        let factor = Cholesky::factorise(&self.connectivity(), |e, m| self.stiffness(e, m)).expect("positive definite");
        let (mut x, mut scratch) = (b.to_vec(), vec![0.0; factor.scratch_len()]);
        factor.solve(&mut x, &mut scratch);
        x
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn what_was_multiplied_is_found_again(n in 1u32..9, m in 1u32..9, degree in 1u32..5) {
        let block = Block::new(n, m, degree);
        let x: Vec<f64> = (0..block.unknowns).map(|i| libm::cos(i as f64)).collect();
        for (found, wanted) in block.solve(&block.times(&x)).iter().zip(&x) {
            prop_assert!((found - wanted).abs() < 1e-9, "{found} for {wanted}");
        }
    }
}

#[test]
fn the_factor_is_sparse() {
    let block = Block::new(24, 24, 2);
    let factor = Cholesky::factorise(&block.connectivity(), |e, m| block.stiffness(e, m)).expect("positive definite");
    // Nested dissection of n unknowns in the plane leaves about 31/4 n log2 n numbers (George 1973); dense are n²/2.
    let n = block.unknowns as f64;
    let bound = 7.75 * n * libm::log2(n);
    assert!((factor.nonzeros() as f64) < bound, "{} numbers, bound {bound}", factor.nonzeros());
}

#[test]
fn what_can_move_freely_is_named() {
    let block = Block::new(2, 2, 1);
    let refused =
        Cholesky::factorise(&block.connectivity(), |_, matrix| matrix.fill(1.0)).expect_err("a singular matrix");
    assert!(refused.pivot.abs() < 1e-9, "{refused}");
    let alone = Connectivity { unknowns: block.unknowns + 1, ..block.connectivity() };
    let refused = Cholesky::factorise(&alone, |e, m| block.stiffness(e, m)).expect_err("an unknown without an element");
    assert_eq!(refused.unknown, block.unknowns);
}
