//! Columns of numbers for NumPy (`.npz`: a ZIP archive of arrays, stored) and for MATLAB (`.mat`, level 4).

use flate2::Crc;
use wingbeat::simulate::Record;

/// Most letters of a variable of MATLAB.
const LONGEST: usize = 63;

/// The columns of `record` as a NumPy archive, an array for each.
///
/// # Errors
/// More than 2 GiB or 65535 columns.
pub fn npz(record: &Record) -> Result<Vec<u8>, String> {
    let columns = record.columns();
    if columns.len() > 65_535 {
        return Err(format!("{} columns are more than a .npz file holds: 65535", columns.len()));
    }
    super::record_fits("the .npz file", record, 8.0)?;
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for column in columns {
        let (name, at) = (format!("{}.npy", column.name), file.len() as u32);
        let array = npy(&column.values);
        let mut crc = Crc::new();
        crc.update(&array);
        // Version 2.0, names in UTF-8, stored, 1980-01-01.
        let mut entry = vec![20, 0, 0, 8, 0, 0, 0, 0, 33, 0];
        entry.extend(crc.sum().to_le_bytes());
        entry.extend([array.len() as u32, array.len() as u32].iter().flat_map(|size| size.to_le_bytes()));
        entry.extend((name.len() as u16).to_le_bytes());
        entry.extend([0, 0]);
        file.extend(b"PK\x03\x04");
        file.extend(&entry);
        file.extend(name.as_bytes());
        file.extend(array);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&entry);
        directory.extend([0; 10]);
        directory.extend(at.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (count, at, size) = (columns.len() as u16, file.len() as u32, directory.len() as u32);
    file.extend(directory);
    file.extend(b"PK\x05\x06\0\0\0\0");
    file.extend([count, count].iter().flat_map(|count| count.to_le_bytes()));
    file.extend([size, at].iter().flat_map(|number| number.to_le_bytes()));
    file.extend([0, 0]);
    Ok(file)
}

/// An array of NumPy, format 1.0.
fn npy(values: &[f64]) -> Vec<u8> {
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", values.len());
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut array = b"\x93NUMPY\x01\x00".to_vec();
    array.extend((header.len() as u16).to_le_bytes());
    array.extend(header.as_bytes());
    array.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    array
}

/// The columns of `record` as variables of MATLAB, letters that it does not take replaced by `_`.
///
/// # Errors
/// Two columns whose names become the same; more than 2 GiB.
pub fn mat(record: &Record) -> Result<Vec<u8>, String> {
    super::record_fits("the .mat file", record, 8.0)?;
    let (mut file, mut names): (Vec<u8>, Vec<String>) = (Vec::new(), Vec::new());
    for column in record.columns() {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut name: String = column.name.chars().map(plain).collect();
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            name.insert(0, 'x');
        }
        name.truncate(LONGEST);
        if names.contains(&name) {
            return Err(format!("two columns would be the variable {name} of MATLAB"));
        }
        // A real full matrix of doubles, the lowest byte first: rows, columns, no imaginary part, the name's length with its end.
        let head = [0, column.values.len() as u32, 1, 0, name.len() as u32 + 1];
        file.extend(head.iter().flat_map(|number| number.to_le_bytes()));
        file.extend(name.as_bytes());
        file.push(0);
        file.extend(column.values.iter().flat_map(|value| value.to_le_bytes()));
        names.push(name);
    }
    Ok(file)
}
