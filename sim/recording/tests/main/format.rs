//! The file as other programs expect it: profile, topics, schemas, rates, order and times. It would fail where a viewer
//! or a script that keeps to the contract no longer finds what it looks for.

use std::collections::{BTreeMap, BTreeSet};

use data_encoding::HEXLOWER;
use law::structures::Shape;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use nalgebra::{Point3, Vector3};
use prost::Message;
use recording::{Event, Writer};
use sha2::{Digest, Sha256};

use crate::foxglove::{FrameTransforms, Log, PoseInFrame, SceneEntity, SceneUpdate, log};
use crate::support::{attachments, drawing, file, rupture, sample, session, writer};

/// Every record of a file in order, chunks whole.
pub fn records(bytes: &[u8]) -> Vec<Record<'static>> {
    let mut reader = LinearReader::new_with_options(LinearReaderOptions::default().with_emit_chunks(true));
    reader.insert(bytes.len()).copy_from_slice(bytes);
    reader.notify_read(bytes.len());
    let mut found = Vec::new();
    while let Some(event) = reader.next_event() {
        match event.unwrap() {
            LinearReadEvent::Record { opcode, data } => {
                found.push(mcap::parse_record(opcode, data).unwrap().into_owned());
            }
            LinearReadEvent::ReadRequest(_) => panic!("a whole file wants more bytes"),
        }
    }
    found
}

/// The messages of a topic: log time in ns after the start, and content.
fn messages(bytes: &[u8], topic: &str) -> Vec<(u64, Vec<u8>)> {
    let start = u64::try_from(session().started_at.unix_timestamp_nanos()).unwrap();
    mcap::MessageStream::new(bytes)
        .unwrap()
        .map(Result::unwrap)
        .filter(|m| m.channel.topic == topic)
        .map(|m| (m.log_time - start, m.data.to_vec()))
        .collect()
}

#[test]
fn topics_have_the_schemas_of_the_contract() {
    let summary = mcap::Summary::read(&file(10)).unwrap().unwrap();
    let found: BTreeMap<_, _> = summary
        .channels
        .values()
        .map(|c| (c.topic.as_str(), (c.schema.as_ref().unwrap().name.as_str(), c.message_encoding.as_str())))
        .collect();
    let expected = [
        ("/needle/sample", "stylet.NeedleSample"),
        ("/needle/summary", "stylet.NeedleSummary"),
        ("/needle/pose", "foxglove.PoseInFrame"),
        ("/needle/energy", "stylet.EnergyLedger"),
        ("/tf", "foxglove.FrameTransforms"),
        ("/scene", "foxglove.SceneUpdate"),
        ("/events", "stylet.Event"),
        ("/log", "foxglove.Log"),
    ];
    assert_eq!(found, expected.map(|(topic, schema)| (topic, (schema, "protobuf"))).into());
    for schema in summary.schemas.values() {
        assert_eq!(schema.encoding, "protobuf");
        assert!(!schema.data.is_empty(), "{} has no descriptors", schema.name);
    }
}

/// The schemas that viewers know, byte by byte as the crate foxglove 0.30.3 gave them: SHA-256.
const VIEWERS_SCHEMAS: [(&str, &str); 4] = [
    ("foxglove.FrameTransforms", "3833358365a105d961c08f949dd1f1d11a79b944856e209fd1aa7bbfe3eecd84"),
    ("foxglove.Log", "5dfc92a009d203622d302ecc5bf24b99fc49b1917dbaf6adf9f02ae81878f648"),
    ("foxglove.PoseInFrame", "e098476322ae4b09d302282a84bd680bf7b857f5ce73e6842f0eda3684c24efc"),
    ("foxglove.SceneUpdate", "554b56b84b93d7e7af70af415a6bfd74ca23203ba3e6e6c1cc6557269808560e"),
];

#[test]
fn the_schemas_of_viewers_are_theirs_byte_by_byte() {
    let summary = mcap::Summary::read(&file(10)).unwrap().unwrap();
    let found: BTreeMap<&str, String> = summary
        .schemas
        .values()
        .filter(|schema| schema.name.starts_with("foxglove."))
        .map(|schema| (schema.name.as_str(), HEXLOWER.encode(&Sha256::digest(&schema.data))))
        .collect();
    assert_eq!(found, VIEWERS_SCHEMAS.map(|(name, hash)| (name, hash.to_owned())).into());
}

