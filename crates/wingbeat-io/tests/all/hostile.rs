//! Files made to harm: small ones that ask for much, ones without an end, and ones that contradict themselves.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use wingbeat::rig::process::InputSpec;
use wingbeat_io::samples::{ImportedRecord, read_samples};
use wingbeat_io::{Error, parse_urdf, read_csv, read_parquet, urdf_as_toml};

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("hostile");
    fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn take(path: &Path, with: &str) -> Result<ImportedRecord, Error> {
    let input: InputSpec = toml::from_str(with).unwrap();
    read_samples(path, &input)?.import(&input)
}

/// The refusal of a file of these bytes; it names the file and comes within seconds.
fn refusal(name: &str, bytes: &[u8], with: &str) -> String {
    let path = scratch(name);
    fs::write(&path, bytes).unwrap();
    let began = Instant::now();
    let message = take(&path, with).unwrap_err().to_string();
    assert!(message.contains(name), "{message}");
    assert!(began.elapsed().as_secs_f64() < 20.0, "{name}: {:?}", began.elapsed());
    message
}

/// A table with time in seconds and six channels.
fn csv(header: &str, rows: usize) -> String {
    let mut text = format!("{header}\n");
    let columns = header.split(',').count();
    for k in 0..rows {
        let cells: Vec<String> = (0..columns).map(|c| format!("{}", (k + c) as f64 * 1e-3)).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

const HEADER: &str = "time_s,fx_N,fy_N,fz_N,tx_Nm,ty_Nm,tz_Nm";

/// An npy file that claims this shape, with so many bytes of zeros behind its header.
fn npy(shape: &str, kind: &str, body: usize) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.resize(bytes.len() + body, 0);
    bytes
}

/// So many MB of zeros as deflate packs them, about a thousandth of it.
fn deflated(megabytes: usize, before: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(before).unwrap();
    let zeros = vec![0; 1 << 20];
    (0..megabytes).for_each(|_| encoder.write_all(&zeros).unwrap());
    encoder.finish().unwrap()
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// A matrix of MATLAB level 5: flags, dimensions, name, and the begin of the real part.
fn matrix(name: &str, rows: u32, columns: u32) -> Vec<u8> {
    let size = rows.wrapping_mul(columns).wrapping_mul(8);
    let body = words(&[6, 8, 6, 0, 5, 8, rows, columns, 1, name.len() as u32]);
    let mut bytes = [words(&[14, 56_u32.wrapping_add(size)]), body, name.as_bytes().to_vec()].concat();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    [bytes, words(&[9, size])].concat()
}

fn matlab_header() -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes
}

#[test]
fn matlab_arrays_that_ask_for_more_than_is_read_are_refused() {
    // It claims 2 GiB.
    let packed = deflated(64, &matrix("Fx", 1 << 28, 1));
    assert!(packed.len() < 1 << 17);
    let bytes = [matlab_header(), words(&[15, packed.len() as u32]), packed].concat();
    assert!(refusal("bomb.mat", &bytes, "").contains("Fx"));
    // 9 arrays of 64 MiB each, every one within the limit.
    let packed = deflated(64, &matrix("Fx", 1 << 23, 1));
    let one = [words(&[15, packed.len() as u32]), packed].concat();
    let bytes = [matlab_header(), one.repeat(9)].concat();
    assert!(refusal("bombs.mat", &bytes, "").contains("more than 67108864 numbers"));
    for (rows, columns) in [(u32::MAX, 1), (1 << 31, 1 << 31), (70_000, 70_000), (1 << 26, 1)] {
        let bytes = [matlab_header(), matrix("Fx", rows, columns)].concat();
        refusal("claim.mat", &bytes, "");
    }
}

#[test]
fn numpy_arrays_that_ask_for_more_than_is_read_are_refused() {
    for shape in ["(18446744073709551615,)", "(4294967296, 4294967296)", "(268435456,)", "(67108864, 1)"] {
        let message = refusal("claim.npy", &npy(shape, "<f8", 64), "columns.Fx = \"claim\"");
        assert!(message.contains("numbers") || message.contains("cut short"), "{message}");
    }
    let wide = npy("(9000, 9000)", "|u1", 81_000_000);
    assert!(refusal("wide.npy", &wide, "").contains("more than 4096 columns"));
    let header = [b"\x93NUMPY\x02\x00".to_vec(), words(&[u32::MAX])].concat();
    assert!(refusal("header.npy", &header, "").contains("no npy header"));
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    writer.start_file("Fx.npy", options).unwrap();
    writer.write_all(&npy("(268435456,)", "<f8", 0)).unwrap();
    let zeros = vec![0; 1 << 20];
    (0..64).for_each(|_| writer.write_all(&zeros).unwrap());
    let bytes = writer.finish().unwrap().into_inner();
    assert!(bytes.len() < 1 << 17, "{}", bytes.len());
    assert!(refusal("bomb.npz", &bytes, "").contains("Fx"));
}

#[test]
fn a_cut_fortran_array_names_a_sample_that_it_has() {
    let bytes =
        fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/samples/matrix.npy")).unwrap();
    let fortran = String::from_utf8_lossy(&bytes).contains("'fortran_order': True");
    let lines: String = (0..6)
        .map(|i| format!("columns.{} = \"cut[{i}]\"\n", ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"][i]))
        .collect();
    let message = refusal("cut.npy", &bytes[..bytes.len() - 1700], &lines);
    let (sample, of) = message.split_once("at sample ").unwrap().1.split_once(" of ").unwrap();
    let length: usize = of.split_whitespace().next().unwrap().parse().unwrap();
    assert!(sample.parse::<usize>().unwrap() < length, "{fortran} {message}");
}

#[test]
fn groups_of_hdf5_that_hold_themselves_end() {
    let bytes = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/samples/groups.h5")).unwrap();
    // Entries of symbol tables: offset of the name, then the address of the object. Each is made the root group.
    let root = bytes[64..72].to_vec();
    let mut looped = bytes.clone();
    let nodes: Vec<usize> = (0..bytes.len() - 8).filter(|at| &bytes[*at..*at + 4] == b"SNOD").collect();
    assert!(!nodes.is_empty());
    for node in nodes {
        let entries = u16::from_le_bytes([bytes[node + 6], bytes[node + 7]]);
        for entry in 0..usize::from(entries) {
            let at = node + 8 + 40 * entry + 8;
            looped[at..at + 8].copy_from_slice(&root);
        }
    }
    let path = scratch("looped.h5");
    fs::write(&path, &looped).unwrap();
    let began = Instant::now();
    let message = take(&path, "").unwrap_err().to_string();
    assert!(message.contains("looped.h5") && began.elapsed().as_secs_f64() < 5.0, "{message}");
}

#[test]
fn a_parquet_file_of_constants_is_refused_before_it_is_read() {
    use parquet::data_type::DoubleType;
    use parquet::file::writer::SerializedFileWriter;
    let schema = parquet::schema::parser::parse_message_type("message m { required double Fx; }").unwrap();
    let path = scratch("constants.parquet");
    // One page of one run of equal indices: 70 million numbers in 700 bytes.
    let properties = parquet::file::properties::WriterProperties::builder()
        .set_data_page_row_count_limit(1 << 30)
        .set_write_batch_size(1 << 20)
        .build();
    let file = fs::File::create(&path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema.into(), properties.into()).unwrap();
    let zeros = vec![0.0; 1 << 20];
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    for _ in 0..70 {
        column.typed::<DoubleType>().write_batch(&zeros, None, None).unwrap();
    }
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    assert!(fs::metadata(&path).unwrap().len() < 4096);
    for message in [read_parquet(&path).unwrap_err().to_string(), take(&path, "").unwrap_err().to_string()] {
        assert!(message.contains("73400320 rows of 1 columns"), "{message}");
    }
}

#[test]
fn a_parquet_footer_of_lists_without_an_end_is_refused() {
    // An unknown field: a thousand lists of 2^31 - 1 truth values each, which take no bytes.
    let mut footer = vec![0xf9, 0xf9, 0xe8, 0x07];
    (0..1000).for_each(|_| footer.extend([0xf1, 255, 255, 255, 255, 7]));
    footer.push(0);
    let mut bytes = b"PAR1".to_vec();
    bytes.extend(&footer);
    bytes.extend((footer.len() as u32).to_le_bytes());
    bytes.extend(b"PAR1");
    assert!(refusal("endless.parquet", &bytes, "").contains("more elements than bytes"));
    let began = Instant::now();
    let message = read_parquet(&scratch("endless.parquet")).unwrap_err().to_string();
    assert!(message.contains("more elements than bytes"), "{message}");
    assert!(began.elapsed().as_secs_f64() < 5.0, "{:?}", began.elapsed());
}

#[test]
fn what_has_no_end_is_not_read() {
    for path in ["/dev/zero", "/dev/full", "/proc", "/tmp"].map(Path::new).into_iter().filter(|p| p.exists())
    {
        let messages = [
            take(path, "").unwrap_err().to_string(),
            read_csv(path).unwrap_err().to_string(),
            read_parquet(path).unwrap_err().to_string(),
        ];
        for message in messages {
            assert!(message.contains("not a regular file") && message.contains(path.to_str().unwrap()));
        }
    }
    let link = scratch("zero.urdf");
    let _ = fs::remove_file(&link);
    std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
    assert!(urdf_as_toml(&link, None).unwrap().unwrap_err().contains("not a regular file"));
    // A line without end: 300 MiB of them take no place on the disk.
    let path = scratch("line.csv");
    fs::write(&path, csv(HEADER, 60)).unwrap();
    fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(300 << 20).unwrap();
    assert!(take(&path, "").unwrap_err().to_string().contains("line 62 is longer than"));
    assert!(read_csv(&path).unwrap_err().to_string().contains("most that is read"));
    fs::remove_file(path).unwrap();
    let quoted = csv(HEADER, 3) + "\"" + &csv(HEADER, 30_000);
    assert!(refusal("quoted.csv", quoted.as_bytes(), "").contains("line 5"));
    let wide = vec!["x"; 5000].join(",") + "\n1\n";
    assert!(refusal("wide.csv", wide.as_bytes(), "").contains("5000 columns"));
}

#[test]
fn a_table_cut_inside_its_last_number_is_not_taken_for_whole() {
    let text = csv(HEADER, 20);
    for cut in 1..12 {
        let part = &text[..text.len() - cut];
        assert!(refusal("cut.csv", part.as_bytes(), "").contains("cut short at sample 19"), "{cut}");
        assert!(read_csv(&scratch("cut.csv")).is_err());
    }
    let path = scratch("whole.csv");
    fs::write(&path, &text).unwrap();
    assert_eq!(take(&path, "").unwrap().import.rows, 20);
    fs::write(&path, text.replace('\n', "\r\n")).unwrap();
    assert_eq!(take(&path, "").unwrap().import.rows, 20);
}

#[test]
fn columns_that_could_be_one_channel_or_two_are_refused() {
    let twice = |header: &str, with: &str| refusal("twice.csv", csv(header, 9).as_bytes(), with);
    let message = twice(&format!("{HEADER},force_x_N"), "");
    assert!(message.contains("fx_N, force_x_N could all be Fx") && message.contains("columns.Fx=NAME"));
    assert!(twice(&format!("{HEADER},mx_Nm"), "").contains("could all be Tx"));
    assert!(twice(&format!("{HEADER},time"), "").contains("time_s, time could all be t"));
    assert!(twice(&format!("{HEADER},fx_N"), "columns.Fx = \"fx_N\"").contains("several columns are called"));
    let message = twice(HEADER, "columns.Fx = \"fy_N\"");
    assert!(message.contains("column fy_N would be Fx and Fy"), "{message}");
    assert!(twice(HEADER, "columns.t = \"fy_N\"").contains("column fy_N would be Fy and t"));
    // Named, there is no doubt.
    let path = scratch("named.csv");
    fs::write(&path, csv(&format!("{HEADER},force_x_N"), 9)).unwrap();
    let fx = take(&path, "columns.Fx = \"force_x_N\"").unwrap();
    assert_eq!(fx.record.values("Fx").unwrap()[0], 7e-3);
}

#[test]
fn units_that_contradict_one_another_are_refused() {
    let path = scratch("units.csv");
    let refused = |text: &str, with: &str| {
        fs::write(&path, text).unwrap();
        take(&path, with).unwrap_err().to_string()
    };
    let message = refused(&csv(HEADER, 9), "units.force = \"lbf\"");
    assert!(
        message.contains("unit lbf by process.input.units.force, but N by the column's name"),
        "{message}"
    );
    let lines = format!("# units: s, mN, mN, mN, N m, N m, N m\n{}", csv(HEADER, 9));
    assert!(refused(&lines, "").contains("unit mN by the file, but N by the column's name"));
    let message = refused(&csv(HEADER, 9), "counts_per_newton = 1e6");
    assert!(message.contains("process.input.counts_per_newton is for columns in counts"), "{message}");
    // The same unit by two names is no contradiction, and a unit that nobody knows may be explained.
    fs::write(&path, csv(HEADER, 9)).unwrap();
    assert!(take(&path, "units.moment = \"N-m\"").is_ok());
    fs::write(&path, csv(&HEADER.replace("fx_N", "fx [newton]"), 9)).unwrap();
    assert!(take(&path, "").unwrap_err().to_string().contains("unit `newton` is not known"));
}

#[test]
fn a_rate_that_the_file_contradicts_is_followed_and_said() {
    let path = scratch("rate.csv");
    let whole = csv(HEADER, 500);
    let holed: String = whole
        .lines()
        .enumerate()
        .filter(|(k, _)| !(200..240).contains(k))
        .map(|(_, l)| format!("{l}\n"))
        .collect();
    fs::write(&path, holed).unwrap();
    let import = take(&path, "rate_hz = 1000").unwrap().import;
    let [caution] = import.cautions.as_slice() else { panic!("{:?}", import.cautions) };
    assert!(caution.contains("process.input.rate_hz = 1000 was followed"), "{caution}");
    assert!(caution.contains("time_s") && caution.contains("40 samples missing"), "{caution}");
    assert_eq!(take(&path, "").unwrap().import.missing, 40);
    fs::write(&path, &whole).unwrap();
    assert!(take(&path, "rate_hz = 1000").unwrap().import.cautions.is_empty());
    assert!(take(&path, "rate_hz = 7000").unwrap().import.cautions[0].contains("1000.000000 Hz"));
}

#[test]
fn factors_of_the_demo_application_have_a_range() {
    let name = "tests/data/samples/ati_counts.csv";
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap();
    let line = text.lines().find(|line| line.contains("Counts per Unit Force")).unwrap();
    for value in ["1e-320", "0", "-5", "nan", "inf", "1e300", "many"] {
        let changed = text.replace(line, &format!("Counts per Unit Force:,{value}").replace(":,", ": "));
        let message = refusal("factors.csv", changed.as_bytes(), "");
        assert!(message.contains("counts per unit force") && message.contains("allowed"), "{message}");
    }
}

/// A file of MATLAB level 4 with six channels and a time of eight samples, in either byte order.
fn level4(big_endian: bool) -> Vec<u8> {
    let word = |x: u32| if big_endian { x.to_be_bytes() } else { x.to_le_bytes() };
    let mut bytes = Vec::new();
    for (c, name) in ["t", "Fx", "Fy", "Fz", "Tx", "Ty", "Tz"].iter().enumerate() {
        let kind = if big_endian { 1000 } else { 0 };
        bytes.extend([kind, 8, 1, 0, name.len() as u32 + 1].iter().flat_map(|x| word(*x)));
        bytes.extend(name.as_bytes());
        bytes.push(0);
        for k in 0..8 {
            let value = (k as f64 + 10.0 * c as f64) * 1e-3;
            bytes.extend(if big_endian { value.to_be_bytes() } else { value.to_le_bytes() });
        }
    }
    bytes
}

#[test]
fn matlab_of_level_4_is_read_and_its_claims_are_bounded() {
    let units = "units = { force = \"N\", moment = \"N m\", time = \"s\" }";
    for big_endian in [false, true] {
        let path = scratch("level4.mat");
        let bytes = level4(big_endian);
        fs::write(&path, &bytes).unwrap();
        let imported = take(&path, units).unwrap();
        assert_eq!(imported.import.layout, "MATLAB 4");
        assert_eq!(imported.record.values("Tz").unwrap()[3], 0.063);
        assert!((imported.import.rate_hz - 1000.0).abs() < 1e-6);
        for cut in (1..bytes.len()).step_by(7) {
            assert!(refusal("cut4.mat", &bytes[..bytes.len() - cut], units).contains("cut4.mat"));
        }
        let mut huge = bytes.clone();
        huge[4..12].fill(0xff);
        refusal("huge4.mat", &huge, units);
    }
}

#[test]
fn links_nested_behind_a_false_end_are_counted() {
    let text = format!("<robot name='x'>{}", "<a>/>".repeat(80_000));
    let began = Instant::now();
    assert!(parse_urdf(&text, None).unwrap_err().contains("nested more than 256 deep"));
    assert!(began.elapsed().as_secs_f64() < 5.0);
    let entities = "<!DOCTYPE r [<!ENTITY a \"aaaa\">]><robot name='&a;'/>";
    assert!(parse_urdf(entities, None).unwrap_err().contains("DOCTYPE"));
}

/// A Parquet file of one column of so many numbers, its pages as they are in memory; its chunk ends where its footer begins.
fn plain_parquet(name: &str, rows: usize) -> (PathBuf, Vec<u8>, usize) {
    use parquet::data_type::DoubleType;
    let schema = parquet::schema::parser::parse_message_type("message m { required double Fx; }").unwrap();
    let path = scratch(name);
    let properties = parquet::file::properties::WriterProperties::builder()
        .set_dictionary_enabled(false)
        .set_offset_index_disabled(true)
        .set_statistics_enabled(parquet::file::properties::EnabledStatistics::Chunk)
        .build();
    let file = fs::File::create(&path).unwrap();
    let mut writer =
        parquet::file::writer::SerializedFileWriter::new(file, schema.into(), properties.into()).unwrap();
    let values: Vec<f64> = (0..rows).map(|k| (k as f64).sin()).collect();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    let bytes = fs::read(&path).unwrap();
    let tail = bytes.len() - 8;
    let footer = u32::from_le_bytes(bytes[tail..tail + 4].try_into().unwrap()) as usize;
    (path, bytes, tail - footer)
}

#[test]
fn a_parquet_chunk_of_headers_without_an_end_is_refused() {
    let (path, mut bytes, footer) = plain_parquet("zeros.parquet", 1 << 19);
    assert_eq!(read_parquet(&path).unwrap().rows(), 1 << 19);
    assert!(footer > 4_000_000, "{footer}");
    // An empty struct; then a page header without a page.
    for header in [&[0][..], &[0x15, 0, 0x15, 0, 0x15, 0, 0]] {
        bytes[4..footer].iter_mut().zip(header.iter().cycle()).for_each(|(byte, of)| *byte = *of);
        let began = Instant::now();
        assert!(refusal("zeros.parquet", &bytes, "").contains("damaged page header"));
        assert!(began.elapsed().as_secs_f64() < 1.0, "{:?}", began.elapsed());
    }
}

#[test]
fn parquet_chunks_that_share_their_bytes_are_refused() {
    use parquet::file::metadata::{ParquetMetaDataBuilder, ParquetMetaDataWriter};
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let (path, bytes, footer) = plain_parquet("shared.parquet", 5000);
    let metadata = SerializedFileReader::new(fs::File::open(&path).unwrap()).unwrap().metadata().clone();
    let groups = vec![metadata.row_group(0).clone(); 1000];
    let metadata = ParquetMetaDataBuilder::new_from_metadata(metadata).set_row_groups(groups).build();
    let mut shared = bytes[..footer].to_vec();
    let mut written = Vec::new();
    ParquetMetaDataWriter::new(&mut written, &metadata).finish().unwrap();
    shared.extend(written);
    let began = Instant::now();
    assert!(refusal("shared.parquet", &shared, "").contains("lies upon others"));
    assert!(began.elapsed().as_secs_f64() < 1.0, "{:?}", began.elapsed());
}

#[test]
fn a_parquet_footer_of_gigabytes_in_a_hole_is_refused_before_it_is_read() {
    use std::io::{Seek, SeekFrom, Write};
    let path = scratch("hole.parquet");
    let mut file = fs::File::create(&path).unwrap();
    file.write_all(b"PAR1").unwrap();
    // Two gigabytes that take no room on the disk.
    let length = 2_000_000_000_u32;
    file.seek(SeekFrom::Start(u64::from(length) + 4)).unwrap();
    file.write_all(&length.to_le_bytes()).unwrap();
    file.write_all(b"PAR1").unwrap();
    drop(file);
    let began = std::time::Instant::now();
    let message = read_parquet(&path).unwrap_err().to_string();
    assert!(message.contains("footer claims 2000000000 bytes; read are at most 67108864"), "{message}");
    assert!(began.elapsed().as_secs_f64() < 1.0, "{:?}", began.elapsed());
    fs::remove_file(path).unwrap();
}

#[test]
fn a_parquet_file_of_another_codec_is_refused_with_those_that_are_read() {
    let (path, bytes, _) = plain_parquet("codec.parquet", 4);
    // Path and codec of the column in the footer, as Thrift writes them.
    let field = b"\x19\x18\x02Fx\x15\x00";
    let at = bytes.windows(field.len()).position(|window| window == field).unwrap() + field.len() - 1;
    for (codec, name) in [(2, "gzip"), (6, "zstd"), (4, "brotli")] {
        let mut other = bytes.clone();
        other[at] = 2 * codec;
        fs::write(&path, other).unwrap();
        let message = read_parquet(&path).unwrap_err().to_string();
        assert!(message.contains(&format!("column \"Fx\" is compressed by {name}")), "{message}");
        assert!(message.contains("allowed are snappy and none"), "{message}");
    }
}
