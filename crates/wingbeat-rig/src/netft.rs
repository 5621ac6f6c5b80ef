//! The wire format of the ATI Net F/T box: Raw Data Transfer over UDP and the
//! scale factors that it states (ATI, Net F/T Installation and Operation Manual 9620-05-NET FT).

mod account;

pub use account::Account;

use super::unit::ChannelQuantity;
use wingbeat_math::Error;

/// Default UDP port of RDT.
pub const RDT_PORT: u16 = 49152;
/// First word of a request.
const HEADER: u16 = 0x1234;
/// Counts per N or N m that are believed: the boxes' are 1 to 1e7 per N, lbf, N m or lbf-in (*choice*: a thousand times
/// less and more).
pub const COUNTS_PER_UNIT: [f64; 2] = [1e-3, 1e10];
/// Samples per second inside the box.
pub const BOX_RATE: f64 = 7000.0;
/// Time by which what the box's numbers say and the clock may differ; more only a restart of the box, a jump of its
/// numbers or samples that are not accounted for explain, s (*choice*: ten times the delays of a busy host).
pub const APART_S: f64 = 0.5;
/// Bytes of one RDT record.
pub const RECORD_BYTES: usize = 36;
/// Bytes of a request.
pub const REQUEST_BYTES: usize = 8;

/// What a client asks of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Stop sending.
    Stop,
    /// Send one record per datagram.
    RealTime,
    /// Send several records per datagram.
    Buffered,
    /// Take the present load as zero.
    Bias,
}

impl Command {
    fn code(self) -> u16 {
        match self {
            Self::Stop => 0,
            Self::RealTime => 2,
            Self::Buffered => 3,
            Self::Bias => 0x42,
        }
    }
}

/// A request: the command and the number of records, 0 for without end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// What is asked.
    pub command: Command,
    /// Records wanted; 0 for without end.
    pub count: u32,
}

impl Request {
    /// The eight bytes on the wire, big-endian.
    pub fn bytes(self) -> [u8; REQUEST_BYTES] {
        let (h, c, n) = (HEADER.to_be_bytes(), self.command.code().to_be_bytes(), self.count.to_be_bytes());
        [h[0], h[1], c[0], c[1], n[0], n[1], n[2], n[3]]
    }

    /// Reads a request; none when it is none.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; REQUEST_BYTES] = bytes.try_into().ok()?;
        if u16::from_be_bytes([bytes[0], bytes[1]]) != HEADER {
            return None;
        }
        let command = match u16::from_be_bytes([bytes[2], bytes[3]]) {
            0 => Command::Stop,
            2 => Command::RealTime,
            3 => Command::Buffered,
            0x42 => Command::Bias,
            _ => return None,
        };
        Some(Self { command, count: u32::from_be_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) })
    }
}

/// One RDT record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RdtRecord {
    /// Number of the record in this stream, from 1; wraps.
    pub rdt_sequence: u32,
    /// Number of the sample inside the box, 7 kHz; wraps.
    pub ft_sequence: u32,
    /// Status word.
    pub status: u32,
    /// Counts of Fx, Fy, Fz, Tx, Ty, Tz.
    pub counts: [i32; 6],
}

impl RdtRecord {
    /// The bytes on the wire, big-endian.
    pub fn bytes(&self) -> [u8; RECORD_BYTES] {
        let mut out = [0; RECORD_BYTES];
        let words = [self.rdt_sequence, self.ft_sequence, self.status].map(u32::to_be_bytes);
        let all = words.iter().copied().chain(self.counts.map(i32::to_be_bytes));
        for (chunk, word) in out.chunks_exact_mut(4).zip(all) {
            chunk.copy_from_slice(&word);
        }
        out
    }

    /// The records of a datagram; none when its length is not a whole number of records above zero.
    pub fn parse(datagram: &[u8]) -> Option<impl Iterator<Item = Self> + '_> {
        if datagram.is_empty() || !datagram.len().is_multiple_of(RECORD_BYTES) {
            return None;
        }
        Some(datagram.chunks_exact(RECORD_BYTES).map(|chunk| {
            let word = |i: usize| {
                u32::from_be_bytes([chunk[4 * i], chunk[4 * i + 1], chunk[4 * i + 2], chunk[4 * i + 3]])
            };
            Self {
                rdt_sequence: word(0),
                ft_sequence: word(1),
                status: word(2),
                counts: std::array::from_fn(|i| word(3 + i) as i32),
            }
        }))
    }
}

/// What a status word says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusClass {
    /// All is well.
    Good,
    /// 0x80010000: a warning without effect on the sample.
    Warning,
    /// Bit 0x00020000: a gauge or channel is saturated.
    Saturated,
    /// Anything else: the sample is not to be trusted.
    Serious,
}