#[test]
fn the_file_begins_with_what_a_cut_must_not_take() {
    let bytes = file(3000);
    let records = records(&bytes);
    match &records[..5] {
        [
            Record::Header(header),
            Record::Metadata(metadata),
            Record::Attachment { header: exercise, .. },
            Record::Attachment { header: scene, .. },
            Record::Chunk { .. },
        ] => {
            assert_eq!(header.profile, "stylet");
            assert_eq!(metadata.name, "stylet.session");
            assert_eq!((exercise.name.as_str(), scene.name.as_str()), ("exercise.toml", "scene.toml"));
        }
        other => panic!("{other:?}"),
    }
    for record in &records {
        match record {
            Record::Chunk { header, .. } => {
                assert_eq!(header.compression, "zstd");
                assert!(header.message_end_time - header.message_start_time < 500_000_000);
            }
            Record::Message { .. } => panic!("a message outside the chunks"),
            _ => {}
        }
    }
}

#[test]
fn metadata_has_the_keys_of_the_contract() {
    let metadata = records(&file(1)).into_iter().find_map(|record| match record {
        Record::Metadata(metadata) => Some(metadata.metadata),
        _ => None,
    });
    let keys: BTreeSet<String> = metadata.unwrap().into_keys().collect();
    let expected = [
        "session_id",
        "exercise_id",
        "exercise_sha256",
        "scene_sha256",
        "simulator_version",
        "git",
        "device",
        "device_max_force_n",
        "law",
        "field",
        "tick_hz",
        "seed",
        "trainee",
        "started_at",
        "patient_thickness_mm",
    ];
    assert_eq!(keys, expected.map(str::to_owned).into());
}

#[test]
fn everything_is_indexed() {
    let bytes = file(3000);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let stats = summary.stats.unwrap();
    let chunks = records(&bytes).iter().filter(|r| r.opcode() == op::CHUNK).count();
    assert_eq!(summary.chunk_indexes.len(), chunks);
    assert!(summary.chunk_indexes.iter().all(|index| index.message_index_length > 0));
    assert_eq!(summary.attachment_indexes.len(), 2);
    assert_eq!(summary.metadata_indexes.len(), 1);
    assert_eq!(stats.message_count, mcap::MessageStream::new(&bytes).unwrap().count() as u64);
}

#[test]
fn rates_are_those_of_the_contract() {
    let bytes = file(10_000);
    let count = |topic| messages(&bytes, topic).len();
    assert_eq!(count("/needle/sample"), 10_000);
    assert_eq!(count("/needle/summary"), 1_000);
    assert_eq!(count("/needle/pose"), 600);
    assert_eq!(count("/tf"), 600);
    assert_eq!(count("/scene"), 10);
    assert_eq!(count("/events"), 1);
    assert_eq!(count("/log"), 1);
}

#[test]
fn log_time_is_the_start_plus_the_tick() {
    let bytes = file(2000);
    for (n, (log_ns, _)) in messages(&bytes, "/needle/sample").into_iter().enumerate() {
        assert_eq!(log_ns, n as u64 * 1_000_000);
    }
    for topic in ["/needle/summary", "/needle/pose", "/tf", "/scene"] {
        let times: Vec<u64> = messages(&bytes, topic).into_iter().map(|(log_ns, _)| log_ns).collect();
        assert!(times.is_sorted(), "{topic} goes back in time");
    }
}

/// The part of `stylet.NeedleSummary` that the next test looks at, declared a second time so that a changed field
/// number is noticed.
#[derive(Clone, PartialEq, Message)]
struct Summary {
    #[prost(double, tag = "1")]
    t_s: f64,
    #[prost(uint32, tag = "2")]
    ticks: u32,
    #[prost(message, optional, tag = "3")]
    axial_n: Option<Range>,
    #[prost(message, optional, tag = "5")]
    speed_m_per_s: Option<Range>,
}

#[derive(Clone, PartialEq, Message)]
struct Range {
    #[prost(float, tag = "1")]
    min: f32,
    #[prost(float, tag = "2")]
    max: f32,
    #[prost(float, tag = "3")]
    mean: f32,
}

