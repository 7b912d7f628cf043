//! Thinned data keeps what it promises: every n-th sample, or every peak. It would fail where the last samples fall off
//! or a bucket forgets one.

use recording::{decimate, series};

use crate::support::{file, read, samples};

#[test]
fn decimation_keeps_every_nth_sample_and_all_else() {
    let recording = read(&file(1001));
    let slower = decimate(&recording, 4);
    assert_eq!(slower.samples.len(), 251);
    assert_eq!(slower.samples[250], recording.samples[1000]);
    assert_eq!(slower.session.tick_hz, 250.0);
    assert_eq!(slower.events, recording.events);
    assert_eq!(decimate(&recording, 0), recording);
}

#[test]
fn a_series_has_few_points_and_every_peak() {
    let all = samples(1003);
    for points in [1, 2, 100, 1003, 5000] {
        let buckets = series(&all, points);
        assert!(buckets.len() <= points);
        assert_eq!(buckets[0].t_s, all[0].t_s);
        assert!(buckets.is_sorted_by(|a, b| a.t_s < b.t_s));
        let peak = all.iter().map(|s| s.axial_n()).fold(f64::NEG_INFINITY, f64::max);
        assert_eq!(buckets.iter().map(|b| b.axial_max_n).fold(f64::NEG_INFINITY, f64::max), peak);
        let deepest = all.iter().map(|s| f64::from(s.depth_m)).fold(f64::INFINITY, f64::min);
        assert_eq!(buckets.iter().map(|b| b.depth_min_m).fold(f64::INFINITY, f64::min), deepest);
    }
    assert!(series(&[], 10).is_empty());
}
