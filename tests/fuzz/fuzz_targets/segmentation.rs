//! A map of labels, as a file of NIfTI has it, packed or not, and what the labels mean; whatever can be read is meshed.
#![no_main]

use anatomy::segmentation::{LabelMap, MeshRequest, mesh_label};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = documents::SegmentationLabels::from_bytes("labels.toml", bytes);
    let Ok(map) = LabelMap::read(bytes) else { return };
    let request = MeshRequest { smoothing_voxels: 0.5, most_triangles: 2000 };
    for (label, extent) in map.survey().into_iter().take(4) {
        let _ = mesh_label(&map, label, &extent, request);
    }
    let _ = map.body();
});
