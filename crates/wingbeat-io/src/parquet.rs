//! Records as Parquet: a 64-bit float column each, with unit, frame and limits in the column's metadata.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wingbeat::math::order::filled;

use parquet::basic::{Compression, Encoding, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, get_typed_column_reader};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, KeyValue};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use wingbeat::simulate::{Column, Record};

use crate::{Error, MOST_COLUMNS, MOST_NUMBERS, arrow_schema, decoded, regular, thrift};

/// Key of the columns' units, frames and limits in the file's metadata, as JSON.
const KEY: &str = "wingbeat";
/// Key under which pandas (2.1 or later) finds what becomes `df.attrs`, as JSON.
const PANDAS: &str = "PANDAS_ATTRS";

/// Rows for which room is made at once.
const PREPARED: usize = 1 << 16;

/// Metadata of columns by name.
type Descriptions = BTreeMap<String, BTreeMap<String, String>>;

/// Writes `record` to `path`. The same record gives the same bytes.
pub fn write_parquet(path: &Path, record: &Record) -> Result<(), Error> {
    let file = File::create(path).map_err(|source| Error::file(path, source))?;
    write(file, record).map_err(|error| Error::format(path, error))
}

/// A record that is written part by part: no more than a part is ever in memory.
pub struct ParquetWriter {
    path: PathBuf,
    writer: SerializedFileWriter<File>,
}

impl ParquetWriter {
    /// Begins a file with the columns of `record`, of which no row is written.
    pub fn create(path: &Path, record: &Record) -> Result<Self, Error> {
        let file = File::create(path).map_err(|source| Error::file(path, source))?;
        let writer = begin(file, record).map_err(|error| Error::format(path, error))?;
        Ok(Self { path: path.into(), writer })
    }

    /// Appends the rows of `record`, whose columns are those of the file.
    pub fn append(&mut self, record: &Record) -> Result<(), Error> {
        append_group(&mut self.writer, record).map_err(|error| Error::format(&self.path, error))
    }

    /// Ends the file; without it the file is no Parquet.
    pub fn close(self) -> Result<(), Error> {
        self.writer.close().map(drop).map_err(|error| Error::format(&self.path, error))
    }
}

/// Reads a record from `path`: every column must hold 64-bit floats; a gap becomes not-a-number.
pub fn read_parquet(path: &Path) -> Result<Record, Error> {
    let read = read_some(path, &|_| true)?;
    Record::new(read.columns, 0).map_err(|error| Error::format(path, error))
}

/// Reads the columns of these names, which must hold 64-bit floats.
///
/// # Errors
/// Those of [`read_parquet`], or a name that is not there.
pub fn read_parquet_columns(path: &Path, names: &[&str]) -> Result<Record, Error> {
    let read = read_some(path, &|name| names.contains(&name))?;
    if let Some(missing) = names.iter().find(|name| read.columns.iter().all(|column| column.name != **name)) {
        return Err(Error::format(path, format!("no column {missing}; found {}", read.names.join(", "))));
    }
    Record::new(read.columns, 0).map_err(|error| Error::format(path, error))
}

/// The columns asked for, and the names of all.
pub struct ParquetColumns {
    pub columns: Vec<Column>,
    pub names: Vec<String>,
}

/// Reads the columns that are `wanted`.
pub fn read_some(path: &Path, wanted: &(dyn Fn(&str) -> bool + Sync)) -> Result<ParquetColumns, Error> {
    let file = regular(path)?;
    // The decoder panics on some pages that are not what the file's metadata says.
    decoded(path, || read(file, wanted).map_err(|error| Error::format(path, error)))
}

fn write(file: File, record: &Record) -> Result<(), ParquetError> {
    let mut writer = begin(file, record)?;
    append_group(&mut writer, record)?;
    writer.close().map(drop)
}

fn begin(file: File, record: &Record) -> Result<SerializedFileWriter<File>, ParquetError> {
    let fields = record.columns().iter().map(|column| {
        let field = Type::primitive_type_builder(&column.name, Physical::DOUBLE);
        field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    });
    let schema = Type::group_type_builder("schema").with_fields(fields.collect::<Result<_, _>>()?).build()?;
    SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties(record)))
}

