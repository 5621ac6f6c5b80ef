//! A drawing: lines, areas and words in the order in which they cover one another, and its SVG.

use std::fmt::{self, Write};

/// Families of letters, of which a reader takes the first that it has.
const LETTERS: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";

/// A place on a drawing: px to the right of its left edge and down from its upper one.
pub type PaperPoint = (f64, f64);

/// A colour, or none, which covers nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colour {
    /// No colour.
    #[default]
    None,
    /// Red, green and blue.
    Rgb([u8; 3]),
}

impl From<&str> for Colour {
    /// The colour `#rrggbb`, and none of any other text.
    fn from(text: &str) -> Self {
        let part = |at: usize| text.get(at..at + 2).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match (text.strip_prefix('#'), part(1), part(3), part(5)) {
            (Some(digits), Some(red), Some(green), Some(blue)) if digits.len() == 6 => {
                Self::Rgb([red, green, blue])
            }
            _ => Self::None,
        }
    }
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Rgb([red, green, blue]) => write!(f, "#{red:02x}{green:02x}{blue:02x}"),
        }
    }
}

/// Which part of words lies at their place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextAnchor {
    /// Their left end.
    Start,
    /// Their middle.
    Middle,
    /// Their right end.
    End,
}

/// A piece of a drawing; lengths in px, shares of opacity from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Primitive {
    /// A straight line; strokes and gaps, px, where it is broken.
    Line {
        x1: f64,
        y1: f64,
        x2: f64,
        y2: f64,
        stroke: Colour,
        stroke_width: f64,
        stroke_dasharray: Option<String>,
    },
    /// A line from point to point.
    PolyLine { points: Vec<PaperPoint>, stroke: Colour, stroke_width: f64, stroke_dasharray: Option<String> },
    /// A disc, with an edge of a px where it has a stroke without a width.
    Circle {
        cx: f64,
        cy: f64,
        r: f64,
        fill: Colour,
        fill_opacity: Option<f64>,
        stroke: Option<Colour>,
        stroke_width: Option<f64>,
    },
    /// A rectangle along the axes, without an edge.
    Rect { x: f64, y: f64, width: f64, height: f64, fill: Colour, opacity: Option<f64> },
    /// Areas or lines of one colour.
    Path(Box<PathData>),
    /// Words on a base line through (x, y), turned to the right about it by `rotate` degrees.
    Text {
        x: f64,
        y: f64,
        content: String,
        size: u32,
        anchor: TextAnchor,
        rotate: Option<f64>,
        bold: bool,
        color: Option<Colour>,
    },
    /// What follows, until the end of the group, lies further to the right and down.
    GroupStart { right: f64, down: f64 },
    /// The end of a group.
    GroupEnd,
    /// What follows, until the end of the clip, is seen within the rectangle only.
    ClipStart { x: f64, y: f64, width: f64, height: f64 },
    /// The end of a clip.
    ClipEnd,
}

/// Pieces of straight lines of one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct PathData {
    /// Places of each piece, px; one that ends where it begins is closed.
    pub pieces: Vec<Vec<PaperPoint>>,
    /// Colour of the ground that the pieces enclose.
    pub fill: Colour,
    /// Colour of the lines.
    pub stroke: Colour,
    /// Thickness of the lines, px.
    pub stroke_width: f64,
    /// Opacity of the ground (dimensionless); whole where there is none.
    pub opacity: Option<f64>,
}

/// A drawing on white paper.
#[derive(Clone, Debug)]
pub struct Canvas {
    /// Width of the paper, px.
    pub width: f64,
    /// Height of the paper, px.
    pub height: f64,
    /// What is drawn, the first below.
    pub elements: Vec<Primitive>,
}

impl Canvas {
    /// An empty drawing of a width and a height, px.
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, elements: Vec::new() }
    }

    /// The drawing as SVG; `name` tells its clips from those of other drawings on one page.
    pub fn svg(&self, name: &str) -> String {
        let mut clips = 0;
        let (mut defs, mut body) = (String::new(), String::new());
        for element in &self.elements {
            if let Primitive::ClipStart { x, y, width, height } = element {
                clips += 1;
                let shape = format!("x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"");
                defs += &format!("<clipPath id=\"{name}-{clips}\"><rect {shape}/></clipPath>\n");
                body += &format!("<g clip-path=\"url(#{name}-{clips})\">\n");
            } else {
                // A string takes what is written to it.
                let _ = write!(body, "{}", SvgElement(element));
            }
        }
        let (width, height) = (self.width, self.height);
        let size = format!("width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"");
        let head = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {size} font-family=\"{LETTERS}\">\n");
        let paper = "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
        let defs = if defs.is_empty() { defs } else { format!("<defs>\n{defs}</defs>\n") };
        format!("{head}{defs}{paper}{body}</svg>\n")
    }
}

/// The line of SVG of a primitive that is no clip's start.
struct SvgElement<'a>(&'a Primitive);

