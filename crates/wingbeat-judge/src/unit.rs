//! Units of measured channels, by the names that boxes and files give them.

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelQuantity {
    /// SI unit N.
    Force,
    /// SI unit N m.
    Moment,
    /// SI unit s.
    Time,
    /// SI unit rad.
    Angle,
}

/// Newtons in each unit of force.
const FORCE: [(&str, f64); 11] = [
    ("N", 1.0),
    ("mN", 1e-3),
    ("uN", 1e-6),
    ("kN", 1e3),
    ("lbf", 4.448_221_615_260_5),
    ("klbf", 4_448.221_615_260_5),
    ("ozf", 0.278_013_850_953_781_2),
    ("dyn", 1e-5),
    ("gf", 9.80665e-3),
    ("kgf", 9.80665),
    ("kg", 9.80665), // as ATI's boxes write kgf
];
/// Newton metres in each unit of moment.
const MOMENT: [(&str, f64); 15] = [
    ("N m", 1.0),
    ("N mm", 1e-3),
    ("N cm", 1e-2),
    ("mN m", 1e-3),
    ("mN mm", 1e-6),
    ("uN m", 1e-6),
    ("kN m", 1e3),
    ("ozf-in", 0.007_061_551_814_226_04),
    ("lbf-in", 0.112_984_829_027_616_7),
    ("lbf-ft", 1.355_817_948_331_400_4),
    ("kgf-cm", 0.098_066_5),
    ("kg-cm", 0.098_066_5),
    ("kgf-m", 9.80665),
    ("kgf-mm", 9.80665e-3),
    ("gf-cm", 9.80665e-5),
];
/// Seconds in each unit of time.
const TIME: [(&str, f64); 3] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6)];
/// Radians in each unit of angle.
const ANGLE: [(&str, f64); 3] =
    [("rad", 1.0), ("deg", wingbeat_math::RADIANS), ("turn", std::f64::consts::TAU)];

impl ChannelQuantity {
    /// Every quantity.
    pub const ALL: [Self; 4] = [Self::Force, Self::Moment, Self::Time, Self::Angle];

    /// SI units in the unit called `name`; upper and lower case, blanks, points and hyphens do not count.
    pub fn factor(self, name: &str) -> Option<f64> {
        let name = plain(name);
        self.table().iter().find(|(known, _)| plain(known) == name).map(|entry| entry.1)
    }

    /// The names that are known, the SI unit first.
    pub fn names(self) -> Vec<&'static str> {
        self.table().iter().map(|entry| entry.0).collect()
    }

    fn table(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Force => &FORCE,
            Self::Moment => &MOMENT,
            Self::Time => &TIME,
            Self::Angle => &ANGLE,
        }
    }
}

/// Whether a channel is a force or a moment: by its unit, where that is known, else by its name, `Fx` to `Tz`. Where no channel of a file is
/// one, all may be.
pub fn is_load(name: &str, unit: &str) -> bool {
    let of = |quantity: ChannelQuantity| quantity.factor(unit).is_some();
    let component = || {
        let name: Vec<char> = name.chars().map(|c| c.to_ascii_lowercase()).collect();
        matches!(name[..], ['f' | 'm' | 't', 'x'..='z'])
    };
    match ChannelQuantity::ALL.into_iter().find(|quantity| of(*quantity)) {
        Some(known) => matches!(known, ChannelQuantity::Force | ChannelQuantity::Moment),
        None => component(),
    }
}

fn plain(name: &str) -> String {
    let letters = name.trim().chars().filter(|c| !matches!(c, ' ' | '-' | '.' | '*' | '·' | '_'));
    // The sign of micro has two codes.
    let text =
        letters.map(|c| if matches!(c, 'µ' | 'μ') { 'u' } else { c }).collect::<String>().to_lowercase();
    text.strip_suffix("turns").map(|start| format!("{start}turn")).unwrap_or(text)
}
