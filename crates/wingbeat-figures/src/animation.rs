//! Pictures that move: parts of space frame by frame, as an animated PNG or as a sequence of PNG files.
//!
//! A picture has at most 255 colours, and of a frame only what differs from the one before is written.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use wingbeat::math::order::{descend_by, filled};

use crate::canvas::{Canvas, Primitive, TextAnchor};
use crate::space::{Bounds, Camera, Pane, Space, WorldPoint};

use crate::raster::{self, Bitmap};
use crate::{Error, style};

/// Steps between neighbouring shades of a colour.
const SHADE: u16 = 17;
/// Colours of the palette, beside the one that leaves a pixel as it was.
const PALETTE: usize = 255;

/// An area of a picture.
pub struct Area {
    /// Its corners.
    pub corners: Vec<WorldPoint>,
    /// Its colour, `#rrggbb`.
    pub colour: String,
    /// Share of its colour that covers what is behind.
    pub opacity: f64,
    /// The colour of a line about it.
    pub edge: Option<&'static str>,
}

/// A line of a picture.
pub struct PictureLine {
    /// Its points.
    pub points: Vec<WorldPoint>,
    /// Its colour.
    pub colour: String,
    /// Its weight, px.
    pub weight: f64,
}

/// A part of space in a pane of a picture.
pub struct PictureView {
    /// From where it is seen.
    pub camera: Camera,
    /// What of space it shows.
    pub bounds: Bounds,
    /// Where it is drawn.
    pub pane: Pane,
    /// A frame with a ground of its own below it.
    pub framed: Option<Pane>,
    /// Areas, sorted by depth.
    pub areas: Vec<Area>,
    /// Lines, likewise.
    pub lines: Vec<PictureLine>,
    /// Words at points.
    pub words: Vec<(WorldPoint, String)>,
}

/// A picture.
pub struct Picture {
    /// Width, px.
    pub width: f64,
    /// Height, px.
    pub height: f64,
    /// What it shows, one over the other.
    pub views: Vec<PictureView>,
    /// Words in its upper left corner.
    pub title: String,
    /// Words in its lower left corner.
    pub note: String,
}

/// Pixels of a picture: four bits of red, green and blue each.
struct Pixels {
    width: u32,
    height: u32,
    shades: Vec<u16>,
}

/// Frames on the way to a file.
#[derive(Default)]
pub struct Animation {
    frames: Vec<Pixels>,
    cover: Option<Pixels>,
}

impl Animation {
    /// Draws a frame.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn push(&mut self, picture: &Picture) -> Result<(), Error> {
        self.frames.push(pixels(picture)?);
        Ok(())
    }

    /// Draws what is shown where pictures do not move.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn cover(&mut self, picture: &Picture) -> Result<(), Error> {
        self.cover = Some(pixels(picture)?);
        Ok(())
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Writes an animated PNG that begins again at its end, each frame for `delay_s`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path, delay_s: f64) -> Result<(), Error> {
        let written = || -> Result<(), WriteFailure> {
            if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
                fs::create_dir_all(folder)?;
            }
            self.animated(Box::new(BufWriter::new(File::create(path)?)), delay_s)
        };
        written().map_err(|error| told(path, error))
    }

    /// The same as bytes.
    ///
    /// # Errors
    /// An animation that cannot be made.
    pub fn bytes(&self, delay_s: f64) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        self.animated(Box::new(&mut bytes), delay_s).map_err(|error| told(Path::new(""), error))?;
        Ok(bytes)
    }

    /// Each frame as the bytes of `frame_0000.png` and so on.
    ///
    /// # Errors
    /// A picture that cannot be made.
    pub fn stills(&self) -> Result<Vec<(String, Vec<u8>)>, Error> {
        let palette = palette(self.frames.iter());
        let frames = self.frames.iter().enumerate();
        let stills = frames.map(|(number, frame)| {
            let mut bytes = Vec::new();
            frame.still(&palette, &mut bytes).map_err(|error| told(Path::new(""), error))?;
            Ok((format!("frame_{number:04}.png"), bytes))
        });
        stills.collect()
    }

    /// Writes each frame as `frame_0000.png` and so on into `folder`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn sequence(&self, folder: &Path) -> Result<(), Error> {
        let failed = |path: &Path, source| Error::File { path: path.into(), source };
        fs::create_dir_all(folder).map_err(|source| failed(folder, source))?;
        for (name, bytes) in self.stills()? {
            let path = folder.join(name);
            fs::write(&path, bytes).map_err(|source| failed(&path, source))?;
        }
        Ok(())
    }

    fn animated<'a>(&self, out: Box<dyn Write + 'a>, delay_s: f64) -> Result<(), WriteFailure> {
        let Some(first) = self.frames.first() else { return Err("no frames".into()) };
        // A cover of another size is none.
        let cover =
            self.cover.as_ref().filter(|cover| (cover.width, cover.height) == (first.width, first.height));
        let palette = palette(self.frames.iter().chain(cover));
        let mut encoder = encoder(out, first, &palette);
        encoder.set_animated(self.frames.len() as u32, 0)?;
        encoder.set_sep_def_img(cover.is_some())?;
        encoder.set_frame_delay((1000.0 * delay_s).round().clamp(1.0, 60_000.0) as u16, 1000)?;
        encoder.set_blend_op(png::BlendOp::Over)?;
        encoder.set_dispose_op(png::DisposeOp::None)?;
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::NoFilter);
        let mut writer = encoder.write_header()?;
        if let Some(cover) = cover {
            let indices: Vec<u8> = cover.shades.iter().map(|shade| palette.place(*shade)).collect();
            writer.write_image_data(&indices)?;
        }
        let mut before: Option<&Pixels> = None;
        for frame in &self.frames {
            let (x, y, width, height) =
                before.map_or((0, 0, frame.width, frame.height), |b| frame.changed(b));
            if before.is_some() {
                writer.set_frame_dimension(width, height)?;
                writer.set_frame_position(x, y)?;
            }
            let mut indices = Vec::with_capacity((width * height) as usize);
            for row in y..y + height {
                for column in x..x + width {
                    let at = (row * frame.width + column) as usize;
                    let same = before.is_some_and(|before| before.shades[at] == frame.shades[at]);
                    indices.push(if same { 0 } else { palette.place(frame.shades[at]) });
                }
            }
            writer.write_image_data(&indices)?;
            before = Some(frame);
        }
        Ok(writer.finish()?)
    }
}

