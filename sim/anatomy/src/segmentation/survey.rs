//! Statistics of each label of a map, in one pass.

use std::collections::BTreeMap;

use super::map::LabelMap;

/// Number and extent of the voxels of a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LabelExtent {
    /// Number of voxels.
    pub voxels: u64,
    /// Number of their faces towards voxels of other labels, or towards the image's end.
    pub faces: u64,
    /// Whether some of them lie at the end of the image, which cuts the structure.
    pub is_cut: bool,
    pub(super) low: [usize; 3],
    pub(super) high: [usize; 3],
}

const NOWHERE: LabelExtent = LabelExtent { voxels: 0, faces: 0, is_cut: false, low: [usize::MAX; 3], high: [0; 3] };

impl LabelMap {
    /// Returns the extent of each label.
    #[must_use]
    pub fn survey(&self) -> BTreeMap<u16, LabelExtent> {
        let mut extents = vec![NOWHERE; 1 << 16];
        let [along, across, deep] = self.size;
        let strides = [1, along, along * across];
        let mut voxel = 0;
        for k in 0..deep {
            for j in 0..across {
                for i in 0..along {
                    self.take_voxel(&mut extents, [i, j, k], strides.map(|stride| (voxel, stride)));
                    voxel += 1;
                }
            }
        }
        (0..=u16::MAX).zip(extents).filter(|(_, extent)| extent.voxels > 0).collect()
    }

    fn take_voxel(&self, extents: &mut [LabelExtent], at: [usize; 3], steps: [(usize, usize); 3]) {
        let label = self.labels[steps[0].0];
        let extent = &mut extents[usize::from(label)];
        extent.voxels += 1;
        for (axis, &place) in at.iter().enumerate() {
            extent.low[axis] = extent.low[axis].min(place);
            extent.high[axis] = extent.high[axis].max(place);
            let ends = u64::from(place == 0) + u64::from(place + 1 == self.size[axis]);
            extent.faces += ends;
            extent.is_cut |= ends > 0;
        }
        for (axis, (voxel, stride)) in steps.into_iter().enumerate() {
            let Some(before) = (at[axis] > 0).then(|| self.labels[voxel - stride]).filter(|other| *other != label)
            else {
                continue;
            };
            extents[usize::from(label)].faces += 1;
            extents[usize::from(before)].faces += 1;
        }
    }
}
