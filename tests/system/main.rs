//! System tests: the rules of the house, and the whole path through both programs.

mod browser;
mod documents;
mod house;
mod independent_reader;
mod licences;
mod whole_path;