fn range(values: &[f64]) -> Range {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Range { min: low as f32, max: high as f32, mean: (values.iter().sum::<f64>() / values.len() as f64) as f32 }
}

#[test]
fn a_summary_is_the_range_of_its_ten_milliseconds() {
    let summaries = messages(&file(995), "/needle/summary");
    assert_eq!(summaries.len(), 100);
    for (window, (_, data)) in (0..).zip(summaries) {
        let ticks = if window == 99 { 5 } else { 10 };
        let samples: Vec<_> = (10 * window..10 * window + ticks).map(sample).collect();
        let axial: Vec<f64> = samples.iter().map(|s| s.axial_n()).collect();
        let speed = samples.iter().map(|s| s.velocity_m_per_s.map(f64::from).iter().map(|v| v * v).sum::<f64>().sqrt());
        let expected = Summary {
            t_s: samples[0].t_s,
            ticks: u32::try_from(ticks).unwrap(),
            axial_n: Some(range(&axial)),
            speed_m_per_s: Some(range(&speed.collect::<Vec<_>>())),
        };
        assert_eq!(Summary::decode(data.as_slice()).unwrap(), expected);
    }
}

/// A viewer that jumps back drops every frame and gets one message of each topic, the last before that moment. Frames that lay
/// in two messages would leave it without the world or without the needle.
#[test]
fn every_message_of_frames_holds_the_whole_tree() {
    let bytes = file(3000);
    let messages = messages(&bytes, "/tf");
    assert_eq!(messages[0].0, 0, "frames are there from the first tick");
    for (log_ns, data) in messages {
        let transforms = FrameTransforms::decode(data.as_slice()).unwrap().transforms;
        let frames: Vec<_> =
            transforms.iter().map(|t| (t.parent_frame_id.as_str(), t.child_frame_id.as_str())).collect();
        assert_eq!(frames, [("world", "patient"), ("patient", "needle")]);
        let origin = transforms[0].translation.unwrap();
        assert_eq!([origin.x, origin.y, origin.z], [0.0; 3], "the patient lies at the world's origin");
        let found = transforms[1].translation.unwrap();
        assert_eq!(
            [found.x, found.y, found.z],
            sample(log_ns / 1_000_000).position_m,
            "the needle moves with its frame"
        );
    }
}

#[test]
fn a_pose_is_that_of_its_tick() {
    let (log_ns, data) = messages(&file(3000), "/needle/pose").swap_remove(7);
    let pose = PoseInFrame::decode(data.as_slice()).unwrap();
    let expected = sample(log_ns / 1_000_000).position_m;
    let found = pose.pose.unwrap().position.unwrap();
    assert_eq!((pose.frame_id.as_str(), [found.x, found.y, found.z]), ("patient", expected));
}

#[test]
fn what_is_drawn_can_be_seen_and_stays() {
    let bytes = file(3000);
    let first = mcap::MessageStream::new(&bytes).unwrap().next().unwrap().unwrap();
    assert_eq!(first.channel.topic, "/scene", "before anything else");
    let scenes = messages(&bytes, "/scene");
    assert_eq!(scenes.iter().map(|(log_ns, _)| *log_ns).collect::<Vec<_>>(), [0, 1_000_000_000, 2_000_000_000]);
    for entity in SceneUpdate::decode(scenes[0].1.as_slice()).unwrap().entities {
        let frame = if entity.id == "needle" { "needle" } else { "patient" };
        assert_eq!(entity.frame_id, frame, "{}", entity.id);
        assert!(entity.frame_locked && entity.lifetime.is_none(), "{} follows its frame for good", entity.id);
        let cubes = entity.cubes.iter().map(|c| (c.color.unwrap().a, c.size.unwrap()));
        for (alpha, size) in cubes {
            assert!(alpha > 0.1 && size.x.min(size.y).min(size.z) > 0.0, "{}: {alpha}, {size:?}", entity.id);
        }
    }
}

