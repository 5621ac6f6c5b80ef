//! A figure to its files.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::render::{Primitive, Scene};

use crate::{Error, strokes, style};

/// Pixels of a PNG per pixel of the drawing: 180 per inch at a page's width. *Choice*: a PNG costs in proportion to its pixels, two thirds
/// of it for their compression, and the SVG beside it is for print.
const SCREEN: f32 = 1.5;
/// Pixels of the width of a slide.
const SLIDE: f64 = 1920.0;
/// Steps between neighbouring shades of a colour on a screen.
const SHADE: u16 = 17;
/// Most colours of a palette.
const PALETTE: usize = 256;

/// A figure ready to be written.
pub struct Figure {
    /// Name of its files without extension.
    pub name: &'static str,
    pub(crate) scene: Scene,
}

impl Figure {
    pub(crate) fn new(name: &'static str, scene: Scene) -> Self {
        Self { name, scene: own_names(name, strokes::cut(scene)) }
    }

    /// The same figure under another name.
    pub fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The figure in the middle of a page of 16 to 9 that just holds it.
    fn slide(self) -> Self {
        let (width, height) = (self.scene.width, self.scene.height);
        let page = (width.max(height * 16.0 / 9.0), height.max(width * 9.0 / 16.0));
        let mut scene = style::scene(page.0, page.1);
        scene.elements = style::moved(self.scene, 0.5 * (page.0 - width), 0.5 * (page.1 - height));
        Self { scene, ..self }
    }

    /// The figure as PNG, for a page on a screen.
    ///
    /// # Errors
    /// A figure that cannot be drawn.
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        rendered(self, SCREEN)
    }

    /// The figure as SVG.
    pub fn svg(&self) -> String {
        SvgBackend::default().render_scene(&self.scene)
    }
}

/// The scene with the regions to which its curves are clipped named by the figure and their order: kuva counts those of all figures, in
/// whichever order threads draw them.
fn own_names(name: &str, mut scene: Scene) -> Scene {
    let mut regions = scene.elements.iter_mut().filter_map(|element| match element {
        Primitive::ClipStart { id, .. } => Some(id),
        _ => None,
    });
    for number in 1.. {
        let Some(id) = regions.next() else { break };
        let own = format!("{name}-{number}");
        // Where the region is described.
        let (then, now) = (format!("id=\"{id}\""), format!("id=\"{own}\""));
        if let Some(region) = scene.defs.iter_mut().find(|region| region.contains(&then)) {
            *region = region.replace(&then, &now);
        }
        *id = own;
    }
    scene
}

/// Reads the letters of all figures on a thread of its own, so that they are there when the first is drawn.
pub fn prepare() {
    let empty = || drop(PngBackend::new().with_scale(1.0).render_scene(&Scene::new(1.0, 1.0)));
    // Without a thread the first figure reads them.
    drop(std::thread::Builder::new().spawn(empty));
}

/// Writes `<name>.svg` and `<name>.png` of 180 pixels per inch into `folder`.
pub fn write(folder: &Path, figure: &Figure) -> Result<(), Error> {
    write_both(folder, figure, &rendered(figure, SCREEN)?)
}

/// The same with a small PNG for a page on a screen.
pub fn write_for_screen(folder: &Path, figure: &Figure) -> Result<(), Error> {
    let small = small(&rendered(figure, SCREEN)?).map_err(|error| Error::Picture(error.to_string()))?;
    write_both(folder, figure, &small)
}

/// Writes the figure in the middle of a page of 16 to 9, `<name>.svg` and a `<name>.png` of 1920 by 1080 pixels, into `folder`.
pub fn write_slide(folder: &Path, figure: Figure) -> Result<(), Error> {
    let slide = figure.slide();
    // A quarter of a pixel less, so that rounding up gives no pixel more.
    let scale = ((SLIDE - 0.25) / slide.scene.width) as f32;
    write_both(folder, &slide, &rendered(&slide, scale)?)
}

fn rendered(figure: &Figure, scale: f32) -> Result<Vec<u8>, Error> {
    PngBackend::new().with_scale(scale).render_scene(&figure.scene).map_err(Error::Picture)
}

fn write_both(folder: &Path, figure: &Figure, png: &[u8]) -> Result<(), Error> {
    let file = |extension: &str, bytes: &[u8]| {
        let path = folder.join(figure.name).with_extension(extension);
        fs::write(&path, bytes).map_err(|source| Error::File { path, source })
    };
    file("svg", figure.svg().as_bytes())?;
    file("png", png)
}

/// The opaque RGBA `picture` with few shades and a palette, in which a rare shade may miss and take the nearest.
fn small(picture: &[u8]) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(picture)).read_info()?;
    let mut pixels = vec![0; reader.output_buffer_size().unwrap_or(0)];
    let frame = reader.next_frame(&mut pixels)?;
    let shade = |value: u8| ((u16::from(value) + SHADE / 2) / SHADE * SHADE) as u8;
    let mut places = BTreeMap::new();
    let mut palette: Vec<[u8; 3]> = Vec::new();
    let mut place = |colour: [u8; 3]| {
        *places.entry(colour).or_insert_with(|| {
            if palette.len() < PALETTE {
                palette.push(colour);
                return (palette.len() - 1) as u8;
            }
            let distance = |other: &[u8; 3]| (0..3).map(|i| colour[i].abs_diff(other[i]) as u32).sum::<u32>();
            (0..PALETTE).min_by_key(|&i| distance(&palette[i])).unwrap_or(0) as u8
        })
    };
    let pixels = pixels[..frame.buffer_size()].chunks_exact(4);
    let indices: Vec<u8> = pixels.map(|p| place([shade(p[0]), shade(p[1]), shade(p[2])])).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, frame.width, frame.height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.concat());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.write_header()?.write_image_data(&indices)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_picture_keeps_its_size_and_its_plain_colours() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(&[255, 255, 255, 255, 1, 0, 35, 255]).unwrap();
        let small = small(&bytes).unwrap();
        let mut decoder = png::Decoder::new(std::io::Cursor::new(small));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, [255, 255, 255, 0, 0, 34]);
    }
}
