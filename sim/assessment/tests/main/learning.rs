//! CUSUM and LC-CUSUM against published vectors, the limit against brute force, and the three states.
//! Fails when a weight, a line or a restart is wrong, or when the limit is that of an approximation.

use assessment::learning::{Crossing, Cusum, CusumParams, LcCusum, LcCusumParams, Rule, Standing, learning_curve};
use assessment::statistics::NotComputable;
use proptest::prelude::*;

const TENTH: CusumParams = CusumParams { p0: 0.10, p1: 0.20, alpha: 0.10, beta: 0.10 };
const FAIL: bool = true;

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-4, "{found} is not {expected}");
}

fn lc(p0: f64, delta: f64, within: u32) -> LcCusum {
    LcCusum::new(&LcCusumParams { p0, delta, within, probability: 0.05 }).expect("parameters that can be used")
}

#[test]
fn the_cusum_of_the_published_vector() {
    let cusum = Cusum::new(&TENTH).unwrap();
    close(cusum.s, 0.1452);
    assert!((cusum.h0 - 2.710).abs() < 5e-4 && (cusum.h1 - 2.710).abs() < 5e-4);
    assert_eq!(cusum.successes_needed(0.0), 19);
    let points = cusum.run(&[FAIL, false, false, FAIL, false, false, false, false]);
    for (point, expected) in points.iter().zip([0.8548, 0.7095, 0.5643, 1.4190, 1.2738, 1.1285, 0.9833, 0.8380]) {
        close(point.count, expected);
        assert_eq!(point.crossed, None);
    }
}

#[test]
fn nineteen_straight_successes_cross_and_the_count_restarts() {
    let cusum = Cusum::new(&TENTH).unwrap();
    let points = cusum.run(&[false; 20]);
    assert!(points[..18].iter().all(|p| p.crossed.is_none()));
    assert_eq!(points[18].crossed, Some(Crossing::Acceptable));
    close(points[19].count, -cusum.s);
    let fails = cusum.run(&[FAIL; 5]);
    assert_eq!(fails.iter().position(|p| p.crossed == Some(Crossing::Unacceptable)), Some(3));
    close(fails[4].count, 1.0 - cusum.s);
}

#[test]
fn the_limits_are_those_of_the_exact_chain() {
    close(lc(0.10, 0.10, 50).h, 2.8539);
    close(lc(0.10, 0.10, 100).h, 3.7055);
    close(lc(0.05, 0.05, 100).h, 2.7866);
    close(lc(0.20, 0.20, 50).h, 3.8962);
}

#[test]
fn the_lc_cusum_of_the_published_vector() {
    let lc = lc(0.10, 0.10, 50);
    let mut s = 0.0;
    for (failed, expected) in [(FAIL, 0.0), (false, 0.1178), (false, 0.2356), (FAIL, 0.0), (false, 0.1178)] {
        s = lc.step(s, failed);
        close(s, expected);
    }
}

/// P(max S ≥ h) over every sequence of `within` attempts, one by one.
fn by_counting(lc: &LcCusum, failure_rate: f64, within: u32) -> f64 {
    let probability = |sequence: u32| {
        let (mut s, mut p, mut reached) = (0.0, 1.0, false);
        for attempt in 0..within {
            let failed = sequence >> attempt & 1 == 1;
            p *= if failed { failure_rate } else { 1.0 - failure_rate };
            s = lc.step(s, failed);
            reached |= lc.competent(s);
        }
        if reached { p } else { 0.0 }
    };
    (0..1 << within).map(probability).sum()
}

