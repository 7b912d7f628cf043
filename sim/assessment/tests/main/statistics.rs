//! Statistics against published vectors, against laws that hold for any data, and where nothing can be computed.
//! Fails when a formula, a divisor or a definition of a quantile changes, or when a figure appears that has no meaning.

use assessment::statistics::{
    NotComputable, area_under_curve, content_validity, cronbach_alpha, hedges_g, holm_adjusted, intraclass_correlation,
    mann_whitney, mean, quantile, rank_correlation, scale_content_validity, summary, wilson,
};
use proptest::prelude::*;

const ROUNDING: f64 = 1e-9;

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-4, "{found} is not {expected}");
}

fn rows(table: &[&[f64]]) -> Vec<Vec<Option<f64>>> {
    table.iter().map(|row| row.iter().copied().map(Some).collect()).collect()
}

fn shrout_fleiss() -> Vec<Vec<Option<f64>>> {
    rows(&[
        &[9.0, 2.0, 5.0, 8.0],
        &[6.0, 1.0, 3.0, 2.0],
        &[8.0, 4.0, 6.0, 8.0],
        &[7.0, 1.0, 2.0, 6.0],
        &[10.0, 5.0, 6.0, 9.0],
        &[6.0, 2.0, 4.0, 7.0],
    ])
}

#[test]
fn wilsons_interval_has_its_published_ends() {
    let interval = wilson(18, 20).unwrap();
    close(interval.low, 0.6990);
    close(interval.high, 0.9721);
    assert_eq!(wilson(0, 0), Err(NotComputable::TooFew { found: 0, needed: 1 }));
    assert_eq!(wilson(3, 2), Err(NotComputable::OutOfRange));
}

#[test]
fn intraclass_correlations_are_those_of_shrout_and_fleiss() {
    let icc = intraclass_correlation(&shrout_fleiss()).unwrap();
    close(icc.single_random, 0.2898);
    close(icc.average_random.unwrap(), 0.6201);
    close(icc.single_fixed, 0.7148);
    close(icc.average_fixed, 0.9093);
    assert_eq!((icc.n, icc.raters, icc.missing), (6, 4, 0));
}

/// The ends that other programs print for the same table, to their two digits.
#[test]
fn intervals_of_agreement_are_those_of_mcgraw_and_wong() {
    let icc = intraclass_correlation(&shrout_fleiss()).unwrap();
    let near = |found: (f64, f64), low: f64, high: f64| (found.0 - low).abs() < 6e-3 && (found.1 - high).abs() < 6e-3;
    assert!(near(icc.single_random_95.unwrap(), 0.019, 0.76), "{icc:?}");
    assert!(near(icc.average_random_95.unwrap(), 0.071, 0.93), "{icc:?}");
    let same = rows(&[&[1.0, 1.0], &[4.0, 4.0], &[2.0, 2.0]]);
    assert_eq!(intraclass_correlation(&same).unwrap().single_random_95, None);
}

/// Rows and raters whose mean ratings have no spread left once error is taken out of both: ICC(2,k) divides by nothing, the
/// three others do not.
#[test]
fn raters_below_chance_agreement_have_no_average_correlation() {
    let table = rows(&[
        &[1.0, 3.0, 3.0, 2.0],
        &[3.0, 3.0, 1.0, 4.0],
        &[5.0, 2.0, 2.0, 1.0],
        &[5.0, 3.0, 1.0, 3.0],
        &[2.0, 2.0, 5.0, 1.0],
    ]);
    let tenfold: Vec<Vec<_>> =
        table.iter().map(|row| row.iter().map(|v| v.map(|v| v * 10.7 + 1.6)).collect()).collect();
    for table in [table, tenfold] {
        let icc = intraclass_correlation(&table).unwrap();
        assert_eq!((icc.average_random, icc.average_random_95), (None, None));
        close(icc.single_random, -1.0 / 3.0);
        close(icc.single_fixed, -0.279_11);
    }
}

