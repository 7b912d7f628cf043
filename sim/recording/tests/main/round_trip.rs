//! What is written is what is read. It would fail where a field is forgotten in a conversion, a number passes through
//! fewer bits than it has, or text loses a digit.

use proptest::prelude::*;
use recording::{Event, EventKind, Recording, Sample, Session, Writer};
use time::macros::datetime;

use crate::support::{attachments, drawing, energy, file, read, rupture, samples, session, writer};

#[test]
fn everything_returns() {
    let recording = read(&file(2500));
    assert_eq!(recording.session, session());
    assert_eq!(recording.attachments, attachments());
    assert_eq!(recording.samples, samples(2500));
    assert_eq!(recording.events, [rupture(1.25)]);
    assert_eq!(recording.energies, [energy(1.25)]);
    assert!(recording.complete);
    assert_eq!(recording.attachment("scene.toml"), Some(&[0, 159, 146, 150][..]));
    assert_eq!(recording.attachment("mesh/rib.stl"), None);
}

#[test]
fn a_file_without_samples_reads_as_an_empty_list() {
    let recording = read(&writer().finish().unwrap());
    assert_eq!(recording.samples, []);
    assert!(recording.complete);
}

#[test]
fn one_sample_is_enough() {
    let recording = read(&file(1));
    assert_eq!(recording.samples, samples(1));
    assert!(recording.complete);
}

fn through_metadata(session: &Session) -> Session {
    let writer = Writer::create(Vec::new(), session, &attachments(), &drawing()).unwrap();
    read(&writer.finish().unwrap()).session
}

#[test]
fn a_start_in_another_zone_is_the_same_moment() {
    let started_at = datetime!(2031-05-06 07:08:09.123456789 +05:45);
    let returned = through_metadata(&Session { started_at, ..session() });
    assert_eq!(returned.started_at, started_at);
    assert!(returned.started_at.offset().is_utc());
}

#[test]
fn what_a_file_cannot_hold_is_refused_in_words() {
    let refused = |session: Session| {
        let result = Writer::create(Vec::new(), &session, &attachments(), &drawing());
        result.map(|_| ()).unwrap_err().to_string()
    };
    let early = refused(Session { started_at: datetime!(1969-12-31 23:59:59 UTC), ..session() });
    assert!(early.contains("started_at") && early.contains("1970"), "{early}");
    let still = refused(Session { tick_hz: 0.0, ..session() });
    assert!(still.contains("tick_hz = 0") && still.contains("Hz"), "{still}");
    let mut heavy = attachments();
    heavy[1].data = vec![0; (32 << 20) + 1];
    let heavy = Writer::create(Vec::new(), &session(), &heavy, &drawing()).map(|_| ()).unwrap_err().to_string();
    assert!(heavy.contains("attachment scene.toml") && heavy.contains("32 MiB"), "{heavy}");
}

prop_compose! {
    fn any_vector()(v in any::<[f64; 3]>()) -> [f64; 3] { v }
}

prop_compose! {
    fn any_sample()(
        position_m in any_vector(),
        orientation in any::<[f64; 4]>(),
        x_m in any::<f64>(),
        vectors in any::<[[f32; 3]; 5]>(),
        scalars in any::<[f32; 7]>(),
        flags in any::<u32>(),
    ) -> Sample {
        let [velocity_m_per_s, force_n, lateral_n, device_n, bend_m] = vectors;
        let [depth_m, tip_n, rim_n, viscous_n, friction_n, cutting_n, lateness_us] = scalars;
        Sample {
            t_s: 0.0, position_m, orientation, velocity_m_per_s, x_m, depth_m, force_n, tip_n, rim_n, viscous_n,
            friction_n, cutting_n, lateral_n, device_n, flags, lateness_us, bend_m,
        }
    }
}

const KINDS: [EventKind; 10] = [
    EventKind::Contact,
    EventKind::TipRupture,
    EventKind::RimRupture,
    EventKind::StructureHit,
    EventKind::HubContact,
    EventKind::SkinExit,
    EventKind::Confirm,
    EventKind::Coaching,
    EventKind::Fault,
    EventKind::Interrupted,
];

prop_compose! {
    fn any_event()(
        kind in prop::sample::select(&KINDS),
        t_s in 0.0..1e6,
        numbers in any::<[f64; 3]>(),
        position_m in any_vector(),
        indices in any::<[Option<u32>; 3]>(),
        text in ".{0,400}",
    ) -> Event {
        let [x_m, force_n, dissipated_j] = numbers;
        let [boundary, track, structure] = indices;
        Event { t_s, kind, boundary, x_m, position_m, force_n, dissipated_j, track, structure, text }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_sample_returns(mut samples in prop::collection::vec(any_sample(), 1..20), step in 1e-9..1e3) {
        for (n, sample) in samples.iter_mut().enumerate() {
            sample.t_s = n as f64 * step;
        }
        let mut writer = writer();
        for sample in &samples {
            writer.sample(sample).unwrap();
        }
        prop_assert_eq!(Recording::read(writer.finish().unwrap().as_slice()).unwrap().samples, samples);
    }

    #[test]
    fn any_event_returns(events in prop::collection::vec(any_event(), 1..20)) {
        let mut writer = writer();
        for event in &events {
            writer.event(event).unwrap();
        }
        prop_assert_eq!(Recording::read(writer.finish().unwrap().as_slice()).unwrap().events, events);
    }

    #[test]
    fn any_session_returns(
        words in prop::array::uniform4("\\PC{0,60}"),
        seed in any::<u64>(),
        tick_hz in 1e-300..1e300,
        device_max_force_n in prop_oneof![0.0..1e300, Just(f64::INFINITY)],
        patient_thickness_mm in prop::collection::vec(0.0..1e3, 0..6),
    ) {
        let [exercise_id, device, trainee, git] = words;
        let session = Session {
            exercise_id, device, trainee, git, seed, tick_hz, device_max_force_n, patient_thickness_mm, ..session()
        };
        prop_assert_eq!(through_metadata(&session), session);
    }
}

#[test]
fn a_number_that_is_none_returns_as_it_was() {
    let mut writer = writer();
    let odd = Sample { x_m: f64::NAN, position_m: [f64::INFINITY, f64::NEG_INFINITY, f64::NAN], ..Sample::default() };
    writer.sample(&odd).unwrap();
    let back = read(&writer.finish().unwrap()).samples[0];
    assert_eq!(back.x_m.to_bits(), odd.x_m.to_bits());
    assert_eq!(back.position_m.map(f64::to_bits), odd.position_m.map(f64::to_bits));
}
