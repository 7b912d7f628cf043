//! The scene crate through its public functions: shipped documents, refusals, schema, scaling, patients, meshes.

mod force_case;
mod mesh;
mod patient;
mod refusals;
mod scaling;
mod schema;
mod shipped;
mod support;