#[test]
fn a_row_with_a_gap_is_left_out_and_counted() {
    let mut table = shrout_fleiss();
    table.push(vec![Some(1.0), None, Some(9.0), Some(3.0)]);
    let icc = intraclass_correlation(&table).unwrap();
    close(icc.single_random, 0.2898);
    assert_eq!((icc.n, icc.missing), (6, 1));
    let alpha = cronbach_alpha(&table).unwrap();
    assert_eq!((alpha.n, alpha.missing, alpha.items), (6, 1, 4));
}

#[test]
fn alpha_is_that_of_the_formula() {
    // Item variances 2.5, 1.8, 2.5; variance of the sums 18.3: 3/2·(1 − 6.8/18.3).
    let table = rows(&[&[3.0, 4.0, 3.0], &[2.0, 2.0, 1.0], &[5.0, 4.0, 5.0], &[1.0, 2.0, 2.0], &[4.0, 5.0, 4.0]]);
    close(cronbach_alpha(&table).unwrap().alpha, 0.9426);
}

#[test]
fn alpha_and_icc_say_why_they_are_not_computable() {
    let one_item = rows(&[&[1.0], &[2.0]]);
    let one_person = rows(&[&[1.0, 2.0]]);
    let no_variance = rows(&[&[0.1, 0.7], &[0.1, 0.7], &[0.1, 0.7]]);
    let nobody = vec![vec![None, Some(1.0)], vec![Some(2.0), None]];
    let ragged = rows(&[&[1.0, 2.0], &[1.0]]);
    for (table, why) in [
        (one_item, NotComputable::TooFewItems { found: 1, needed: 2 }),
        (one_person, NotComputable::TooFew { found: 1, needed: 2 }),
        (no_variance, NotComputable::NoVariance),
        (nobody, NotComputable::TooFew { found: 0, needed: 2 }),
        (ragged, NotComputable::Ragged),
        (vec![], NotComputable::TooFewItems { found: 0, needed: 2 }),
        (rows(&[&[1.0, f64::NAN], &[1.0, 2.0]]), NotComputable::OutOfRange),
    ] {
        assert_eq!(cronbach_alpha(&table).map(|r| r.alpha), Err(why), "α of {table:?}");
        assert_eq!(intraclass_correlation(&table).map(|r| r.single_random), Err(why), "ICC of {table:?}");
    }
}

#[test]
fn content_validity_is_a_share_of_those_who_rated() {
    let item = content_validity(&[Some(4), Some(3), Some(2), None, Some(4)]).unwrap();
    close(item.value, 0.75);
    assert_eq!((item.n, item.missing), (4, 1));
    let scale = scale_content_validity(&[vec![Some(4), Some(4)], vec![Some(1), Some(3)], vec![None]]).unwrap();
    close(scale.value, 0.75);
    assert_eq!((scale.n, scale.missing), (2, 1));
    assert_eq!(content_validity(&[None]), Err(NotComputable::TooFew { found: 0, needed: 1 }));
    assert_eq!(content_validity(&[Some(5)]), Err(NotComputable::OutOfRange));
    assert_eq!(scale_content_validity(&[vec![None]]), Err(NotComputable::TooFewItems { found: 0, needed: 1 }));
    assert_eq!(scale_content_validity(&[vec![Some(0)]]), Err(NotComputable::OutOfRange));
}

#[test]
fn quartiles_interpolate_as_r_does() {
    let five = summary(&[3.0, 1.0, 4.0, 2.0]).unwrap();
    close(five.lower_quartile, 1.75);
    close(five.median, 2.5);
    close(five.upper_quartile, 3.25);
    close(quantile(&[7.0], 0.9).unwrap(), 7.0);
    assert_eq!(quantile(&[], 0.5), Err(NotComputable::TooFew { found: 0, needed: 1 }));
    assert_eq!(quantile(&[1.0], 1.5), Err(NotComputable::OutOfRange));
    assert_eq!(summary(&[f64::INFINITY]), Err(NotComputable::OutOfRange));
}