/// Writes the rows as a row group, if there are any.
fn append_group(writer: &mut SerializedFileWriter<File>, record: &Record) -> Result<(), ParquetError> {
    if record.rows() == 0 {
        return Ok(());
    }
    let mut group = writer.next_row_group()?;
    for column in record.columns() {
        if let Some(mut out) = group.next_column()? {
            out.typed::<DoubleType>().write_batch(&column.values, None, None)?;
            out.close()?;
        }
    }
    group.close().map(drop)
}

fn read(mut file: File, wanted: &dyn Fn(&str) -> bool) -> Result<ParquetColumns, ParquetError> {
    let size = file.metadata()?.len();
    if let Some(length) = thrift::footer_length(&mut file)?.filter(|length| *length > thrift::LARGEST_FOOTER)
    {
        let most = thrift::LARGEST_FOOTER;
        return Err(ParquetError::General(format!(
            "its footer claims {length} bytes; read are at most {most}"
        )));
    }
    if !thrift::footer_ends(&mut file)? {
        return Err(ParquetError::General("its footer holds more elements than bytes".into()));
    }
    let pages = file.try_clone()?;
    let reader = SerializedFileReader::new(file)?;
    let metadata = reader.metadata().file_metadata();
    let described = metadata.key_value_metadata().into_iter().flatten().find(|pair| pair.key == KEY);
    let described =
        described.and_then(|pair| serde_json::from_str::<Descriptions>(pair.value.as_deref()?).ok());
    let described = described.unwrap_or_default();
    let schema = metadata.schema_descr();
    let names: Vec<String> = schema.columns().iter().map(|column| column.name().to_owned()).collect();
    if names.len() > MOST_COLUMNS {
        let count = names.len();
        return Err(ParquetError::General(format!("{count} columns; read are at most {MOST_COLUMNS}")));
    }
    let indices: Vec<usize> = (0..names.len()).filter(|index| wanted(&names[*index])).collect();
    let claimed: i64 = reader.metadata().row_groups().iter().map(|group| group.num_rows().max(0)).sum();
    if claimed.saturating_mul(indices.len() as i64) > MOST_NUMBERS as i64 {
        let count = indices.len();
        return Err(ParquetError::General(format!(
            "{claimed} rows of {count} columns of use; read are at most {MOST_NUMBERS} numbers"
        )));
    }
    let chunks = reader.metadata().row_groups().iter();
    check_all(chunks.flat_map(|group| indices.iter().filter_map(|i| group.columns().get(*i))), size, pages)?;
    let mut columns: Vec<Column> =
        indices.iter().map(|index| column(&names[*index], described.get(&names[*index]))).collect();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        for (index, column) in indices.iter().zip(&mut columns) {
            let gaps = group.metadata().column(*index).column_descr().max_def_level() > 0;
            append(column, group.get_column_reader(*index)?, rows, gaps)?;
        }
    }
    Ok(ParquetColumns { columns, names })
}

/// Refuses column chunks that are damaged, or together longer than the file.
fn check_all<'a>(
    chunks: impl Iterator<Item = &'a ColumnChunkMetaData>,
    size: u64,
    mut file: File,
) -> Result<(), ParquetError> {
    let mut left = size;
    for chunk in chunks {
        let shared = || ParquetError::General(format!("column {} lies upon others", chunk.column_path()));
        check(chunk, size, &mut file)?;
        left = left.checked_sub(chunk.compressed_size().unsigned_abs()).ok_or_else(shared)?;
    }
    Ok(())
}

/// Refuses a column chunk that does not lie within a file of `size` bytes, or with endless pages: the reader takes it
/// for granted.
fn check(chunk: &ColumnChunkMetaData, size: u64, file: &mut File) -> Result<(), ParquetError> {
    let start = chunk.dictionary_page_offset().unwrap_or(chunk.data_page_offset());
    let end = start.checked_add(chunk.compressed_size()).and_then(|end| u64::try_from(end).ok());
    let lies_within = start >= 0 && chunk.compressed_size() >= 0 && end.is_some_and(|end| end <= size);
    let broken = |what: &str| Err(ParquetError::General(format!("column {} {what}", chunk.column_path())));
    if !lies_within || chunk.num_values() < 0 || chunk.uncompressed_size() < 0 {
        return broken("does not lie within the file");
    }
    if !matches!(chunk.compression(), Compression::UNCOMPRESSED | Compression::SNAPPY) {
        let codec = format!("{:?}", chunk.compression());
        let codec = codec.split('(').next().unwrap_or_default().to_lowercase();
        return broken(&format!(
            "is compressed by {codec}: allowed are snappy and none (pandas: df.to_parquet(path, compression=\"snappy\"))"
        ));
    }
    let (start, length) = (start.unsigned_abs(), chunk.compressed_size().unsigned_abs());
    // A page of each value, a dictionary, and one that is empty.
    match thrift::pages_end(file, start, length, chunk.num_values().unsigned_abs().saturating_add(2))? {
        true => Ok(()),
        false => broken("has a damaged page header"),
    }
}

