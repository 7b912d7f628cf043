//! The commands of `web-admin`.
