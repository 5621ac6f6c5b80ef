//! Messages of ROS 2 in CDR, the lowest byte first: numbers lie at multiples of their size from the end of the head.

/// A message while it is written.
pub struct CdrMessage(Vec<u8>);

impl CdrMessage {
    /// An empty one behind its head.
    pub fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    /// Its bytes.
    pub fn bytes(self) -> Vec<u8> {
        self.0
    }

    fn align(&mut self, size: usize) {
        while !(self.0.len() - 4).is_multiple_of(size) {
            self.0.push(0);
        }
    }

    /// A 32-bit number.
    pub fn int(&mut self, value: u32) -> &mut Self {
        self.align(4);
        self.0.extend(value.to_le_bytes());
        self
    }

    /// 64-bit floats, in the units of the message.
    pub fn doubles(&mut self, values: &[f64]) -> &mut Self {
        for value in values {
            self.align(8);
            self.0.extend(value.to_le_bytes());
        }
        self
    }

    /// A list of 64-bit floats with its length, in the units of the message.
    pub fn list(&mut self, values: &[f64]) -> &mut Self {
        self.int(values.len() as u32).doubles(values)
    }

    /// A text with its end.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.int(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
        self
    }

    /// The head of a stamped message: time, ns, and frame.
    pub fn header(&mut self, time_ns: u64, frame: &str) -> &mut Self {
        self.int((time_ns / 1_000_000_000) as u32).int((time_ns % 1_000_000_000) as u32).text(frame)
    }
}
