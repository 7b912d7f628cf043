//! The scene crate through its public functions: shipped documents, refusals, schema, scaling, patients, meshes.

#![expect(clippy::float_cmp, reason = "what is read back must be exactly what was written")]

#[cfg(test)]
mod anatomy;
#[cfg(test)]
mod bent;
#[cfg(test)]
mod body;
#[cfg(test)]
mod bombs;
#[cfg(test)]
mod encoder;
#[cfg(test)]
mod epidural;
#[cfg(test)]
mod field_case;
#[cfg(test)]
mod force_case;
#[cfg(test)]
mod hands;
#[cfg(test)]
mod instrument;
#[cfg(test)]
mod mend;
#[cfg(test)]
mod mesh;
#[cfg(test)]
mod options;
#[cfg(test)]
mod patient;
#[cfg(test)]
mod picture;
#[cfg(test)]
mod placing;
#[cfg(test)]
mod provenance;
#[cfg(test)]
mod refusals;
#[cfg(test)]
mod scaling;
#[cfg(test)]
mod schema;
#[cfg(test)]
mod shipped;
#[cfg(test)]
mod soundness;
#[cfg(test)]
mod support;
#[cfg(test)]
mod tissue;
