//! The service of Stylet: takes recordings in, scores them, shows what trainees and instructors need to see.

pub mod domain;
