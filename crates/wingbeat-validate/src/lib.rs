//! wingbeat-validate
