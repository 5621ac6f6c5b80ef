//! Files written and read back, those of other programs, and those made to harm.

#[cfg(feature = "formats")]
mod hostile;
mod mcap;
mod parquet;
mod plain;
#[cfg(feature = "formats")]
mod samples;
mod table;
mod trajectory;
#[cfg(feature = "urdf")]
mod urdf;
