//! The shared problem of the solvers, the page, and the program. The comparisons themselves are run by `cargo xtask test` and `long`.

mod flapbody;
mod ground;
mod inside;
mod page;
mod program;