/// Why a picture could not be written.
type WriteFailure = Box<dyn std::error::Error>;

fn told(path: &Path, error: WriteFailure) -> Error {
    match error.downcast::<std::io::Error>() {
        Ok(source) => Error::File { path: path.into(), source: *source },
        Err(error) => Error::Picture(error.to_string()),
    }
}

impl Pixels {
    /// Writes a PNG.
    fn still(&self, palette: &Palette, out: &mut Vec<u8>) -> Result<(), WriteFailure> {
        let mut encoder = encoder(Box::new(out), self, palette);
        encoder.set_compression(png::Compression::Balanced);
        let indices: Vec<u8> = self.shades.iter().map(|shade| palette.place(*shade)).collect();
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&indices)?;
        // Writes what is buffered, which a drop does without a word.
        Ok(writer.finish()?)
    }

    /// The least rectangle that holds what differs from `before`; a pixel where nothing does.
    fn changed(&self, before: &Self) -> (u32, u32, u32, u32) {
        let (mut low, mut high) = ((self.width, self.height), (0, 0));
        for (at, pair) in self.shades.iter().zip(&before.shades).enumerate() {
            if pair.0 != pair.1 {
                let (x, y) = (at as u32 % self.width, at as u32 / self.width);
                low = (low.0.min(x), low.1.min(y));
                high = (high.0.max(x), high.1.max(y));
            }
        }
        if low.0 > high.0 { (0, 0, 1, 1) } else { (low.0, low.1, high.0 - low.0 + 1, high.1 - low.1 + 1) }
    }
}

/// The colours of all frames: the most frequent, and for the others the nearest of them. Number 0 leaves a pixel as it was.
struct Palette {
    colours: Vec<u8>,
    places: BTreeMap<u16, u8>,
}

impl Palette {
    fn place(&self, shade: u16) -> u8 {
        self.places.get(&shade).copied().unwrap_or(1)
    }
}

fn parts(shade: u16) -> [u16; 3] {
    [shade >> 8, shade >> 4 & 15, shade & 15]
}

fn palette<'a>(frames: impl Iterator<Item = &'a Pixels>) -> Palette {
    let mut counts: BTreeMap<u16, usize> = BTreeMap::new();
    for shade in frames.flat_map(|frame| &frame.shades) {
        *counts.entry(*shade).or_default() += 1;
    }
    let mut order: Vec<u16> = counts.keys().copied().collect();
    descend_by(&mut order, |shade| counts[shade] as f64);
    let kept: Vec<u16> = order.iter().copied().take(PALETTE).collect();
    let distance =
        |a: u16, b: u16| -> u16 { parts(a).iter().zip(parts(b)).map(|(a, b)| a.abs_diff(b).pow(2)).sum() };
    let nearest = |shade: u16| (0..kept.len()).min_by_key(|&i| distance(kept[i], shade)).unwrap_or(0);
    let places = filled(order.iter().map(|&shade| (shade, nearest(shade) as u8 + 1)));
    let colours = kept.iter().flat_map(|&shade| parts(shade).map(|part| (part * SHADE) as u8));
    Palette { colours: [0; 3].into_iter().chain(colours).collect(), places }
}

