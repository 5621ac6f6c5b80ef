//! Records as Parquet: a 64-bit float column each, with unit, frame and limits in the column's metadata.

use std::collections::HashMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, RecordBatchOptions};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, Encoding};
use parquet::file::properties::WriterProperties;
use wingbeat::flight::{Column, Record};

use crate::Error;

/// Writes `record` to `path`. The same record gives the same bytes.
pub fn write_parquet(path: &Path, record: &Record) -> Result<(), Error> {
    let schema = Arc::new(Schema::new(record.columns().iter().map(field).collect::<Vec<_>>()));
    let arrays = record.columns().iter().map(|column| {
        let array: ArrayRef = Arc::new(Float64Array::from_iter_values(column.values.iter().copied()));
        array
    });
    let options = RecordBatchOptions::new().with_row_count(Some(record.rows()));
    let batch = RecordBatch::try_new_with_options(Arc::clone(&schema), arrays.collect(), &options)
        .map_err(|error| Error::format(path, error))?;
    let file = File::create(path).map_err(|source| Error::file(path, source))?;
    let mut writer =
        ArrowWriter::try_new(file, schema, Some(properties())).map_err(|e| Error::format(path, e))?;
    writer.write(&batch).map_err(|error| Error::format(path, error))?;
    writer.close().map_err(|error| Error::format(path, error))?;
    Ok(())
}

/// Reads a record from `path`: every column must hold 64-bit floats.
pub fn read_parquet(path: &Path) -> Result<Record, Error> {
    let file = File::open(path).map_err(|source| Error::file(path, source))?;
    let builder =
        ParquetRecordBatchReaderBuilder::try_new(file).map_err(|error| Error::format(path, error))?;
    let mut columns: Vec<Column> = builder.schema().fields().iter().map(|field| column(field)).collect();
    for batch in builder.build().map_err(|error| Error::format(path, error))? {
        let batch = batch.map_err(|error| Error::format(path, error))?;
        for (column, array) in columns.iter_mut().zip(batch.columns()) {
            let numbers = array.as_any().downcast_ref::<Float64Array>().ok_or_else(|| {
                Error::format(
                    path,
                    format!("column {} holds {}, not Float64", column.name, array.data_type()),
                )
            })?;
            column.values.extend(numbers.iter().map(|number| number.unwrap_or(f64::NAN)));
        }
    }
    Record::new(columns, 0).map_err(|error| Error::format(path, error))
}

/// Neighbouring samples differ little: splitting their bytes into streams packs them well.
fn properties() -> WriterProperties {
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::BYTE_STREAM_SPLIT)
        .set_created_by("wingbeat".into())
        .build()
}

fn field(column: &Column) -> Field {
    let mut metadata = HashMap::new();
    for (key, text) in [("unit", &column.unit), ("frame", &column.frame)] {
        if !text.is_empty() {
            metadata.insert(key.into(), text.clone());
        }
    }
    for (key, limit) in [("low", column.low), ("high", column.high)] {
        if limit.is_finite() {
            metadata.insert(key.into(), limit.to_string());
        }
    }
    Field::new(&column.name, DataType::Float64, false).with_metadata(metadata)
}

fn column(field: &Field) -> Column {
    let text = |key: &str| field.metadata().get(key).cloned().unwrap_or_default();
    let number = |key: &str, otherwise: f64| text(key).parse().unwrap_or(otherwise);
    Column {
        low: number("low", f64::NEG_INFINITY),
        high: number("high", f64::INFINITY),
        ..Column::new(field.name(), text("unit"), text("frame"))
    }
}
