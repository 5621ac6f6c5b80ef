//! The schema of a record as Arrow writes it into Parquet files, so that pandas, Polars and others see units and frames.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flatbuffers::{FlatBufferBuilder, ForwardsUOffset, Vector, WIPOffset};

/// Key of the schema in a Parquet file's metadata.
pub const KEY: &str = "ARROW:schema";

/// Name and metadata of a column.
pub type ColumnMetadata<'a> = (&'a str, Vec<(&'static str, String)>);

/// Slots of Message.fbs and Schema.fbs (Apache Arrow columnar format 1.5): field i of a table is at 4 + 2 i.
mod slot {
    pub const KEY_VALUE: [u16; 2] = [4, 6];
    pub const FIELD_NAME: u16 = 4;
    pub const FIELD_TYPE: [u16; 2] = [8, 10];
    pub const FIELD_CHILDREN: u16 = 14;
    pub const FIELD_METADATA: u16 = 16;
    pub const PRECISION: u16 = 4;
    pub const SCHEMA_FIELDS: u16 = 6;
    pub const SCHEMA_METADATA: u16 = 8;
    pub const MESSAGE_VERSION: u16 = 4;
    pub const MESSAGE_HEADER: [u16; 2] = [6, 8];
}

/// Precision.DOUBLE.
const DOUBLE: i16 = 2;
/// Type.FloatingPoint.
const FLOATING_POINT: u8 = 3;
/// MessageHeader.Schema.
const SCHEMA: u8 = 1;
/// MetadataVersion.V5.
const VERSION_5: i16 = 4;

/// An offset to a table whose fields were pushed one by one.
struct TableOffset;

/// The columns, all of 64-bit floats without gaps, and the metadata of all, as an encapsulated IPC message in base 64.
pub fn encoded(columns: &[ColumnMetadata], all: &[(&str, &str)]) -> String {
    let mut builder = FlatBufferBuilder::new();
    let fields: Vec<_> = columns.iter().map(|column| field(&mut builder, column)).collect();
    let fields = vector(&mut builder, &fields);
    let pairs: Vec<_> = all.iter().map(|(key, value)| key_value(&mut builder, key, value)).collect();
    let pairs = (!pairs.is_empty()).then(|| vector(&mut builder, &pairs));
    let table = builder.start_table();
    builder.push_slot_always(slot::SCHEMA_FIELDS, fields);
    if let Some(pairs) = pairs {
        builder.push_slot_always(slot::SCHEMA_METADATA, pairs);
    }
    let schema = builder.end_table(table);
    let table = builder.start_table();
    builder.push_slot(slot::MESSAGE_VERSION, VERSION_5, 0);
    builder.push_slot(slot::MESSAGE_HEADER[0], SCHEMA, 0);
    builder.push_slot_always(slot::MESSAGE_HEADER[1], schema);
    let message = builder.end_table(table);
    builder.finish_minimal(message);
    let message = builder.finished_data();
    let mut bytes = vec![0xff; 4];
    bytes.extend((message.len() as u32).to_le_bytes());
    bytes.extend(message);
    BASE64_STANDARD.encode(bytes)
}

fn field(builder: &mut FlatBufferBuilder, (name, metadata): &ColumnMetadata) -> WIPOffset<TableOffset> {
    let name = builder.create_string(name);
    let pairs: Vec<_> = metadata.iter().map(|(key, value)| key_value(builder, key, value)).collect();
    let (pairs, children) = (vector(builder, &pairs), vector(builder, &[]));
    let table = builder.start_table();
    builder.push_slot(slot::PRECISION, DOUBLE, 0);
    let double = builder.end_table(table);
    let table = builder.start_table();
    builder.push_slot_always(slot::FIELD_NAME, name);
    builder.push_slot(slot::FIELD_TYPE[0], FLOATING_POINT, 0);
    builder.push_slot_always(slot::FIELD_TYPE[1], double);
    builder.push_slot_always(slot::FIELD_CHILDREN, children);
    builder.push_slot_always(slot::FIELD_METADATA, pairs);
    WIPOffset::new(builder.end_table(table).value())
}

fn key_value(builder: &mut FlatBufferBuilder, key: &str, value: &str) -> WIPOffset<TableOffset> {
    let (key, value) = (builder.create_string(key), builder.create_string(value));
    let table = builder.start_table();
    builder.push_slot_always(slot::KEY_VALUE[0], key);
    builder.push_slot_always(slot::KEY_VALUE[1], value);
    WIPOffset::new(builder.end_table(table).value())
}

fn vector<'a>(
    builder: &mut FlatBufferBuilder<'a>,
    tables: &[WIPOffset<TableOffset>],
) -> WIPOffset<Vector<'a, ForwardsUOffset<TableOffset>>> {
    builder.create_vector(tables)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As pyarrow 26 reads it: three columns of doubles without gaps, with this metadata.
    const READ_BY_PYARROW: &str = "//////ABAAAQAAAAAAAKAAwACgAJAAQACgAAABAAAAAAAQQACAAIAAAABAAIAAAABAAAAAMAAABcAQAAyAAAAAQAAABS////\
        IAAAABgAAAAMAAAAAAAAA4AAAACu/v//AAACAAAAAAADAAAATAAAACgAAAAEAAAAsP7//wgAAAAMAAAAAwAAADAuMwAEAAAA\
        aGlnaAAAAADQ/v//CAAAABAAAAAEAAAALTAuMwAAAAADAAAAbG93APD+//8IAAAADAAAAAMAAAByYWQABAAAAHVuaXQAAAAA\
        FQAAAGNvbW1hbmRfc2hvdWxkZXJfbGVmdAASABgAFAAAABMADAAAAAgABAASAAAAIAAAABgAAAAMAAAAAAAAA1wAAABu////\
        AAACAAAAAAACAAAAKAAAAAQAAABs////CAAAAAwAAAABAAAAVwAAAAUAAABmcmFtZQAAAIz///8IAAAADAAAAAEAAABtAAAA\
        BAAAAHVuaXQAAAAABgAAAHBfV0JfeAAAAAASABoAFAAAABMADAAAAAgABAASAAAAKAAAACAAAAAUAAAAAAAAA0gAAAAAAAYA\
        CAAGAAYAAAAAAAIAAAAAAAEAAAAMAAAACAAMAAgABAAIAAAACAAAAAwAAAABAAAAcwAAAAQAAAB1bml0AAAAAAEAAAB0AAAA";

    #[test]
    fn the_schema_is_the_one_that_arrow_reads() {
        let described = |pairs: &[(&'static str, &str)]| -> Vec<(&'static str, String)> {
            pairs.iter().map(|(key, value)| (*key, (*value).to_owned())).collect()
        };
        let columns = [
            ("t", described(&[("unit", "s")])),
            ("p_WB_x", described(&[("unit", "m"), ("frame", "W")])),
            ("command_shoulder_left", described(&[("unit", "rad"), ("low", "-0.3"), ("high", "0.3")])),
        ];
        assert_eq!(encoded(&columns, &[]), READ_BY_PYARROW);
    }
}
