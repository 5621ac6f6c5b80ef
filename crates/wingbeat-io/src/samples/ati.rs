//! The files of ATI's Net F/T demo application.
//!
//! Layout (ATI Industrial Automation, Net F/T Installation and Operation Manual 9620-05-NET FT, "Demo CSV file
//! format", and the application itself): lines `Start Time:`, `RDT Sample Rate:`, `Force Units:`,
//! `Counts per Unit Force:`, `Torque Units:`, `Counts per Unit Torque:`, then the header
//! `Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time` and rows with all values in
//! quotes. The manual says that the channels are counts; later versions of the application divide
//! them by the counts per unit before writing. Whole numbers are counts, numbers with a point are units:
//! a division always leaves a point. The time is the host's, to a second: samples are placed by their sequence.

use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::netft::COUNTS_PER_UNIT as COUNTS;
use wingbeat::simulate::Column;

use super::table::SampleTable;
use super::text::TextColumn;
use crate::Error;

/// Sample rates that a file may state, Hz (*choice*: once in 17 minutes to 1 MHz).
const RATES: [f64; 2] = [1e-3, 1e6];

/// True of the line that names the columns.
pub fn is_header(line: &str) -> bool {
    let line = line.to_lowercase();
    line.contains("rdt") && line.contains("sequence") && line.contains("fx") && line.contains("tz")
}

/// Turns the columns of a file with these lines above its header into a table.
pub fn fill(
    table: &mut SampleTable,
    preamble: &[String],
    names: &[String],
    cells: Vec<TextColumn>,
) -> Result<(), Error> {
    let said = |key: &str| said(preamble, key);
    let number = |key: &str, [low, high]: [f64; 2]| -> Result<Option<f64>, Error> {
        let Some(text) = said(key) else { return Ok(None) };
        let number = text.parse().ok().filter(|number| (low..=high).contains(number));
        let refused = || table.bad(format!("`{key}: {text}`: allowed is a number from {low:e} to {high:e}"));
        number.ok_or_else(refused).map(Some)
    };
    let rate = number("rdt sample rate", RATES)?;
    let per_unit = [number("counts per unit force", COUNTS)?, number("counts per unit torque", COUNTS)?];
    table.rate = rate;
    table.unordered = true;
    for (name, cells) in names.iter().zip(cells) {
        if cells.words {
            table.skipped.push(name.clone());
            continue;
        }
        let Some(index) = CHANNELS.iter().position(|(channel, _)| channel.eq_ignore_ascii_case(name)) else {
            if cells.wanted {
                table.columns.push(Column { values: cells.values, ..Column::new(plain(name), "", "") });
            }
            continue;
        };
        let kind = if index < 3 { "force" } else { "torque" };
        let unit = said(&format!("{kind} units")).unwrap_or("");
        let scale = if cells.whole { per_unit[usize::from(index >= 3)] } else { Some(1.0) };
        let (unit, scale) = scale.map_or(("counts", 1.0), |scale| (unit, scale));
        let values = cells.values.iter().map(|value| value / scale).collect();
        table.columns.push(Column { values, ..Column::new(CHANNELS[index].0, unit, "") });
    }
    Ok(())
}

/// The name that the recorder gives this column.
pub fn plain(name: &str) -> String {
    match name.to_lowercase().replace(' ', "").as_str() {
        "status(hex)" | "status" => "status".into(),
        "rdtsequence" => "rdt_sequence".into(),
        "f/tsequence" => "ft_sequence".into(),
        _ => name.into(),
    }
}

/// What stands behind `key:` above the header; spreadsheets leave quotes and commas at the ends.
fn said<'a>(preamble: &'a [String], key: &str) -> Option<&'a str> {
    preamble.iter().find_map(|line| {
        let (found, value) = line.trim_matches(['"', ',', ';', '\t', ' ']).split_once(':')?;
        found.trim().eq_ignore_ascii_case(key).then(|| value.trim().trim_matches(['"', ',', ' ']))
    })
}
