//! wingbeat-io
