//! The shared problem of the solvers, and the program. The comparisons themselves are run by `cargo xtask test` and `long`.

mod flapbody;
mod program;
