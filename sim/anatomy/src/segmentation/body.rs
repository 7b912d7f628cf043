//! The body: all voxels not connected to the outside.

use super::map::LabelMap;

/// Label of the body in the map returned by [`LabelMap::body`].
pub const BODY: u16 = 1;

/// Marks used by [`Flood`] besides 0 and 1.
const REACHED: u16 = 2;
const LARGEST: u16 = 3;

impl LabelMap {
    /// Returns the same image with one label, for the body: the largest component not reached by
    /// air from the image's ends. Labelled voxels and enclosed holes belong to the body; separate
    /// objects, such as the table, do not.
    #[must_use]
    pub fn body(&self) -> Self {
        let marks = self.labels.iter().map(|label| u16::from(*label != 0)).collect();
        let mut flood = Flood { size: self.size, open: Vec::new(), marks };
        for voxel in 0..flood.marks.len() {
            if flood.marks[voxel] == 0 && flood.is_at_end(voxel) {
                flood.fill(voxel, 0, REACHED);
            }
        }
        flood.marks.iter_mut().for_each(|mark| *mark = u16::from(*mark != REACHED));
        flood.keep_largest();
        self.with_labels(flood.marks)
    }
}

/// Flood fill through the faces of voxels.
struct Flood {
    size: [usize; 3],
    open: Vec<usize>,
    marks: Vec<u16>,
}

impl Flood {
    /// Keeps the largest component of the voxels marked 1.
    fn keep_largest(&mut self) {
        let mut largest: Option<(usize, usize)> = None;
        for voxel in 0..self.marks.len() {
            if self.marks[voxel] == 1 {
                let count = self.fill(voxel, 1, REACHED);
                if largest.is_none_or(|(most, _)| count > most) {
                    largest = Some((count, voxel));
                }
            }
        }
        if let Some((_, voxel)) = largest {
            self.fill(voxel, REACHED, LARGEST);
        }
        self.marks.iter_mut().for_each(|mark| *mark = if *mark == LARGEST { BODY } else { 0 });
    }

    fn place(&self, voxel: usize) -> [usize; 3] {
        let [along, across, _] = self.size;
        [voxel % along, voxel / along % across, voxel / (along * across)]
    }

    fn is_at_end(&self, voxel: usize) -> bool {
        self.place(voxel).iter().zip(self.size).any(|(at, size)| *at == 0 || at + 1 == size)
    }

    /// Replaces a mark in a connected region, and returns the number of its voxels.
    fn fill(&mut self, start: usize, from: u16, to: u16) -> usize {
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        self.marks[start] = to;
        self.open.push(start);
        let mut count = 0;
        while let Some(voxel) = self.open.pop() {
            count += 1;
            let at = self.place(voxel);
            for axis in 0..3 {
                let before = (at[axis] > 0).then(|| voxel - strides[axis]);
                let after = (at[axis] + 1 < self.size[axis]).then(|| voxel + strides[axis]);
                for next in before.into_iter().chain(after) {
                    if self.marks[next] == from {
                        self.marks[next] = to;
                        self.open.push(next);
                    }
                }
            }
        }
        count
    }
}
