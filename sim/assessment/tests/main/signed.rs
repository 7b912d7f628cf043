//! Every field of a recording is signed, or follows from what is signed and is compared, or judges nothing. Fails when a field can be
//! changed in a signed recording so that its signature holds, its re-simulation is the same to the bit, and it is judged otherwise; and
//! does not compile when a field is added without an answer.

use std::path::Path;

use assessment::{AssessError, Assessment, Tryout, assess};
use attempt::verify::verify_recording;
use documents::{ExerciseBundle, Patient};
use law::Judging;
use law::axial::ForceLaw;
use law::ledger::{LayerEnergy, Ledger};
use law::operator::{Operator, Skill};
use recording::sample::{Energy, flags};
use recording::signature::signed_statement;
use recording::{Event, EventKind, Follows, Recording, Sample, Session, Signature, Tent};
use tissue::Specimen;
use uuid::Uuid;

/// Why a change of a field is no forgery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Guard {
    /// The signature does not hold.
    Signed,
    /// The re-simulation differs.
    Recomputed,
    /// The attempt is judged as before.
    Unused,
}

use Guard::{Recomputed, Signed, Unused};

type Change = (&'static str, Guard, fn(&mut Recording));

/// A signed attempt that is scored by its energies, too.
struct Judged {
    bundle: ExerciseBundle,
    recording: Recording,
    specimen: Specimen,
}

fn attempt() -> Judged {
    let file = "../../curricula/lower-back-basics/3-reach-the-muscle.toml";
    let bundle = ExerciseBundle::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).expect("a shipped exercise");
    assert!(bundle.exercise.rubric.iter().any(|line| line.metric == "lateral_work_mj"), "its energies are scored");
    let patient = Patient::draw(&bundle.scene, 3);
    let specimen = Specimen::new(bundle.specimen_spec(&patient)).expect("a sound specimen");
    let mut recording = Tryout::new(&bundle, patient)
        .expect("a shipped scene is sound")
        .perform(&mut Operator::skilled(&Skill::novice(), &bundle.plan(), 3));
    recording.signature = Some(Signature { station: Uuid::from_u128(7), ed25519: String::new() });
    // A device has clipped its force for the last half of it, and not so long that it is void.
    let half = recording.samples.len() / 2;
    recording.samples[half..].iter_mut().for_each(|sample| sample.flags |= flags::SCALED);
    Judged { bundle, recording, specimen }
}

fn statement(recording: &Recording) -> Vec<u8> {
    signed_statement(&recording.session, Uuid::from_u128(7), &recording.hashes())
}

/// What becomes of it: metrics and score without the program's version, which pages show and nothing computes with.
fn outcome(recording: &Recording, bundle: &ExerciseBundle) -> Result<Assessment, AssessError> {
    assess(recording, bundle).map(|assessment| Assessment { simulator_version: String::new(), ..assessment })
}

fn changes() -> Vec<Change> {
    [of_the_session(), of_the_samples(), of_the_events(), of_the_energies(), of_the_tents(), of_the_file()].concat()
}

/// Without `..`, as all of these.
fn of_the_session() -> Vec<Change> {
    let _ = |session: Session| {
        let Session {
            session_id: _,
            exercise_id: _,
            exercise_sha256: _,
            scene_sha256: _,
            simulator_version: _,
            git: _,
            device: _,
            device_max_force_n: _,
            law: _,
            judging: _,
            tick_hz: _,
            seed: _,
            trainee: _,
            started_at: _,
            patient_thickness_mm: _,
        } = session;
    };
    vec![
        ("session_id", Signed, |r| r.session.session_id = Uuid::from_u128(9)),
        ("exercise_id", Signed, |r| r.session.exercise_id.push('x')),
        ("exercise_sha256", Signed, |r| r.session.exercise_sha256.push('x')),
        ("scene_sha256", Signed, |r| r.session.scene_sha256.push('x')),
        ("simulator_version", Signed, |r| r.session.simulator_version.push('x')),
        ("git", Signed, |r| r.session.git.push('x')),
        ("device", Signed, |r| r.session.device.push('x')),
        ("device_max_force_n", Signed, |r| r.session.device_max_force_n = 3.3),
        ("law", Signed, |r| r.session.law = ForceLaw::Version1),
        ("field", Signed, |r| r.session.judging = Judging::First),
        ("tick_hz", Signed, |r| r.session.tick_hz = 999.0),
        ("seed", Signed, |r| r.session.seed += 1),
        ("trainee", Signed, |r| r.session.trainee.push('x')),
        ("started_at", Signed, |r| r.session.started_at += std::time::Duration::from_nanos(1)),
        ("patient_thickness_mm", Signed, |r| r.session.patient_thickness_mm[0] *= 1.0 + 1e-15),
    ]
}

