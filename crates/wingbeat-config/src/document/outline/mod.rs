//! Outlines in files: `planform = { file = "outline.csv", unit = "mm", x = "aft" }` stands for the stations in the file, a table
//! or a drawing.

mod contour;
pub(crate) mod drawing;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{ConfigError, KeyProblem, ValuePlace, Wrong};

/// The key of an outline.
pub const KEY: &str = "planform";
/// Most stations of a file. *Choice*: ten for each strip of the finest wing.
pub const MOST: usize = 10_000;
/// What the columns are called.
const COLUMNS: [&str; 3] = ["arc", "leading_edge", "trailing_edge"];

/// An outline in a file. A CSV file has a row for each station of the half wing, from the middle or the root to the tip; an ASCII DXF
/// file has its contour.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutlineFile {
    /// The file, relative to the document: a CSV with a header, then a row for each station (`#` starts a comment line), or a drawing
    /// whose name ends with `.dxf`.
    pub file: PathBuf,
    /// Of a CSV, names of the columns with arc length, leading edge and trailing edge; without it `arc`, `leading_edge` and
    /// `trailing_edge`, each also with the unit behind it: `arc_mm`.
    #[serde(default)]
    pub columns: Option<[String; 3]>,
    /// Unit of the columns, or of a drawing that does not say it.
    #[serde(default)]
    pub unit: Option<Length>,
    /// Which way the edges count from the hinge line; in a drawing, along the axis that is not `span`.
    #[serde(default)]
    pub x: Way,
    /// Of a drawing, its axis along the span, towards the tip; without it `y`.
    #[serde(default)]
    pub span: Option<Axis>,
    /// Of a drawing, the layer of the contour; without it all layers.
    #[serde(default)]
    pub layer: Option<String>,
    /// Of a drawing, the point [x, y] in the middle of the body on the hinge line, in its unit; without it [0, 0].
    #[serde(default)]
    pub origin: Option<[f64; 2]>,
}

/// An axis of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// To the right.
    X,
    /// Upward.
    Y,
}

/// What is wrong with a file: its line, a key below that of the outline, the value there, what is allowed.
pub struct OutlineFault {
    line: usize,
    key: &'static str,
    value: String,
    allowed: String,
}

/// Unit of a length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Length {
    /// Metres, where nothing is said.
    M,
    /// Centimetres.
    Cm,
    /// Millimetres.
    Mm,
    /// Inches of 25.4 mm.
    In,
}

/// Which way a coordinate along the chord counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// Forward positive, as in documents.
    #[default]
    Forward,
    /// Aft positive, as in most drawings of sections.
    Aft,
}

impl Length {
    const ALL: [Self; 4] = [Self::M, Self::Cm, Self::Mm, Self::In];

    fn name(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
            Self::In => "in",
        }
    }

    /// The number in `cell`, whose value is `value`, in metres: rounded once, so that 95.6 mm is the number that 0.0956 m is.
    fn metres(self, cell: &str, value: f64) -> f64 {
        let tens = match self {
            Self::M => return value,
            Self::In => return value * 0.0254,
            Self::Cm => -2,
            Self::Mm => -3,
        };
        format!("{cell}e{tens}").parse().unwrap_or(value * 10_f64.powi(tens))
    }
}

impl OutlineFile {
    /// The stations in the `text` of `file` as TOML, `v=[...]`, each on the line on which the file has it, so that what is said
    /// of them later names it; `key` is that of the outline.
    pub fn toml(&self, file: &Path, text: &str, key: &str) -> Result<String, ConfigError> {
        let is_drawing = file.extension().is_some_and(|end| end.eq_ignore_ascii_case("dxf"));
        let other =
            if is_drawing { self.columns.as_ref().map(|_| "columns") } else { self.key_of_drawings() };
        let found = match other {
            None if !is_drawing => return self.tabled(file, text, key),
            None => self.drawn(text),
            Some(other) => {
                let allowed = if is_drawing {
                    "none: a drawing has no columns"
                } else {
                    "none: only a drawing, .dxf, has it"
                };
                Err(OutlineFault { line: 1, key: other, value: "given".into(), allowed: allowed.into() })
            }
        };
        found.map_err(|fault| {
            let place = ValuePlace::Line(file.into(), fault.line);
            let key = format!("{key}.{}", fault.key);
            Wrong::new(place, key, Some(fault.value), KeyProblem::Value(fault.allowed)).into()
        })
    }

