//! wingbeat-cli
fn main() {}
