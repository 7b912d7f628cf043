//! People and cohorts, provisioned by a directory.

pub(crate) mod scim;
