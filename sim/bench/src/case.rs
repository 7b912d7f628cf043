//! The hard cases in the words of physics section 8.

pub(super) const STAB: &str = "1 m/s stab";
pub(super) const TELEPORT: &str = "50 mm teleport in one tick";
pub(super) const BAD_SAMPLES: &str = "NaN, infinite, repeated, missing and backwards-in-time samples";
pub(super) const NO_TIME: &str = "dt = 0";
pub(super) const RELEASED: &str = "a released handle";
pub(super) const REVERSAL: &str = "reversal inside the presliding zone";
pub(super) const HOLD: &str = "ten minutes' hold";
pub(super) const RE_ENTRY: &str = "withdrawal, re-entry in the same track and 3 mm beside it";
pub(super) const OBLIQUE: &str = "60° oblique";
pub(super) const COINCIDENT: &str = "zero-thickness and duplicate layers";
pub(super) const THIN: &str = "a layer thinner than L";
pub(super) const CASCADE: &str = "cascades";
pub(super) const STRONG: &str = "thresholds above the device's force";
pub(super) const HOURS: &str = "8 simulated hours without drift";
pub(super) const RATES: &str = "1 and 4 kHz giving the same forces";
pub(super) const FIELD_RATE: &str = "tissue at 15 Hz under a 1 kHz needle";
pub(super) const RATIOS: &str = "stiffness ratios 1e2–1e5 between layers";
pub(super) const THIN_SKIN: &str = "0.8 mm skin on 39 mm muscle";
pub(super) const INCOMPRESSIBLE: &str = "ν = 0.499";
pub(super) const SLIVERS: &str = "slivers and inverted elements";
pub(super) const HALF_SPACE: &str = "half-space, Gaussian load";
pub(super) const BOUSSINESQ: &str = "Boussinesq";
pub(super) const PUNCH: &str = "flat punch";
pub(super) const COLUMN: &str = "layered column (confined)";
pub(super) const PATCH: &str = "patch test";
pub(super) const MUTUAL: &str = "two loads' work on each other (Betti)";
pub(super) const LONG_STEP: &str = "explicit step 4 × too large (refused with the stable step named, never NaN)";
