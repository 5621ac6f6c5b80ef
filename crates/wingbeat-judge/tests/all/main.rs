//! The tests of the crate.

mod data;
mod limits;
mod unit;
mod verdict;