/// Appends `rows` numbers; with `gaps`, those that are not there as not-a-number.
fn append(column: &mut Column, reader: ColumnReader, rows: usize, gaps: bool) -> Result<(), ParquetError> {
    if !matches!(reader, ColumnReader::DoubleColumnReader(_)) {
        let name = &column.name;
        return Err(ParquetError::General(format!("column {name} does not hold 64-bit floats")));
    }
    let mut reader = get_typed_column_reader::<DoubleType>(reader);
    // A damaged file may claim any number of rows: memory grows with what is there.
    let (mut values, mut present) = (Vec::with_capacity(rows.min(PREPARED)), Vec::new());
    let mut left = rows;
    while left > 0 {
        let (read, _, _) =
            reader.read_records(left.min(PREPARED), gaps.then_some(&mut present), None, &mut values)?;
        if read == 0 {
            break;
        }
        left -= read;
    }
    let mut values = values.into_iter();
    if gaps {
        let number = |there: i16| if there > 0 { values.next().unwrap_or(f64::NAN) } else { f64::NAN };
        column.values.extend(present.into_iter().map(number));
    } else {
        column.values.extend(values);
    }
    Ok(())
}

/// Neighbouring samples differ little: splitting their bytes into streams packs them well.
fn properties(record: &Record) -> WriterProperties {
    let described: Vec<arrow_schema::ColumnMetadata> =
        record.columns().iter().map(|column| (column.name.as_str(), metadata(column))).collect();
    let json: serde_json::Map<String, serde_json::Value> =
        filled(described.iter().map(|(name, metadata)| {
            let pairs = metadata.iter().map(|(key, value)| ((*key).to_owned(), value.as_str().into()));
            ((*name).to_owned(), serde_json::Value::Object(filled(pairs)))
        }));
    let attributes = attributes(record);
    let pairs = vec![
        KeyValue::new(KEY.into(), serde_json::Value::Object(json).to_string()),
        KeyValue::new(arrow_schema::KEY.into(), arrow_schema::encoded(&described, &[(PANDAS, &attributes)])),
        KeyValue::new(PANDAS.into(), attributes),
    ];
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::BYTE_STREAM_SPLIT)
        .set_created_by("wingbeat".into())
        .set_key_value_metadata(Some(pairs))
        .build()
}

/// Units and frames by column, of those that have one: `{"units": {"roll": "rad"}, "frames": {"roll": "WB"}}`.
fn attributes(record: &Record) -> String {
    let by_column = |text: fn(&Column) -> &String| {
        let pairs = record.columns().iter().filter(|column| !text(column).is_empty());
        let pairs = pairs.map(|column| (column.name.clone(), text(column).as_str().into()));
        serde_json::Value::Object(filled(pairs))
    };
    let (units, frames) = (by_column(|column| &column.unit), by_column(|column| &column.frame));
    serde_json::json!({ "units": units, "frames": frames }).to_string()
}

/// Unit, frame and limits, those that there are.
fn metadata(column: &Column) -> Vec<(&'static str, String)> {
    let texts = [("unit", &column.unit), ("frame", &column.frame)].into_iter();
    let texts = texts.filter(|(_, text)| !text.is_empty()).map(|(key, text)| (key, text.clone()));
    let limits = [("low", column.low), ("high", column.high)].into_iter();
    let limits = limits.filter(|(_, limit)| limit.is_finite()).map(|(key, limit)| (key, limit.to_string()));
    texts.chain(limits).collect()
}

fn column(name: &str, metadata: Option<&BTreeMap<String, String>>) -> Column {
    let text = |key: &str| metadata.and_then(|metadata| metadata.get(key)).cloned().unwrap_or_default();
    let number = |key: &str, otherwise: f64| text(key).parse().unwrap_or(otherwise);
    Column {
        low: number("low", f64::NEG_INFINITY),
        high: number("high", f64::INFINITY),
        ..Column::new(name, text("unit"), text("frame"))
    }
}