/// Classes of status words.
pub fn classify(status: u32) -> StatusClass {
    match status {
        0 => StatusClass::Good,
        0x8001_0000 => StatusClass::Warning,
        s if s & 0x0002_0000 != 0 => StatusClass::Saturated,
        _ => StatusClass::Serious,
    }
}

/// Counts per newton and per newton metre, from the box itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Counts per N.
    pub per_newton: f64,
    /// Counts per N m.
    pub per_newton_metre: f64,
}

impl Scale {
    /// From counts per unit of force and of moment as the box states them, by the names of its elements.
    ///
    /// # Errors
    /// A number outside [`COUNTS_PER_UNIT`] per N or N m, or a unit not known.
    pub fn stated(force: [(&str, &str); 2], moment: [(&str, &str); 2]) -> Result<Self, Error> {
        let per = |[(number_key, number), (unit_key, unit)]: [(&str, &str); 2], quantity: ChannelQuantity| {
            let factor = quantity.factor(unit).ok_or_else(|| {
                let names = quantity.names().join(", ");
                Error::invalid(format!("netft.{unit_key}"), unit, format!("one of {names}"))
            })?;
            let [low, high] = COUNTS_PER_UNIT;
            let per = number.parse::<f64>().map(|number| number / factor);
            per.ok().filter(|per| (low..=high).contains(per)).ok_or_else(|| {
                let allowed = format!("a number that makes {low:e} to {high:e} counts per N or N m");
                Error::invalid(format!("netft.{number_key}"), format!("{number} per {unit}"), allowed)
            })
        };
        Ok(Self {
            per_newton: per(force, ChannelQuantity::Force)?,
            per_newton_metre: per(moment, ChannelQuantity::Moment)?,
        })
    }

    /// N and N m of raw counts.
    pub fn wrench(&self, counts: [i32; 6]) -> [f64; 6] {
        std::array::from_fn(|i| {
            f64::from(counts[i]) / if i < 3 { self.per_newton } else { self.per_newton_metre }
        })
    }

    /// Raw counts of N and N m.
    pub fn counts(&self, wrench: [f64; 6]) -> [i32; 6] {
        std::array::from_fn(|i| {
            (wrench[i] * if i < 3 { self.per_newton } else { self.per_newton_metre }).round() as i32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(rdt_sequence: u32) -> RdtRecord {
        RdtRecord { rdt_sequence, ..Default::default() }
    }

    #[test]
    fn records_and_requests_round_trip() {
        let r = RdtRecord {
            rdt_sequence: 7,
            ft_sequence: u32::MAX,
            status: 0x8001_0000,
            counts: [-1, 2, i32::MIN, 4, 5, 6],
        };
        let two = [r.bytes(), numbered(8).bytes()].concat();
        assert_eq!(RdtRecord::parse(&two).unwrap().collect::<Vec<_>>(), [r, numbered(8)]);
        assert!(RdtRecord::parse(&two[..71]).is_none() && RdtRecord::parse(&[]).is_none());
        let q = Request { command: Command::RealTime, count: 0 };
        assert_eq!(q.bytes(), [0x12, 0x34, 0, 2, 0, 0, 0, 0]);
        assert_eq!(Request::parse(&q.bytes()), Some(q));
        assert_eq!(Request::parse(&[0x12, 0x35, 0, 2, 0, 0, 0, 0]), None);
    }

    #[test]
    fn scale_is_as_stated_in_any_unit_within_a_range() {
        let stated = |force: &str, unit: &str| {
            Scale::stated([("cfgcpf", force), ("scfgfu", unit)], [("cfgcpt", "1000"), ("scfgtu", "Nmm")])
        };
        let s = stated("1000000", "N").unwrap();
        assert_eq!((s.per_newton, s.per_newton_metre), (1e6, 1e6));
        assert_eq!(s.counts(s.wrench([5, -6, 7, 8, 9, -10])), [5, -6, 7, 8, 9, -10]);
        assert!(stated("1000000", "furlong").unwrap_err().to_string().contains("scfgfu = furlong"));
        for wrong in ["1e-320", "0", "-1e6", "nan", "inf", "1e300", "", "many"] {
            assert!(stated(wrong, "N").unwrap_err().to_string().contains("netft.cfgcpf"), "{wrong}");
        }
    }

    #[test]
    fn status_words_have_classes() {
        let classes = [0, 0x8001_0000, 0x8002_0000, 0x0002_0000, 0x8000_0001].map(classify);
        use StatusClass::{Good, Saturated, Serious, Warning};
        assert_eq!(classes, [Good, Warning, Saturated, Saturated, Serious]);
    }
}