/// A moment at which the needle is in the body.
fn inside(recording: &mut Recording) -> &mut Sample {
    let found = recording.samples.iter_mut().find(|sample| sample.flags & flags::INSIDE != 0);
    found.expect("it goes into the body")
}

fn of_the_samples() -> Vec<Change> {
    let _ = |sample: Sample| {
        let Sample {
            t_s: _,
            position_m: _,
            orientation: _,
            velocity_m_per_s: _,
            x_m: _,
            depth_m: _,
            force_n: _,
            tip_n: _,
            rim_n: _,
            viscous_n: _,
            friction_n: _,
            cutting_n: _,
            lateral_n: _,
            device_n: _,
            flags: _,
            lateness_us: _,
            bend_m: _,
        } = sample;
    };
    vec![
        ("t_s", Signed, |r| inside(r).t_s += 1e-9),
        ("position_m", Signed, |r| inside(r).position_m[2] += 1e-12),
        ("orientation", Signed, |r| inside(r).orientation.swap(0, 1)),
        ("velocity_m_per_s", Unused, |r| inside(r).velocity_m_per_s = [9.0; 3]),
        ("x_m", Recomputed, |r| inside(r).x_m += 1e-3),
        ("depth_m", Recomputed, |r| inside(r).depth_m += 1e-3),
        ("force_n", Recomputed, |r| inside(r).force_n[2] += 1.0),
        ("tip_n", Recomputed, |r| inside(r).tip_n += 1.0),
        ("rim_n", Recomputed, |r| inside(r).rim_n += 1.0),
        ("viscous_n", Recomputed, |r| inside(r).viscous_n += 1.0),
        ("friction_n", Recomputed, |r| inside(r).friction_n += 1.0),
        ("cutting_n", Recomputed, |r| inside(r).cutting_n += 1.0),
        ("lateral_n", Recomputed, |r| inside(r).lateral_n[0] += 1.0),
        // Where a device takes any force; elsewhere it is what the device was given, and judges nothing.
        ("device_n", Recomputed, |r| inside(r).device_n[0] += 1.0),
        ("flags INSIDE", Signed, |r| inside(r).flags ^= flags::INSIDE),
        ("flags HELD", Signed, |r| inside(r).flags ^= flags::HELD),
        ("flags CONFIRM", Signed, |r| inside(r).flags ^= flags::CONFIRM),
        ("flags SCALED", Signed, |r| inside(r).flags ^= flags::SCALED),
        ("flags UNFELT", Signed, |r| r.samples.iter_mut().for_each(|sample| sample.flags |= flags::UNFELT)),
        ("lateness_us", Unused, |r| inside(r).lateness_us = 9.0),
        ("bend_m", Recomputed, |r| inside(r).bend_m[0] += 1e-3),
        ("the last sample", Signed, |r| r.samples.truncate(r.samples.len() - 1)),
    ]
}

fn note(recording: &mut Recording, kind: EventKind) {
    let last = recording.events.last().expect("it has events").clone();
    recording.events.push(Event { kind, text: "device lost".to_owned(), ..last });
}

fn rupture(recording: &mut Recording) -> &mut Event {
    recording.events.iter_mut().find(|event| event.kind.contactor().is_some()).expect("a boundary is punctured")
}

fn of_the_events() -> Vec<Change> {
    let _ = |event: Event| {
        let Event {
            t_s: _,
            kind: _,
            boundary: _,
            x_m: _,
            position_m: _,
            force_n: _,
            dissipated_j: _,
            track: _,
            structure: _,
            text: _,
        } = event;
    };
    let _ = |kind: EventKind| match kind {
        EventKind::Contact
        | EventKind::TipRupture
        | EventKind::RimRupture
        | EventKind::StructureHit
        | EventKind::HubContact
        | EventKind::SkinExit
        | EventKind::Confirm
        | EventKind::Coaching
        | EventKind::Fault
        | EventKind::Interrupted => (),
    };
    vec![
        ("t_s of an event", Recomputed, |r| rupture(r).t_s += 1e-6),
        ("kind", Recomputed, |r| rupture(r).kind = EventKind::StructureHit),
        ("boundary", Recomputed, |r| rupture(r).boundary = Some(0x7FFF)),
        ("x_m of an event", Recomputed, |r| rupture(r).x_m += 1e-6),
        ("position_m of an event", Recomputed, |r| rupture(r).position_m[0] += 1e-6),
        ("force_n of an event", Recomputed, |r| rupture(r).force_n += 1e-6),
        ("dissipated_j", Recomputed, |r| rupture(r).dissipated_j *= 2.0),
        ("track", Recomputed, |r| rupture(r).track = Some(5)),
        ("structure", Recomputed, |r| rupture(r).structure = Some(5)),
        ("text", Recomputed, |r| rupture(r).text.push('x')),
        ("a contact more", Recomputed, |r| note(r, EventKind::Contact)),
        ("a rupture more", Recomputed, |r| note(r, EventKind::TipRupture)),
        ("a rupture of the rim more", Recomputed, |r| note(r, EventKind::RimRupture)),
        ("a hit more", Recomputed, |r| note(r, EventKind::StructureHit)),
        ("a contact of the hub more", Recomputed, |r| note(r, EventKind::HubContact)),
        ("an exit more", Recomputed, |r| note(r, EventKind::SkinExit)),
        ("a confirmation more", Recomputed, |r| note(r, EventKind::Confirm)),
        ("a coaching more", Unused, |r| note(r, EventKind::Coaching)),
        ("a fault more", Unused, |r| note(r, EventKind::Fault)),
        ("an interruption more", Signed, |r| note(r, EventKind::Interrupted)),
        ("an event less", Recomputed, |r| drop(r.events.remove(0))),
    ]
}

