//! The recorder against boxes on the loopback.

mod loopback;
mod other_box;