fn encoder<'a>(
    out: Box<dyn Write + 'a>,
    frame: &Pixels,
    palette: &Palette,
) -> png::Encoder<'a, Box<dyn Write + 'a>> {
    let mut encoder = png::Encoder::new(out, frame.width, frame.height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.colours.clone());
    encoder.set_trns(vec![0]);
    encoder
}

/// A picture as red, green and blue of each pixel, row by row.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn rgb(picture: &Picture) -> Result<Vec<u8>, Error> {
    Ok(drawn(picture)?.ink.into_iter().flat_map(raster::colour).collect())
}

/// Draws a picture in few shades.
fn pixels(picture: &Picture) -> Result<Pixels, Error> {
    let drawn = drawn(picture)?;
    let bits = |value: u8| (u16::from(value) + SHADE / 2) / SHADE;
    let shade = |[r, g, b]: [u8; 3]| bits(r) << 8 | bits(g) << 4 | bits(b);
    let shades = drawn.ink.iter().map(|ink| shade(raster::colour(*ink))).collect();
    Ok(Pixels { width: drawn.width as u32, height: drawn.height as u32, shades })
}

fn drawn(picture: &Picture) -> Result<Bitmap, Error> {
    let mut scene = Canvas::new(picture.width, picture.height);
    for view in &picture.views {
        if let Some(Pane { x, y, width, height }) = view.framed {
            let corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)];
            scene.elements.push(style::area(&corners, "#ffffff", 1.0));
            for k in 0..4 {
                scene.elements.push(style::sample(corners[k], corners[(k + 1) % 4], style::GUIDE, 1.2, None));
            }
        }
        if let Some(Pane { x, y, width, height }) = view.framed {
            scene.elements.push(Primitive::ClipStart { x, y, width, height });
        }
        let mut space = Space::new(view.camera, view.bounds, view.pane);
        for Area { corners, colour, opacity, edge } in &view.areas {
            space.area(corners, colour, *opacity, *edge);
        }
        view.lines.iter().for_each(|line| space.line(&line.points, &line.colour, line.weight));
        for (point, words) in &view.words {
            space.label(*point, (0.0, -8.0), words, TextAnchor::Middle);
        }
        space.paint(&mut scene);
        if view.framed.is_some() {
            scene.elements.push(Primitive::ClipEnd);
        }
    }
    let anchor = TextAnchor::Start;
    for (y, text) in [(22.0, &picture.title), (picture.height - 12.0, &picture.note)] {
        scene.elements.push(style::words(12.0, y, text.clone(), anchor, false));
    }
    raster::bitmap(&scene, 1.0).map_err(Error::Picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(x: f64) -> Picture {
        let corners = vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0]];
        let area = Area { corners, colour: "#0072b2".into(), opacity: 1.0, edge: None };
        let view = PictureView {
            camera: Camera::orthographic(-90.0, 90.0),
            bounds: Bounds { low: [0.0; 3], high: [3.0, 1.0, 0.1] },
            pane: Pane { x: 0.0, y: 0.0, width: 200.0, height: 120.0 },
            framed: None,
            areas: vec![area],
            lines: Vec::new(),
            words: Vec::new(),
        };
        Picture { width: 200.0, height: 120.0, views: vec![view], title: "t".into(), note: String::new() }
    }

    #[test]
    fn frames_come_back_in_their_order() {
        let mut animation = Animation::default();
        for k in 0..3 {
            animation.push(&frame(f64::from(k))).unwrap();
        }
        // What stands still is of its own and no frame.
        animation.cover(&frame(1.0)).unwrap();
        let path = std::env::temp_dir().join(format!("wingbeat-animation-{}.png", std::process::id()));
        animation.write(&path, 0.05).unwrap();
        let decoder = png::Decoder::new(std::io::BufReader::new(File::open(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert!(reader.info().frame_control().is_none());
        let mut seen = 0;
        while reader.next_frame(&mut pixels).is_ok() {
            seen += 1;
            let control = reader.info().frame_control().unwrap();
            assert!(control.delay_num == 50 && (seen == 1 || control.width < 190), "{control:?}");
        }
        assert_eq!(seen, 3);
        fs::remove_file(path).unwrap();
    }
}
