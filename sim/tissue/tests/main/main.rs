//! What the tissue promises, shown from outside.

#[cfg(test)]
mod allocation;
#[cfg(test)]
mod angles;
#[cfg(test)]
mod attempt_error;
#[cfg(test)]
mod axisymmetric;
#[cfg(test)]
mod axisymmetric_laws;
#[cfg(test)]
mod calibrate;
#[cfg(test)]
mod calibrate_timed;
#[cfg(test)]
mod estimates;
#[cfg(test)]
mod follow;
#[cfg(test)]
mod mass_spring;
#[cfg(test)]
mod mass_spring_convergence;
#[cfg(test)]
mod mass_spring_motion;
#[cfg(test)]
mod multifrontal;
#[cfg(test)]
mod oblique;
#[cfg(test)]
mod planner;
#[cfg(test)]
mod uneven;
#[cfg(test)]
mod volumetric;
#[cfg(test)]
mod volumetric_laws;
#[cfg(test)]
mod volumetric_meshes;
#[cfg(test)]
mod volumetric_motion;
#[cfg(test)]
mod volumetric_reference;