    /// A key that only a drawing has.
    fn key_of_drawings(&self) -> Option<&'static str> {
        let given = [
            ("span", self.span.is_some()),
            ("layer", self.layer.is_some()),
            ("origin", self.origin.is_some()),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(key, _)| key)
    }

    /// The stations of a drawing, all on the line on which its contour begins.
    fn drawn(&self, text: &str) -> Result<String, OutlineFault> {
        let fault = |line, key, value: &str, allowed: String| OutlineFault {
            line,
            key,
            value: value.into(),
            allowed,
        };
        let mut drawing = drawing::read(text)?;
        let unit = match (drawing.unit, self.unit) {
            (Some((said, line)), Some(given)) if said != given => {
                let allowed = format!("{}, which $INSUNITS of the drawing says", said.name());
                return Err(fault(line, "unit", given.name(), allowed));
            }
            (Some((said, _)), _) => said,
            (None, Some(given)) => given,
            (None, None) => {
                let allowed = "m, cm, mm or in: the drawing has no $INSUNITS that says it".into();
                return Err(fault(1, "unit", "not given", allowed));
            }
        };
        let mut layers: Vec<&str> = drawing.curves.iter().map(|curve| curve.layer).collect();
        layers.sort_unstable();
        layers.dedup();
        let layers = layers.join(", ");
        drawing.curves.retain(|curve| self.layer.as_ref().is_none_or(|layer| curve.layer == layer));
        if let Some(layer) = self.layer.as_ref().filter(|_| drawing.curves.is_empty()) {
            return Err(fault(1, "layer", layer, format!("a layer with lines or curves: {layers}")));
        }
        let origin = self.origin.unwrap_or_default();
        let forward = if self.x == Way::Aft { -1.0 } else { 1.0 };
        for point in drawing.curves.iter_mut().flat_map(|curve| &mut curve.points) {
            let [x, y] = [point[0] - origin[0], point[1] - origin[1]];
            *point = if self.span == Some(Axis::X) { [x, forward * y] } else { [y, forward * x] };
        }
        let contour = contour::Contour::joined(drawing.curves, &layers)?;
        let mut out = "\n".repeat(contour.line - 1) + "v=[";
        for station in contour.stations(unit)? {
            out += &entry(station.map(|value| unit.metres(&value.to_string(), value) + 0.0));
        }
        Ok(out + "]")
    }

    /// The stations of a table.
    fn tabled(&self, file: &Path, text: &str, key: &str) -> Result<String, ConfigError> {
        let mut out = String::from("v=[");
        let mut header: Option<([usize; 3], Length)> = None;
        let mut stations = 0;
        for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let wrong = |key: String, value: &str, allowed: String| -> ConfigError {
                let place = ValuePlace::Line(file.into(), index + 1);
                Wrong::new(place, key, Some(value.to_owned()), KeyProblem::Value(allowed)).into()
            };
            if index > 0 {
                out.push('\n');
            }
            if line.trim().is_empty() || line.starts_with('#') {
                continue;
            }
            let cells: Vec<&str> = line.split(',').map(|cell| cell.trim().trim_matches('"')).collect();
            let Some((places, unit)) = &header else {
                let found = self.header(&cells);
                header = Some(
                    found.map_err(|(at, value, allowed)| wrong(format!("{key}.{at}"), &value, allowed))?,
                );
                continue;
            };
            if stations == MOST {
                return Err(wrong(key.into(), line, format!("at most {MOST} stations")));
            }
            let mut numbers = [0.0; 3];
            for ((number, place), name) in numbers.iter_mut().zip(places).zip(COLUMNS) {
                let cell = cells.get(*place).copied().unwrap_or("");
                let value: Option<f64> = cell.parse().ok().filter(|value: &f64| value.is_finite());
                let allowed =
                    || format!("a finite number in column {}, with a point for decimals", place + 1);
                let value =
                    value.ok_or_else(|| wrong(format!("{key}[{stations}].{name}"), cell, allowed()))?;
                let metres = unit.metres(cell, value);
                *number = if self.x == Way::Aft && name != COLUMNS[0] { 0.0 - metres } else { metres };
            }
            out += &entry(numbers);
            stations += 1;
        }
        if stations == 0 {
            let allowed = "a header and a row for each station".to_owned();
            let given = Some(format!("{:?}", self.file.display().to_string()));
            return Err(
                Wrong::new(ValuePlace::File(file.into()), key, given, KeyProblem::Value(allowed)).into()
            );
        }
        out.push(']');
        Ok(out)
    }

    /// Where the columns stand, and their unit; else the key at fault, its value, and what is allowed.
    fn header(&self, names: &[&str]) -> Result<([usize; 3], Length), (&'static str, String, String)> {
        let found = || names.join(", ");
        let mut units = self.unit.map(|unit| (unit, "unit".to_owned())).into_iter().collect::<Vec<_>>();
        let mut places = [0; 3];
        for (i, place) in places.iter_mut().enumerate() {
            let at = match &self.columns {
                Some(columns) => names.iter().position(|name| *name == columns[i]),
                None => names.iter().position(|name| split(name).0 == COLUMNS[i]),
            };
            let Some(at) = at else {
                return Err(match &self.columns {
                    Some(columns) => ("columns", columns[i].clone(), format!("one of {}", found())),
                    None => {
                        let wanted =
                            "columns arc, leading_edge and trailing_edge, or their names in `columns`";
                        ("file", found(), wanted.to_owned())
                    }
                });
            };
            *place = at;
            units.extend(split(names[at]).1.map(|unit| (unit, format!("column {}", names[at]))));
        }
        let (unit, by) = units.first().cloned().unwrap_or((Length::M, String::new()));
        match units.iter().find(|(other, _)| *other != unit) {
            None => Ok((places, unit)),
            Some((other, name)) => {
                let allowed = format!("one unit; {by} says {}, {name} says {}", unit.name(), other.name());
                Err(("unit", unit.name().into(), allowed))
            }
        }
    }
}

/// A station as TOML.
fn entry([arc, leading, trailing]: [f64; 3]) -> String {
    format!("{{arc_m={arc:?},leading_edge_m={leading:?},trailing_edge_m={trailing:?}}},")
}

/// A name of a column without its unit, and the unit.
fn split(name: &str) -> (&str, Option<Length>) {
    let unit = |text: &str| Length::ALL.into_iter().find(|unit| unit.name() == text);
    match name.rsplit_once('_') {
        Some((start, end)) if unit(end).is_some() => (start, unit(end)),
        _ => (name, None),
    }
}
