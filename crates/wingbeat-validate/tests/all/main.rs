//! The shared problem of the solvers and the page. The comparisons themselves are run by `cargo xtask test` and `long`.

mod flapbody;
mod ground;
mod inside;
mod page;
