//! Pixels, and their file.

use std::collections::BTreeMap;

/// Bits of red, green and blue by which colours are told apart when a palette is chosen.
const BITS: u32 = 5;
const SHELVES: usize = 1 << (3 * BITS);
/// Most colours of a palette, and most of these that plain areas have, such as the cells of a map: theirs are exact.
const PALETTE: usize = 256;
const PLAIN: usize = 192;
/// Pixels in a row of one colour that are a plain area.
const AREA: usize = 8;
/// Pixels that are compared with a colour in one go.
const AT_ONCE: usize = 16;

/// Pixels row by row, each as the ink on white paper: 255 less its red, green and blue, one byte each from the third on down.
pub struct Bitmap {
    pub width: usize,
    pub height: usize,
    pub ink: Vec<u32>,
}

/// What the paper lacks of a colour of red, green and blue.
pub fn ink([r, g, b]: [u8; 3]) -> u32 {
    !u32::from_be_bytes([255, r, g, b])
}

/// Red, green and blue under an ink.
pub fn colour(ink: u32) -> [u8; 3] {
    let [_, r, g, b] = (!ink).to_be_bytes();
    [r, g, b]
}

/// Neighbouring pixels of one ink, `to` not among them.
struct InkRun {
    ink: u32,
    from: usize,
    to: usize,
}

/// The pixels of a shelf of colours, and the ink that most of them have, by a vote.
#[derive(Clone, Copy, Default)]
struct Shelf {
    count: usize,
    votes: usize,
    ink: u32,
}

impl Bitmap {
    /// White paper.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, ink: vec![0; width * height] }
    }

    /// The bitmap as PNG with a palette: the colours of plain areas are exact, and a rare one takes the place of the nearest.
    ///
    /// # Errors
    /// Those of the encoder.
    pub fn png(&self, compression: png::Compression) -> Result<Vec<u8>, png::EncodingError> {
        let palette = ShelvedPalette::of(self);
        let mut indices = vec![0; self.ink.len()];
        for InkRun { ink, from, to } in self.runs() {
            let place = palette.place(ink);
            if place > 0 {
                indices[from..to].fill(place);
            }
        }
        let mut bytes = Vec::with_capacity(indices.len() / 8);
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(palette.colours);
        encoder.set_compression(compression);
        // The fast way knows only zeros as what repeats: what is as the row above becomes that.
        let fast = matches!(compression, png::Compression::Fast);
        encoder.set_filter(if fast { png::Filter::Up } else { png::Filter::NoFilter });
        encoder.write_header()?.write_image_data(&indices)?;
        Ok(bytes)
    }

    fn runs(&self) -> impl Iterator<Item = InkRun> {
        let mut from = 0;
        std::iter::from_fn(move || {
            let ink = *self.ink.get(from)?;
            let mut to = from + 1;
            // Most of a picture is paper: by many pixels at once.
            while self.ink.get(to..to + AT_ONCE).is_some_and(|next| next == [ink; AT_ONCE]) {
                to += AT_ONCE;
            }
            while self.ink.get(to) == Some(&ink) {
                to += 1;
            }
            Some(InkRun { ink, from: std::mem::replace(&mut from, to), to })
        })
    }
}

/// Red, green and blue of each place, the places of the inks of plain areas in the order of these, and those of every shelf of colours.
struct ShelvedPalette {
    colours: Vec<u8>,
    plain: Vec<(u32, u8)>,
    shelves: Vec<u8>,
}

impl ShelvedPalette {
    fn of(bitmap: &Bitmap) -> Self {
        let mut areas: BTreeMap<u32, usize> = BTreeMap::new();
        let mut shelves = vec![Shelf::default(); SHELVES];
        for InkRun { ink, from, to } in bitmap.runs() {
            let length = to - from;
            if length >= AREA {
                *areas.entry(ink).or_default() += length;
            }
            let shelf = &mut shelves[shelf(ink)];
            shelf.count += length;
            if shelf.ink == ink {
                shelf.votes += length;
            } else if shelf.votes >= length {
                shelf.votes -= length;
            } else {
                (shelf.votes, shelf.ink) = (length - shelf.votes, ink);
            }
        }
        // The paper comes first: a row of zeros takes the least time.
        let mut plain: Vec<(u32, usize)> = areas.into_iter().collect();
        plain.sort_by_key(|area| std::cmp::Reverse(area.1));
        plain.truncate(PLAIN);
        let mut order: Vec<usize> = (0..SHELVES).filter(|shelf| shelves[*shelf].count > 0).collect();
        order.sort_by_key(|shelf| std::cmp::Reverse(shelves[*shelf].count));
        let inks = plain.iter().map(|area| area.0);
        let own =
            order.iter().map(|shelf| shelves[*shelf].ink).filter(|ink| plain.iter().all(|p| p.0 != *ink));
        let colours: Vec<[u8; 3]> = inks.clone().chain(own).take(PALETTE).map(colour).collect();
        let mut places = vec![0; SHELVES];
        for shelf in order {
            let of = colour(shelves[shelf].ink);
            let mut nearest = u32::MAX;
            for (place, own) in colours.iter().enumerate() {
                let off = |part: usize| u32::from(own[part].abs_diff(of[part])).pow(2);
                let distance = off(0) + off(1) + off(2);
                if distance < nearest {
                    (nearest, places[shelf]) = (distance, place as u8);
                }
                if distance == 0 {
                    break;
                }
            }
        }
        let mut plain: Vec<(u32, u8)> = inks.zip(0..=u8::MAX).collect();
        plain.sort_unstable();
        Self { colours: colours.concat(), plain, shelves: places }
    }

    fn place(&self, ink: u32) -> u8 {
        match self.plain.binary_search_by_key(&ink, |plain| plain.0) {
            Ok(at) => self.plain[at].1,
            Err(_) => self.shelves[shelf(ink)],
        }
    }
}

/// The number of an ink's leading bits.
fn shelf(ink: u32) -> usize {
    let lead = |byte: u32| (ink >> (8 * byte + 8 - BITS) & ((1 << BITS) - 1)) << (byte * BITS);
    (lead(2) | lead(1) | lead(0)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_colours_come_back_and_rare_ones_nearly() {
        let mut bitmap = Bitmap::new(64, 64);
        bitmap.ink[100..900].fill(ink([0, 114, 178]));
        bitmap.ink[900..1000].fill(ink([1, 115, 178]));
        for (k, pixel) in bitmap.ink[2000..2900].iter_mut().enumerate() {
            *pixel = ink([(k / 4) as u8, 7, 200 - (k / 8) as u8]);
        }
        let bytes = bitmap.png(png::Compression::Fast).unwrap();
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut read = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut read).unwrap();
        for (k, (read, own)) in read.chunks_exact(3).zip(&bitmap.ink).enumerate() {
            let own = colour(*own);
            let off = (0..3).map(|i| read[i].abs_diff(own[i])).max().unwrap();
            assert!(off <= if k < 900 { 0 } else { 8 }, "{k}: {read:?} for {own:?}");
        }
    }
}