#[test]
fn a_limit_keeps_its_promise_and_is_the_smallest_that_does() {
    for (p0, delta, within) in [(0.3, 0.4, 12), (0.2, 0.5, 10), (0.4, 0.3, 14)] {
        let params = LcCusumParams { p0, delta, within, probability: 0.05 };
        let lc = LcCusum::new(&params).unwrap();
        assert!(by_counting(&lc, p0 + delta, within) <= 0.05);
        let mut lower = Vec::new();
        for successes in 0..=within {
            let values =
                (0..=within - successes).map(|f| f64::from(successes) * lc.success + f64::from(f) * lc.failure);
            lower.extend(values.filter(|v| *v > 0.0 && *v < lc.h - 1e-6));
        }
        let below = lower.into_iter().fold(0.0, f64::max);
        assert!(by_counting(&LcCusum { h: below, ..lc }, p0 + delta, within) > 0.05, "{params:?}: {below} would do");
    }
}

#[test]
fn parameters_without_meaning_are_refused() {
    for wrong in [
        CusumParams { p0: 0.0, ..TENTH },
        CusumParams { p1: 0.1, ..TENTH },
        CusumParams { alpha: 0.5, beta: 0.5, ..TENTH },
        CusumParams { beta: f64::NAN, ..TENTH },
    ] {
        assert_eq!(Cusum::new(&wrong), Err(NotComputable::OutOfRange), "{wrong:?}");
    }
    let params = LcCusumParams { p0: 0.1, delta: 0.1, within: 50, probability: 0.05 };
    for wrong in [LcCusumParams { delta: 0.9, ..params }, LcCusumParams { within: 201, ..params }] {
        assert_eq!(LcCusum::new(&wrong), Err(NotComputable::OutOfRange), "{wrong:?}");
    }
    // Thirteen successes in a row are no rarer than 0.8¹³ = 5.5 %.
    let few = LcCusumParams { within: 13, ..params };
    assert_eq!(LcCusum::new(&few), Err(NotComputable::TooFew { found: 13, needed: 14 }));
    assert!(LcCusum::new(&LcCusumParams { within: 14, ..params }).is_ok());
}

#[test]
fn competence_is_declared_watched_lost_and_shown_again() {
    let rule = Rule::new(&CusumParams { alpha: 0.05, ..TENTH }, Some(50)).unwrap();
    let learning = rule.learning.unwrap();
    let needed = learning.successes_needed(0.0);
    assert_eq!(needed, 25);
    let mut failures = vec![false; 25];
    let declared = learning_curve(&rule, &failures);
    assert_eq!(
        (declared.standing, declared.competent_at, declared.successes_needed),
        (Standing::Competent, Some(24), 0)
    );
    failures.extend([FAIL; 5]);
    let lost = learning_curve(&rule, &failures);
    assert_eq!((lost.standing, lost.successes_needed), (Standing::Regressing, 25));
    assert_eq!(lost.points[29].crossed, Some(Crossing::Unacceptable));
    failures.extend([false; 25]);
    let again = learning_curve(&rule, &failures);
    assert_eq!((again.standing, again.competent_at), (Standing::Competent, Some(24)));
}

#[test]
fn failures_from_the_start_are_not_a_regression() {
    for within in [None, Some(50)] {
        let rule = Rule::new(&TENTH, within).unwrap();
        assert_eq!(learning_curve(&rule, &[FAIL; 30]).standing, Standing::NotYet);
    }
    assert_eq!(learning_curve(&Rule::new(&TENTH, None).unwrap(), &[]).successes_needed, 19);
}

proptest! {
    #[test]
    fn so_many_more_successes_and_not_one_fewer_make_competent(
        failures in prop::collection::vec(prop::bool::weighted(0.3), 0..60), learning in prop::bool::ANY
    ) {
        let rule = Rule::new(&CusumParams { p0: 0.2, p1: 0.4, alpha: 0.05, beta: 0.1 }, learning.then_some(50)).unwrap();
        let needed = learning_curve(&rule, &failures).successes_needed;
        let after = |successes: u32| {
            let more = std::iter::repeat_n(false, usize::try_from(successes).unwrap());
            learning_curve(&rule, &failures.iter().copied().chain(more).collect::<Vec<_>>()).standing
        };
        prop_assert_eq!(after(needed), Standing::Competent);
        if needed > 0 {
            prop_assert_ne!(after(needed - 1), Standing::Competent);
        }
    }
}