fn last(recording: &mut Recording) -> &mut Ledger {
    &mut recording.energies.last_mut().expect("a ledger").ledger
}

fn of_the_energies() -> Vec<Change> {
    let _ = |energy: Energy| {
        let Energy { t_s: _, ledger } = energy;
        let Ledger { input_j: _, returned_j: _, presliding_j: _, lagged_j: _, layers } = ledger;
        layers.into_iter().for_each(|layer| {
            let LayerEnergy { elastic_j: _, rupture_j: _, viscous_j: _, friction_j: _, cutting_j: _, lateral_j: _ } =
                layer;
        });
    };
    vec![
        ("t_s of a ledger", Recomputed, |r| r.energies[0].t_s += 1e-9),
        ("input_j", Unused, |r| last(r).input_j += 1.0),
        ("returned_j", Unused, |r| last(r).returned_j += 1.0),
        ("presliding_j", Unused, |r| last(r).presliding_j += 1.0),
        ("lagged_j", Unused, |r| last(r).lagged_j += 1.0),
        ("elastic_j", Recomputed, |r| last(r).layers[0].elastic_j += 1.0),
        ("rupture_j", Recomputed, |r| last(r).layers[0].rupture_j += 1.0),
        ("viscous_j", Recomputed, |r| last(r).layers[0].viscous_j += 1.0),
        ("friction_j", Recomputed, |r| last(r).layers[0].friction_j += 1.0),
        ("cutting_j", Recomputed, |r| last(r).layers[0].cutting_j += 1.0),
        ("lateral_j", Recomputed, |r| last(r).layers[0].lateral_j = 0.0),
        ("a layer less", Recomputed, |r| last(r).layers.truncate(1)),
        ("the last ledger", Recomputed, |r| drop(r.energies.pop())),
        ("every ledger", Recomputed, |r| r.energies.clear()),
    ]
}

fn put_tent(recording: &mut Recording) {
    let t_s = recording.samples[0].t_s;
    recording.tents.push(Tent {
        t_s,
        tent_m: vec![0.01],
        contactor_n: vec![1.0],
        drag_n: vec![1.0],
        ..Tent::default()
    });
}

fn of_the_tents() -> Vec<Change> {
    let _ = |tent: Tent| {
        let Tent { t_s: _, tent_m: _, contactor_n: _, drag_n: _, linear_n: _, follows } = tent;
        match follows {
            Follows::Forces | Follows::Needle | Follows::Secant => (),
        }
    };
    // This scene has no field; that of one that has is compared step by step in `attempt`. A file without tents is older than they are,
    // and nothing is judged by them.
    vec![("a tent more", Recomputed, put_tent), ("every tent", Unused, |r| r.tents.clear())]
}

fn of_the_file() -> Vec<Change> {
    let _ = |recording: Recording| {
        let Recording {
            session: _,
            attachments: _,
            samples: _,
            events: _,
            energies: _,
            tents: _,
            fluoroscopy: _,
            signature: _,
            complete: _,
        } = recording;
    };
    vec![
        // The published revision judges, whose documents the signed hashes name.
        ("attachments", Unused, |r| r.attachments.clear()),
        ("complete", Unused, |r| r.complete = false),
    ]
}

#[test]
fn every_field_is_signed_or_recomputed_or_judges_nothing() {
    let Judged { bundle, recording, specimen } = attempt();
    let (signed, judged) = (statement(&recording), outcome(&recording, &bundle).expect("it is judged"));
    assert!(verify_recording(&recording, &specimen).exact(), "nothing was changed yet");
    for (field, guard, change) in changes() {
        let mut changed = recording.clone();
        change(&mut changed);
        let holds = statement(&changed) == signed;
        let found = if !holds {
            Signed
        } else if !verify_recording(&changed, &specimen).exact() {
            Recomputed
        } else {
            let again = outcome(&changed, &bundle);
            assert_eq!(again.as_ref().ok(), Some(&judged), "{field}: judged otherwise, and nothing tells");
            Unused
        };
        assert_eq!(found, guard, "{field}");
    }
}
