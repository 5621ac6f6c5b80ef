//! Comparisons that a test can wait for, the shared problem of the solvers, and the program.

mod flapbody;
mod mechanics;
mod program;
