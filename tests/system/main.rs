//! System tests: the rules of the house, and the whole path through both programs.

#![expect(clippy::expect_used, clippy::panic, reason = "a test that cannot go on says why and stops")]

mod attack;
mod authoring_journey;
mod benchmark;
mod browser;
mod cluster;
mod commands;
mod decoders;
mod deploy;
mod directory;
mod documents;
mod every_page;
mod faculty;
mod foreign_pages;
mod guest;
mod guest_journey;
mod house;
mod independent_reader;
mod instrument_journey;
mod journeys;
mod logs;
mod messages;
mod metrics;
mod other_programs;
mod passkey;
mod python_package;
mod readme;
mod replay_drawing;
mod research_tables;
mod roster_journey;
mod screenshots;
mod second_factor;
mod speed;
mod station;
mod statistics;
mod study_figures;
mod style;
mod subjects;
mod surveys;
mod visitor;
mod whole_path;
mod window;
mod wine;