impl fmt::Display for SvgElement<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Primitive::Line { x1, y1, x2, y2, stroke, stroke_width, stroke_dasharray } => {
                let ends = format!("x1=\"{x1:.2}\" y1=\"{y1:.2}\" x2=\"{x2:.2}\" y2=\"{y2:.2}\"");
                let dashes = Dashes(stroke_dasharray.as_deref());
                writeln!(f, "<line {ends} stroke=\"{stroke}\" stroke-width=\"{stroke_width}\"{dashes}/>")
            }
            Primitive::PolyLine { points, stroke, stroke_width, stroke_dasharray } => {
                let dashes = Dashes(stroke_dasharray.as_deref());
                let d = PathText(std::slice::from_ref(points));
                let look = format!("stroke-width=\"{stroke_width}\" stroke-linejoin=\"round\"{dashes}");
                writeln!(f, "<path d=\"{d}\" fill=\"none\" stroke=\"{stroke}\" {look}/>")
            }
            Primitive::Circle { cx, cy, r, fill, fill_opacity, stroke, stroke_width } => {
                write!(
                    f,
                    "<circle cx=\"{cx:.2}\" cy=\"{cy:.2}\" r=\"{r}\" fill=\"{fill}\"{}",
                    Opacity(*fill_opacity)
                )?;
                if let Some(stroke) = stroke {
                    write!(f, " stroke=\"{stroke}\" stroke-width=\"{}\"", stroke_width.unwrap_or(1.0))?;
                }
                writeln!(f, "/>")
            }
            Primitive::Rect { x, y, width, height, fill, opacity } => {
                let shape = format!("x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"");
                writeln!(f, "<rect {shape} fill=\"{fill}\"{}/>", Opacity(*opacity))
            }
            Primitive::Path(path) => {
                let PathData { pieces, fill, stroke, stroke_width, opacity } = path.as_ref();
                write!(f, "<path d=\"{}\" fill=\"{fill}\"{}", PathText(pieces), Opacity(*opacity))?;
                if *stroke != Colour::None {
                    write!(
                        f,
                        " stroke=\"{stroke}\" stroke-width=\"{stroke_width}\" stroke-linejoin=\"round\""
                    )?;
                }
                writeln!(f, "/>")
            }
            Primitive::Text { x, y, content, size, anchor, rotate, bold, color } => {
                write!(f, "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\"")?;
                match anchor {
                    TextAnchor::Start => Ok(()),
                    TextAnchor::Middle => f.write_str(" text-anchor=\"middle\""),
                    TextAnchor::End => f.write_str(" text-anchor=\"end\""),
                }?;
                if let Some(turn) = rotate {
                    write!(f, " transform=\"rotate({turn},{x:.2},{y:.2})\"")?;
                }
                if *bold {
                    f.write_str(" font-weight=\"bold\"")?;
                }
                if let Some(colour) = color {
                    write!(f, " fill=\"{colour}\"")?;
                }
                writeln!(f, ">{}</text>", escaped(content))
            }
            Primitive::GroupStart { right: 0.0, down: 0.0 } => writeln!(f, "<g>"),
            Primitive::GroupStart { right, down } => {
                writeln!(f, "<g transform=\"translate({right:.2},{down:.2})\">")
            }
            Primitive::ClipStart { .. } => Ok(()),
            Primitive::GroupEnd | Primitive::ClipEnd => writeln!(f, "</g>"),
        }
    }
}

/// Strokes and gaps as an attribute.
struct Dashes<'a>(Option<&'a str>);

impl fmt::Display for Dashes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |dashes| write!(f, " stroke-dasharray=\"{dashes}\""))
    }
}

/// The opacity of a ground as an attribute.
struct Opacity(Option<f64>);

impl fmt::Display for Opacity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |share| write!(f, " fill-opacity=\"{share}\""))
    }
}

/// Pieces of straight lines as the commands of a path.
struct PathText<'a>(&'a [Vec<PaperPoint>]);

impl fmt::Display for PathText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for piece in self.0 {
            let closed = piece.len() > 2 && piece.first() == piece.last();
            for (k, (x, y)) in piece[..piece.len() - usize::from(closed)].iter().enumerate() {
                write!(f, "{}{x:.2} {y:.2}", if k == 0 { 'M' } else { 'L' })?;
            }
            if closed {
                f.write_str("Z")?;
            }
        }
        Ok(())
    }
}

/// Text without what SVG takes for its own signs.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_and_written() {
        assert_eq!(Colour::from("#0072b2"), Colour::Rgb([0, 0x72, 0xb2]));
        assert_eq!(Colour::Rgb([0, 0x72, 0xb2]).to_string(), "#0072b2");
        for text in ["none", "", "#00", "#0072b2ff", "0072b2", "#é72b2"] {
            assert_eq!(Colour::from(text), Colour::None, "{text}");
        }
    }

    #[test]
    fn every_primitive_is_written() {
        let mut scene = Canvas::new(20.0, 10.0);
        let square = vec![(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 0.0)];
        let path = PathData {
            pieces: vec![square, vec![(1.0, 1.0), (2.0, 2.5)]],
            fill: Colour::Rgb([255, 0, 0]),
            stroke: Colour::None,
            stroke_width: 0.0,
            opacity: Some(0.5),
        };
        scene.elements = vec![
            Primitive::ClipStart { x: 1.0, y: 2.0, width: 3.0, height: 4.0 },
            Primitive::Path(Box::new(path)),
            Primitive::ClipEnd,
            Primitive::Text {
                x: 1.0,
                y: 2.0,
                content: "a < b & c".into(),
                size: 12,
                anchor: TextAnchor::End,
                rotate: Some(-90.0),
                bold: true,
                color: Some(Colour::from("#222222")),
            },
        ];
        let svg = scene.svg("it");
        for words in [
            "<clipPath id=\"it-1\"><rect x=\"1.00\" y=\"2.00\" width=\"3.00\" height=\"4.00\"/></clipPath>",
            "<g clip-path=\"url(#it-1)\">",
            "<path d=\"M0.00 0.00L4.00 0.00L4.00 4.00ZM1.00 1.00L2.00 2.50\" fill=\"#ff0000\" fill-opacity=\"0.5\"/>",
            "text-anchor=\"end\" transform=\"rotate(-90,1.00,2.00)\" font-weight=\"bold\" fill=\"#222222\">a &lt; b &amp; c</text>",
        ] {
            assert!(svg.contains(words), "{words}\n{svg}");
        }
        assert_eq!(svg.matches("<g").count(), svg.matches("</g>").count());
    }
}
