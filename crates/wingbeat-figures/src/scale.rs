//! Ticks of a linear axis, and numbers beside them that tell them apart.

/// Ticks wanted on an axis.
const TICKS: f64 = 7.0;
/// Share of the largest value below which a range is rounding.
const FLAT: f64 = 1e-9;
/// Share of a range by which an end may miss a tick and be taken for it. *Choice.*
const NEAR: f64 = 0.02;
/// Magnitude below which all of a range is rounding about zero, in SI units or degrees. *Choice.*
const ROUNDING: f64 = 1e-12;
/// Units that take a prefix.
const PREFIXED: [&str; 20] = [
    "m", "s", "g", "N", "W", "J", "V", "A", "Hz", "Pa", "rad", "N m", "N/m", "N m/m", "N s", "m/s", "m/s2",
    "rad/s", "rad/s2", "W/m",
];
/// Prefixes of powers of a thousand.
const PREFIXES: [(i32, &str); 7] =
    [(-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (3, "k"), (6, "M"), (9, "G")];

/// A range of values with a step of 1, 2 or 5 times a power of ten, and the power of a thousand in which its numbers are short.
/// Its ends and values are in the caller's unit, that of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickScale {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// From tick to tick.
    pub step: f64,
    exponent: i32,
    decimals: usize,
}

impl TickScale {
    /// Of the range itself.
    pub fn new(low: f64, high: f64) -> Self {
        let (low, high) = if flat(low, high) { around(low, high) } else { (low, high) };
        let raw = (high - low) / TICKS;
        let ten = 10_f64.powf(raw.log10().floor());
        let nice =
            [1.0, 2.0, 5.0, 10.0].into_iter().find(|nice| raw <= nice * ten * (1.0 + FLAT)).unwrap_or(10.0);
        let step = nice * ten;
        let least = step.log10().floor() as i32;
        let largest = low.abs().max(high.abs()).log10().floor() as i32;
        let short = largest < 4 && least >= -3 && !(largest < -1 && least < -2);
        let exponent = if short { 0 } else { 3 * largest.div_euclid(3) };
        Self { low, high, step, exponent, decimals: (exponent - least).max(0) as usize }
    }

    /// With `share` of the range free at both ends.
    pub fn padded(low: f64, high: f64, share: f64) -> Self {
        let margin = if flat(low, high) { 0.0 } else { share * (high - low) };
        Self::new(low - margin, high + margin)
    }

    /// The same range up to the tick that an end just misses: rows of a cycle begin a little after its start.
    pub fn whole(self) -> Self {
        let near = NEAR * (self.high - self.low);
        let (low, high) =
            ((self.low / self.step).floor() * self.step, (self.high / self.step).ceil() * self.step);
        let low = if self.low - low < near { low } else { self.low };
        Self { low, high: if high - self.high < near { high } else { self.high }, ..self }
    }

    /// The number beside a tick.
    pub fn number(&self, value: f64) -> String {
        let text = format!("{:.*}", self.decimals, value / 10_f64.powi(self.exponent));
        let zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
        if zero { "0".into() } else { text.replace('-', "−") }
    }

    /// The label of the axis, whose unit stands in brackets, with the power of its numbers.
    pub fn label(&self, label: &str) -> String {
        if self.exponent == 0 {
            return label.into();
        }
        let prefix = PREFIXES.iter().find(|(exponent, _)| *exponent == self.exponent);
        let power = || super::style::decade_of(self.exponent);
        match label.rsplit_once('[').and_then(|(name, rest)| Some((name, rest.split_once(']')?))) {
            Some((name, (unit, rest))) => match prefix {
                Some((_, prefix)) if PREFIXED.contains(&unit) => format!("{name}[{prefix}{unit}]{rest}"),
                _ => format!("{name}[{} {unit}]{rest}", power()),
            },
            None => format!("{label} [{}]", power()),
        }
    }
}

/// True for values that differ by no more than rounding.
fn flat(low: f64, high: f64) -> bool {
    let largest = low.abs().max(high.abs());
    largest < ROUNDING || !(high - low > FLAT * largest)
}

/// A range about values that are all alike, from zero on.
fn around(low: f64, high: f64) -> (f64, f64) {
    let middle = 0.5 * (low + high);
    let middle = if middle.abs() < ROUNDING { 0.0 } else { middle };
    let half = if middle == 0.0 { 1.0 } else { middle.abs() };
    (middle - half, middle + half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(scale: &TickScale) -> Vec<f64> {
        let (first, last) =
            ((scale.low / scale.step).ceil() as i64, (scale.high / scale.step).floor() as i64);
        (first..=last).map(|k| k as f64 * scale.step).collect()
    }

    #[test]
    fn no_two_labels_are_equal_and_each_is_its_value() {
        for decade in -9..=9 {
            for (low, high) in [(0.0, 1.0), (-0.4, 0.4), (0.97, 1.03), (-7.3, -1.1), (2.0, 2.0), (1.0, 1.001)]
            {
                let ten = 10_f64.powi(decade);
                let scale = TickScale::padded(low * ten, high * ten, 0.07);
                let ticks = ticks(&scale);
                assert!((3..=9).contains(&ticks.len()), "{scale:?}: {ticks:?}");
                let labels: Vec<String> = ticks.iter().map(|tick| scale.number(*tick)).collect();
                for (i, label) in labels.iter().enumerate() {
                    assert!(labels[..i].iter().all(|other| other != label), "{labels:?}");
                    let value = label.replace('−', "-").parse::<f64>().unwrap() * 10_f64.powi(scale.exponent);
                    assert!((value - ticks[i]).abs() <= 1e-6 * scale.step, "{label} is not {}", ticks[i]);
                }
            }
        }
    }

    #[test]
    fn a_cycle_reaches_from_0_to_1() {
        let ends = |low, high| {
            let scale = TickScale::new(low, high).whole();
            (scale.low, scale.high)
        };
        assert_eq!(ends(0.004, 0.998), (0.0, 1.0));
        assert_eq!(ends(0.0, 4.7), (0.0, 4.7));
    }

    #[test]
    fn units_take_prefixes() {
        let small = TickScale::new(-0.004, 0.004);
        assert_eq!((small.label("heave [m]"), small.number(-0.002)), ("heave [mm]".into(), "−2".into()));
        assert_eq!(TickScale::new(0.0, 2e-6).label("circulation [m2/s]"), "circulation [10⁻⁶ m2/s]");
        assert_eq!(TickScale::new(0.0, 3e5).label("power [W], electrical"), "power [kW], electrical");
        assert_eq!(TickScale::new(-0.3, 0.3).label("force [N]"), "force [N]");
        assert_eq!(TickScale::new(0.0, 1e-7).label("error"), "error [10⁻⁹]");
    }

    #[test]
    fn values_that_are_all_alike_have_a_range() {
        let zero = TickScale::padded(0.0, 0.0, 0.07);
        assert_eq!((zero.low, zero.high), (-1.0, 1.0));
        let rounding = TickScale::padded(-4e-18, 3e-18, 0.07);
        assert_eq!((rounding.low, rounding.high), (-1.0, 1.0));
        let five = TickScale::padded(5.0, 5.0, 0.07);
        assert!(five.low < 5.0 && five.high > 5.0);
    }
}
