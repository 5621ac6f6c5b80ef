//! The tests of the crate.

mod data;
mod limits;
mod verdict;
