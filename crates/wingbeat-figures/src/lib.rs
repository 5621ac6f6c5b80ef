//! wingbeat-figures
