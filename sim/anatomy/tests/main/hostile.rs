//! Label maps in every form that the standard has, and files that are none.
//!
//! Would fail if bytes were swapped, an orientation were mirrored, or a header's promise were believed before its bytes had come.

use anatomy::segmentation::{LabelMap, Orientation, SegmentationError};
use nalgebra::Vector3;

use crate::nifti::{Form, PLAIN, Written, oblique_steps, pack, read};

fn small(mirror: f64) -> Written {
    let mut steps_mm = oblique_steps([1.0, 1.5, 2.0], 0.4);
    steps_mm.column_mut(2).scale_mut(mirror);
    let labels = (0..60).map(|at| at * 1000).collect();
    Written { size: [5, 4, 3], steps_mm, origin_mm: Vector3::new(-12.5, 40.0, 7.25), labels }
}

#[test]
fn every_version_order_and_orientation_gives_the_same_map() {
    for mirror in [1.0, -1.0] {
        let written = small(mirror);
        let first = read(&written.bytes(PLAIN)).unwrap();
        assert_eq!(first.size(), [5, 4, 3]);
        assert!((first.voxel_m3() - 3e-9).abs() < 1e-14);
        for is_second in [false, true] {
            for is_little in [false, true] {
                for by in [Orientation::Sform, Orientation::Qform] {
                    let bytes = written.bytes(Form { is_second, is_little, by });
                    let other = read(&bytes).unwrap();
                    assert_eq!(other.orientation(), by);
                    assert_eq!(read(&pack(&bytes)).unwrap(), other, "packed or not");
                    assert_eq!(other.survey(), first.survey());
                    let edges = other.edges_m().into_iter().zip(first.edges_m());
                    assert!(edges.into_iter().all(|(one, two)| (one - two).abs() < 1e-9));
                }
            }
        }
    }
    let none = read(&small(1.0).bytes(Form { by: Orientation::Pixdim, ..PLAIN })).unwrap();
    assert_eq!(none.orientation(), Orientation::Pixdim);
}

/// A file of real numbers, some of them another value.
fn reals(values: &[(usize, f32)]) -> Vec<u8> {
    let written = small(1.0);
    let mut bytes = written.bytes(PLAIN)[..352].to_vec();
    bytes[70..72].copy_from_slice(&16_i16.to_le_bytes());
    let mut all: Vec<f32> = written.labels.iter().map(|label| f32::from(*label)).collect();
    for (at, value) in values {
        all[*at] = *value;
    }
    bytes.extend(all.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[test]
fn what_fills_an_image_around_the_body_is_outside_it() {
    let background = {
        let mut written = small(1.0);
        written.labels[..3].fill(0);
        read(&written.bytes(PLAIN)).unwrap()
    };
    for fill in [f32::NAN, -1024.0, -1.0] {
        assert_eq!(read(&reals(&[(0, fill), (1, fill), (2, fill)])).unwrap(), background, "{fill}");
    }
    assert_eq!(read(&reals(&[(0, f32::NAN), (1, -1024.0), (2, -1024.0)])).unwrap(), background);
    for wrong in [
        [(0, -1024.0), (1, -3.0)],
        [(0, f32::INFINITY), (1, 0.0)],
        [(0, 0.0), (1, f32::NEG_INFINITY)],
        [(0, 0.0), (1, 1.5)],
    ] {
        let told = read(&reals(&wrong)).unwrap_err().to_string();
        assert!(told.contains("around the body NaN or one negative number"), "{told}");
    }
    let mut unset = small(1.0).bytes(PLAIN);
    unset[108..112].fill(0);
    assert_eq!(read(&unset).unwrap(), read(&small(1.0).bytes(PLAIN)).unwrap(), "an offset that is left out");
}

fn refusal(change: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut bytes = small(1.0).bytes(PLAIN);
    change(&mut bytes);
    read(&bytes).unwrap_err().to_string()
}

#[test]
fn what_is_no_map_of_labels_is_refused_in_words() {
    let put = |at: usize, value: [u8; 2]| move |bytes: &mut Vec<u8>| bytes[at..at + 2].copy_from_slice(&value);
    let nan = f32::NAN.to_le_bytes();
    let refused = [
        (refusal(|bytes| bytes.truncate(400)), "unreadable"),
        (refusal(Vec::clear), "unreadable"),
        (refusal(|bytes| bytes[0] = 1), "not a NIfTI file: its first number is 257"),
        (refusal(put(344, *b"ni")), "not a NIfTI file: its magic number is \"ni1"),
        (refusal(put(42, [0, 0])), "dim = [3, 0, 4, 3"),
        (refusal(put(42, [0xff, 0xff])), "dim = [3, -1, 4, 3"),
        (refusal(|bytes| (bytes[40], bytes[48]) = (4, 2)), "dim = [4, 5, 4, 3, 2"),
        (refusal(put(40, [9, 0])), "dim = [9, 5"),
        (refusal(put(70, [128, 0])), "datatype = 128; allowed: whole numbers"),
        (refusal(|bytes| bytes[123] = 4), "xyzt_units = 4"),
        (refusal(|bytes| bytes[280..284].copy_from_slice(&nan)), "voxels = NaN mm"),
        (refusal(|bytes| bytes[296..328].fill(0)), "voxels = "),
        (
            refusal(|bytes| bytes[108..112].copy_from_slice(&1e30_f32.to_le_bytes())),
            "vox_offset = 1000000015047466200000000000000",
        ),
        (refusal(|bytes| bytes[112..116].copy_from_slice(&0.3003_f32.to_le_bytes())), "voxel [1, 0, 0] = 300.3"),
    ];
    for (found, wanted) in refused {
        assert!(found.contains(wanted), "{wanted:?} is not in {found:?}");
    }
}

#[test]
fn reader_rejects_false_sizes_and_ignores_data_after_the_voxels() {
    // 512 × 512 × 512 voxels are promised and none comes.
    let mut promise = small(1.0).bytes(PLAIN);
    for at in [42, 44, 46] {
        promise[at..at + 2].copy_from_slice(&512_i16.to_le_bytes());
    }
    assert!(matches!(read(&promise), Err(SegmentationError::Unreadable(_))));
    assert!(matches!(read(&pack(&promise)), Err(SegmentationError::Unreadable(_))));
    promise[42..44].copy_from_slice(&4096_i16.to_le_bytes());
    assert!(matches!(read(&promise), Err(SegmentationError::Header { field: "dim", .. })));
    // A map of 60 voxels, and behind it 200 MB of nothing, packed to a thousandth.
    let mut bomb = small(1.0).bytes(PLAIN);
    let whole = read(&bomb).unwrap();
    bomb.resize(bomb.len() + 200_000_000, 0);
    assert_eq!(LabelMap::read(pack(&bomb).as_slice()).unwrap(), whole);
}

#[test]
fn every_label_map_that_is_a_bomb_is_refused() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/bombs/segmentation");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() >= 4, "{} bombs", files.len());
    for file in files {
        assert!(LabelMap::read(std::fs::File::open(&file).unwrap()).is_err(), "{}", file.display());
    }
}
