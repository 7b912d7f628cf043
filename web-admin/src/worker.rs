//! Scores what was uploaded.
