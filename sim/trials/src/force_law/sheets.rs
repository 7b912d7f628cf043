//! Limits of toughness and pretension: tissue that hardly tears, tissue that hardly deforms, and
//! sheets supported by tension alone.

use core::f64::consts::PI;

use law::axial::{AxialSpec, ForceLaw, tense_stiffness_n_per_m};
use law::fracture::SharpPunch;

use super::{DT, lateness_m};
use crate::scenes::{Leg, make_layer, needle_through};
use crate::{Measured, largest};

/// Radii from a fine needle to a wide trocar, in m; shear moduli from gel to tendon, in Pa;
/// fracture energies from almost zero to those of rubber, in J/m².
const RADII_M: [f64; 5] = [1e-4, 3e-4, 1e-3, 2e-3, 5e-3];
const MODULI_PA: [f64; 5] = [1e2, 1e3, 1e4, 1e6, 1e8];
const ENERGIES_J_PER_M2: [f64; 6] = [1e-3, 1.0, 1e2, 1e3, 1e4, 1e6];

fn torn_n(radius_m: f64, shear_modulus_pa: f64, fracture_energy_j_per_m2: f64) -> f64 {
    SharpPunch { radius_m, shear_modulus_pa, fracture_energy_j_per_m2 }.threshold_n()
}

/// Counts the pairs of neighbouring radii, moduli or energies for which the threshold does not
/// rise.
pub(super) fn toughness_order() -> Measured {
    let mut fallen = 0;
    for radius_m in RADII_M {
        for modulus_pa in MODULI_PA {
            for energy in ENERGIES_J_PER_M2 {
                let here_n = torn_n(radius_m, modulus_pa, energy);
                let is_more = |more_n: f64| more_n.is_finite() && here_n > 0.0 && more_n > here_n;
                let more_n = [
                    torn_n(1.1 * radius_m, modulus_pa, energy),
                    torn_n(radius_m, 1.1 * modulus_pa, energy),
                    torn_n(radius_m, modulus_pa, 1.1 * energy),
                ];
                fallen += more_n.into_iter().filter(|&more_n| !is_more(more_n)).count();
            }
        }
    }
    Ok(fallen as f64)
}

/// Tissue that tears with a millionth of the energy needed to open it, J = 10⁻⁶ μR: relative
/// deviation of the threshold from πRJ.
pub(super) fn toughness_brittle() -> Measured {
    Ok(largest(RADII_M.into_iter().map(|radius_m| {
        let energy = 1e-6 * 1e4 * radius_m;
        (torn_n(radius_m, 1e4, energy) / (PI * radius_m * energy) - 1.0).abs()
    })))
}

/// Tissue that tears with a hundred million times the energy needed to open it, J = 10⁸ μR:
/// relative deviation of the threshold from πμR² (1 + ln(J/(μR))).
pub(super) fn toughness_tough() -> Measured {
    Ok(largest(RADII_M.into_iter().map(|radius_m| {
        let limit_n = PI * 1e4 * radius_m * radius_m * (1.0 + libm::log(1e8));
        (torn_n(radius_m, 1e4, 1e8 * 1e4 * radius_m) / limit_n - 1.0).abs()
    })))
}

/// A sheet of 1 N/m under tension, above fat: tensions from slack to that of a drum, fixed from
/// just outside the needle to far away.
fn tense_sheets() -> impl Iterator<Item = AxialSpec> {
    let tensions = [0.0, 1.0, 30.0, 3000.0].into_iter();
    tensions.flat_map(|tension| [1.05e-3, 0.01, 0.5].map(|held_m| (tension, held_m))).map(|(tension, held_m)| {
        let mut sheet = make_layer("sheet", [0.0, 1.0, 0.0, 0.05, 0.05, 0.0, 0.0]);
        sheet.stiffness_n_per_m += tense_stiffness_n_per_m(tension, held_m, 1e-3);
        let fat = make_layer("fat", [40.0, 50.0, 0.0, 0.04, 0.04, 0.0, 0.0]);
        AxialSpec { law: ForceLaw::Version3, ..needle_through(vec![sheet, fat]) }
    })
}

/// Largest delay of a rupture relative to its closed form, in µm, at 2 µm per tick.
pub(super) fn tense_lateness() -> Measured {
    let leg = Leg { start_s: 0.0, duration_s: 30.0, dt_s: DT, from_m: 0.0, to_m: 0.06 };
    tense_sheets().try_fold(0.0, |latest, spec| Ok(libm::fmaximum(latest, lateness_m(spec, &leg)? * 1e6)))
}