#[test]
fn neighbouring_layers_differ_in_colour() {
    let mut drawing = drawing();
    drawing.layers = (0..9).map(|i| (format!("{i}"), 0.01)).collect();
    let writer = Writer::create(Vec::new(), &session(), &attachments(), &drawing).unwrap();
    let (_, data) = messages(&writer.finish().unwrap(), "/scene").swap_remove(0);
    let entities = SceneUpdate::decode(data.as_slice()).unwrap().entities;
    let colours: Vec<_> = entities[1..10].iter().map(|e| e.cubes[0].color.unwrap()).collect();
    for pair in colours.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let apart = (a.r - b.r).abs() + (a.g - b.g).abs() + (a.b - b.b).abs();
        assert!(apart > 0.3, "{a:?} and {b:?}");
    }
}

#[test]
fn the_scene_shows_layers_structures_and_needle() {
    let (_, data) = messages(&file(1), "/scene").swap_remove(0);
    let entities = SceneUpdate::decode(data.as_slice()).unwrap().entities;
    let ids: Vec<&str> = entities.iter().map(|e| e.id.as_str()).collect();
    let layers = ["layer 0: skin", "layer 1: fascia", "layer 2: muscle"];
    let structures = ["structure 0: cyst", "structure 1: artery", "structure 2: rib", "structure 3: spleen"];
    assert_eq!(ids, [&["needle"][..], &layers, &structures].concat());
    // The muscle begins under the skin and ends at its own thickness; the fascia takes no room.
    let muscle = &entities[3].cubes[0];
    let (centre, size) = (muscle.pose.unwrap().position.unwrap().z, muscle.size.unwrap().z);
    assert!((centre + 0.5 * size + 0.0008).abs() < 1e-12);
    assert!((centre - 0.5 * size + 0.0398).abs() < 1e-12);
    let drawn = |e: &SceneEntity| e.cubes.len() + e.spheres.len() + e.cylinders.len() + e.triangles.len();
    assert_eq!(entities.iter().map(drawn).collect::<Vec<_>>(), [1, 1, 1, 1, 1, 3, 1, 1]);
    assert_eq!(drawing().structures.len(), 4);
}

#[test]
fn a_large_mesh_is_drawn_as_its_bounding_box() {
    let vertices_m = vec![Point3::new(-0.01, 0.0, 0.0), Point3::new(0.03, 0.02, 0.0), Point3::new(0.0, 0.0, 0.05)];
    let mut drawing = drawing();
    drawing.structures.truncate(1);
    drawing.structures[0].shape = Shape::Mesh { vertices_m, triangles: vec![[0, 1, 2]; 2001] };
    let writer = Writer::create(Vec::new(), &session(), &attachments(), &drawing).unwrap();
    let (_, data) = messages(&writer.finish().unwrap(), "/scene").swap_remove(0);
    let entity = SceneUpdate::decode(data.as_slice()).unwrap().entities.pop().unwrap();
    assert!(entity.triangles.is_empty());
    let (centre, size) = (entity.cubes[0].pose.unwrap().position.unwrap(), entity.cubes[0].size.unwrap());
    let expected = drawing.structures[0].position_m + Vector3::new(0.01, 0.01, 0.025);
    assert!((Point3::new(centre.x, centre.y, centre.z) - expected).norm() < 1e-15);
    assert!((Vector3::new(size.x, size.y, size.z) - Vector3::new(0.04, 0.02, 0.05)).norm() < 1e-15);
}

#[test]
fn a_minute_of_noise_stays_under_twelve_megabytes() {
    // Every channel trembles in its last bit, which is the worst that a real attempt could come to.
    let bytes = file(60_000).len();
    assert!(bytes < 12_000_000, "{bytes} bytes");
}

#[test]
fn an_event_also_reads_as_a_line_of_the_log() {
    let mut writer = writer();
    writer.event(&rupture(0.25)).unwrap();
    writer.event(&Event { kind: recording::EventKind::Fault, text: "device lost".to_owned(), ..rupture(0.5) }).unwrap();
    let lines: Vec<Log> = messages(&writer.finish().unwrap(), "/log")
        .into_iter()
        .map(|(_, data)| Log::decode(data.as_slice()).unwrap())
        .collect();
    assert_eq!(lines[0].message, "tip_rupture at 3.021 mm, 1.000 N, boundary 0: skin");
    assert_eq!(lines[1].level, i32::from(log::Level::Error));
}

#[test]
fn the_same_attempt_makes_the_same_bytes() {
    assert!(file(1500) == file(1500));
}
