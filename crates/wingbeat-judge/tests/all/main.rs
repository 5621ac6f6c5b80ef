//! The tests of the crate.

mod limits;
mod verdict;