#[test]
fn a_mean_has_students_interval() {
    let estimate = mean(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
    close(estimate.value, 3.0);
    close(estimate.low, 1.0368);
    close(estimate.high, 4.9632);
    assert_eq!(mean(&[1.0]), Err(NotComputable::TooFew { found: 1, needed: 2 }));
    assert_eq!(mean(&[1.0, f64::NAN]), Err(NotComputable::OutOfRange));
}

#[test]
fn spearmans_rho_has_the_interval_of_bonett_and_wright() {
    let left = [106.0, 100.0, 86.0, 101.0, 99.0, 103.0, 97.0, 113.0, 112.0, 110.0];
    let right = [7.0, 27.0, 2.0, 50.0, 28.0, 29.0, 20.0, 12.0, 6.0, 17.0];
    let pairs: Vec<_> = left.into_iter().zip(right).collect();
    let rho = rank_correlation(&pairs).unwrap();
    close(rho.value, -29.0 / 165.0);
    close(rho.low, -0.7278);
    close(rho.high, 0.5145);
    assert_eq!(rank_correlation(&pairs[..3]), Err(NotComputable::TooFew { found: 3, needed: 4 }));
    let flat: Vec<_> = pairs.iter().map(|(l, _)| (*l, 1.0)).collect();
    assert_eq!(rank_correlation(&flat), Err(NotComputable::NoVariance));
}

proptest! {
    #[test]
    fn wilson_holds_the_share_and_mirrors((successes, trials) in (1_usize..500).prop_flat_map(|n| (0..=n, Just(n)))) {
        let (a, b) = (wilson(successes, trials).unwrap(), wilson(trials - successes, trials).unwrap());
        prop_assert!(a.low <= a.value + ROUNDING && a.value <= a.high + ROUNDING && a.low >= 0.0 && a.high <= 1.0);
        prop_assert!((a.low - (1.0 - b.high)).abs() < ROUNDING);
    }

    #[test]
    fn alpha_and_icc_ignore_the_shift_and_factor_of_a_scale(
        table in prop::collection::vec(prop::collection::vec(0_u8..6, 4), 3..12), shift in -50.0..50.0, factor in 0.5..20.0
    ) {
        let plain: Vec<Vec<_>> = table.iter().map(|r| r.iter().map(|v| Some(f64::from(*v))).collect()).collect();
        let moved: Vec<Vec<_>> = table.iter().map(|r| r.iter().map(|v| Some(f64::from(*v) * factor + shift)).collect()).collect();
        match (cronbach_alpha(&plain), cronbach_alpha(&moved)) {
            (Ok(a), Ok(b)) => prop_assert!((a.alpha - b.alpha).abs() < 1e-6 * a.alpha.abs().max(1.0)),
            (a, b) => prop_assert_eq!(a.map(|r| r.n), b.map(|r| r.n)),
        }
        match (intraclass_correlation(&plain), intraclass_correlation(&moved)) {
            (Ok(a), Ok(b)) => prop_assert!((a.single_random - b.single_random).abs() < 1e-6),
            (a, b) => prop_assert_eq!(a.map(|r| r.n), b.map(|r| r.n)),
        }
    }

    #[test]
    fn spearman_sees_order_only(values in prop::collection::vec((-20_i32..20, -20_i32..20), 4..30)) {
        let pairs: Vec<_> = values.iter().map(|(a, b)| (f64::from(*a), f64::from(*b))).collect();
        let bent: Vec<_> = pairs.iter().map(|(a, b)| (a.powi(3), b * 2.0 + 1.0)).collect();
        let mirrored: Vec<_> = pairs.iter().map(|(a, b)| (*a, -b)).collect();
        match (rank_correlation(&pairs), rank_correlation(&bent), rank_correlation(&mirrored)) {
            (Ok(a), Ok(b), Ok(c)) => {
                prop_assert!((a.value - b.value).abs() < ROUNDING && (a.value + c.value).abs() < ROUNDING);
                prop_assert!(a.low <= a.value && a.value <= a.high && a.low >= -1.0 && a.high <= 1.0);
            }
            (a, b, c) => prop_assert!(a.is_err() && b.is_err() && c.is_err()),
        }
    }

    #[test]
    fn quartiles_stand_in_order_and_within(values in prop::collection::vec(-1e6..1e6, 1..40)) {
        let five = summary(&values).unwrap();
        let order = [five.min, five.lower_quartile, five.median, five.upper_quartile, five.max];
        prop_assert!(order.is_sorted());
        prop_assert_eq!(five.n, values.len());
    }
}

#[test]
fn an_area_under_the_curve_is_that_of_scipys_rank_sum() {
    // scipy.stats.mannwhitneyu(a, b).statistic / 20; the ends are where (θ − 0.75)² = z²·V(θ), solved in Python.
    let area = area_under_curve(&[3.0, 5.0, 5.0, 7.0, 9.5], &[1.0, 5.0, 2.0, 6.0]).expect("two groups");
    close(area.value, 0.75);
    close(area.low, 0.366_587_038_706_379_65);
    close(area.high, 0.934_640_655_924_362);
    let [apart, alike] = [(&[2.0, 3.0], &[0.0, 1.0]), (&[1.0, 1.0], &[1.0, 1.0])]
        .map(|(above, below)| area_under_curve(above, below).expect("two groups"));
    close(apart.value, 1.0);
    close(alike.value, 0.5);
    assert!(apart.low < 0.6 && apart.high >= 1.0, "four values do not make an area of 1 certain: {apart:?}");
    assert_eq!(area_under_curve(&[1.0], &[1.0, 2.0]), Err(NotComputable::TooFew { found: 1, needed: 2 }));
}

#[test]
fn groups_that_cannot_be_compared_say_why() {
    let few = NotComputable::TooFew { found: 1, needed: 2 };
    assert_eq!(mann_whitney(&[1.0], &[1.0, 2.0]), Err(few));
    assert_eq!(hedges_g(&[1.0, 2.0], &[1.0]), Err(few));
    assert_eq!(mann_whitney(&[1.0, 1.0], &[1.0, 1.0]), Err(NotComputable::NoVariance));
    assert_eq!(hedges_g(&[1.0, 1.0], &[2.0, 2.0]), Err(NotComputable::NoVariance));
    assert_eq!(mann_whitney(&[1.0, f64::NAN], &[1.0, 2.0]), Err(NotComputable::OutOfRange));
    // Four of eight, the four largest: 1 of 70 ways on either side.
    let apart = mann_whitney(&[5.0, 6.0, 7.0, 8.0], &[1.0, 2.0, 3.0, 4.0]).expect("two groups");
    close(apart.u, 16.0);
    close(apart.p, 2.0 / 70.0);
    assert!(holm_adjusted(&[]).is_empty());
}

proptest! {
    #[test]
    fn exchanging_the_groups_mirrors_every_comparison(
        first in prop::collection::vec(0_i8..6, 2..12),
        second in prop::collection::vec(0_i8..6, 2..12),
    ) {
        let [first, second] = [first, second].map(|group| group.into_iter().map(f64::from).collect::<Vec<_>>());
        if let (Ok(a), Ok(b)) = (mann_whitney(&first, &second), mann_whitney(&second, &first)) {
            prop_assert!((a.p - b.p).abs() < 1e-12 && a.p > 0.0 && a.p <= 1.0);
            prop_assert!((a.u + b.u - (first.len() * second.len()) as f64).abs() < 1e-9);
        }
        if let (Ok(a), Ok(b)) = (hedges_g(&first, &second), hedges_g(&second, &first)) {
            prop_assert!((a.value + b.value).abs() < 1e-9 && (a.low + b.high).abs() < 1e-9);
        }
        if let (Ok(a), Ok(b)) = (area_under_curve(&first, &second), area_under_curve(&second, &first)) {
            prop_assert!((a.value + b.value - 1.0).abs() < 1e-9 && (a.low + b.high - 1.0).abs() < 1e-9);
            prop_assert!(a.low <= a.value && a.value <= a.high && a.low >= 0.0 && a.high <= 1.0);
        }
    }

    #[test]
    fn an_adjusted_probability_is_no_smaller_and_keeps_its_order(p in prop::collection::vec(0.0..=1.0, 1..12)) {
        let adjusted = holm_adjusted(&p);
        for (at, value) in adjusted.iter().enumerate() {
            prop_assert!(*value >= p[at] && *value <= 1.0);
            prop_assert!(p.iter().zip(&adjusted).all(|(other, theirs)| other > &p[at] || theirs <= value));
        }
    }
}
