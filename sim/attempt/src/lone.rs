//! A needle under the force law alone, on a motion that is known beforehand: the computation of
//! `stylet force`.

use documents::force_case::ForceCase;
use law::Incidence;
use law::axial::{self, AxialInput, AxialOutput, AxialParams, AxialScratch, AxialState, ParamError, Rupture};
use law::soundness::{self, Unsound};

use crate::trajectory::AxialSample;

/// A needle and the layers that it meets, without a field behind them.
#[derive(Debug)]
pub struct LoneNeedle {
    params: AxialParams,
    incidence: Incidence,
    edge: [f64; 2],
}

impl LoneNeedle {
    /// Creates the needle of a case.
    ///
    /// # Errors
    /// The first number that the law rejects.
    pub fn new(case: ForceCase) -> Result<Self, ParamError> {
        let edge = [libm::cos(case.edge_rad), libm::sin(case.edge_rad)];
        Ok(Self {
            params: AxialParams::new(case.spec)?,
            incidence: Incidence::of_factor(1.0 / libm::cos(case.angle_rad)),
            edge,
        })
    }

    /// Returns the ruptures that would create energy.
    #[must_use]
    pub fn find_unsound_ruptures(&self) -> Vec<Unsound> {
        soundness::find_unsound_ruptures(self.params.spec())
    }

    /// Pushes a new needle along a trajectory, and calls back for every sample with the law's
    /// output and ruptures.
    ///
    /// # Errors
    /// The first error of the callback; nothing is computed after it.
    pub fn push_along<E>(
        &self,
        trajectory: impl IntoIterator<Item = AxialSample>,
        mut tell: impl FnMut(&AxialSample, &AxialOutput, &[Rupture]) -> Result<(), E>,
    ) -> Result<(), E> {
        let (mut state, mut scratch) = (AxialState::new(&self.params), AxialScratch::new(&self.params));
        state.edge = self.edge;
        for sample in trajectory {
            let input = AxialInput { t_s: sample.t_s, x_m: sample.x_m, incidence: self.incidence };
            let output = axial::step(&self.params, &mut state, &mut scratch, &input);
            tell(&sample, &output, &scratch.ruptures)?;
        }
        Ok(())
    }
}
