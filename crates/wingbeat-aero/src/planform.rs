//! The flat outline of the wing by arc length from the middle.

use wingbeat_math::Error;
use wingbeat_math::interpolation::piecewise_linear;
use wingbeat_math::{DeclaredQuantity, Parameters, Scalar, Walk};

/// Leading and trailing edge at one spanwise position of the half wing.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanformStation {
    /// Arc length from the plane of symmetry, m.
    pub arc_m: f64,
    /// Leading edge ahead of the hinge line, m (forward positive).
    pub leading_edge_m: f64,
    /// Trailing edge ahead of the hinge line, m (forward positive; usually negative).
    pub trailing_edge_m: f64,
}

/// A stretch of both half wings where there is no wing. The strips beside it end a little
/// short of it, as at a tip: narrower than a few hundredths of the pieces beside it, its
/// width is not resolved.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "Gap")]
#[serde(deny_unknown_fields)]
pub struct Gap<P = f64> {
    /// Arc length from the plane of symmetry at which the gap begins, m.
    pub from_arc_m: P,
    /// Arc length at which it ends, m.
    pub to_arc_m: P,
}

/// What the outline of a half wing is laid out to.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Span {
    /// Both halves, one the mirror image of the other.
    #[default]
    Symmetric,
    /// That half alone, its tip to the left.
    Left,
    /// That half alone, its tip to the right.
    Right,
}

/// How far beyond a hinge a section still lies on it, over the half span: left and right differ by rounding.
const ON_HINGE: f64 = 1e-9;

/// A wing given by stations of one half with straight edges between them. The arc coordinate s runs
/// from the left end, half a span, to the right end, minus half a span. Its numbers may carry derivatives; of what lies
/// exactly on a station they are those of one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Planform<P = f64> {
    span: Span,
    arcs: Vec<P>,
    leading: Vec<P>,
    trailing: Vec<P>,
    gaps: Vec<Gap<P>>,
}

impl Planform {
    /// Checks and stores the stations of the half wing, ascending from the middle.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there are fewer than two stations, arcs do not
    /// start at zero and ascend, or a chord is not positive.
    pub fn new(stations: &[PlanformStation]) -> Result<Self, Error> {
        let fail = |i: usize, key: &str, value: f64, allowed: &str, other: (usize, &str)| {
            let error = Error::invalid(format!("planform[{i}].{key}"), value, allowed);
            Err(error.against([format!("planform[{}].{}", other.0, other.1)]))
        };
        if stations.len() < 2 {
            let given = format!("{} stations", stations.len());
            return Err(Error::invalid("planform", given, "at least two stations"));
        }
        if stations[0].arc_m != 0.0 {
            return Err(Error::invalid(
                "planform[0].arc_m",
                stations[0].arc_m,
                "0: the plane of symmetry; a wing that begins outboard of it leaves that out by `gaps`",
            ));
        }
        for (i, s) in stations.iter().enumerate() {
            if i > 0 && !(s.arc_m > stations[i - 1].arc_m) {
                return fail(i, "arc_m", s.arc_m, "more than the station before", (i - 1, "arc_m"));
            }
            if !(s.leading_edge_m - s.trailing_edge_m > 0.0) {
                let trailing = (i, "trailing_edge_m");
                return fail(i, "leading_edge_m", s.leading_edge_m, "ahead of the trailing edge", trailing);
            }
        }
        Ok(Self {
            span: Span::Symmetric,
            arcs: stations.iter().map(|s| s.arc_m).collect(),
            leading: stations.iter().map(|s| s.leading_edge_m).collect(),
            trailing: stations.iter().map(|s| s.trailing_edge_m).collect(),
            gaps: Vec::new(),
        })
    }

    /// Checks what [`new`](Self::new) and [`with_gaps`](Self::with_gaps) ask of its numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn check(&self) -> Result<(), Error> {
        let edges = self.leading.iter().zip(&self.trailing);
        let station = |(&arc_m, (&leading_edge_m, &trailing_edge_m))| PlanformStation {
            arc_m,
            leading_edge_m,
            trailing_edge_m,
        };
        let stations: Vec<PlanformStation> = self.arcs.iter().zip(edges).map(station).collect();
        Self::new(&stations)?.with_gaps(&self.gaps).map(drop)
    }

    /// Leaves out the wing in `gaps`, ascending from the middle; the stations run on across them.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a gap is empty, meets another or reaches the tip.
    pub fn with_gaps(mut self, gaps: &[Gap]) -> Result<Self, Error> {
        let tip = self.half_span();
        let mut before: Option<f64> = None;
        for (i, gap) in gaps.iter().enumerate() {
            if !(gap.from_arc_m >= 0.0 && before.is_none_or(|end| gap.from_arc_m > end)) {
                let allowed =
                    before.map_or("0 or more".into(), |end| format!("more than {end}: wing between"));
                let error = Error::invalid(format!("gaps[{i}].from_arc_m"), gap.from_arc_m, allowed);
                return Err(error.against(i.checked_sub(1).map(|before| format!("gaps[{before}].to_arc_m"))));
            }
            if !(gap.to_arc_m > gap.from_arc_m && gap.to_arc_m < tip) {
                let allowed = format!("more than from_arc_m and less than the half span {tip}");
                let error = Error::invalid(format!("gaps[{i}].to_arc_m"), gap.to_arc_m, allowed);
                return Err(error.against([format!("gaps[{i}].from_arc_m")]));
            }
            before = Some(gap.to_arc_m);
        }
        self.gaps = gaps.to_vec();
        Ok(self)
    }

    /// Lays the outline out to one half alone, or to both.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a one-sided surface has gaps.
    pub fn spanning(mut self, span: Span) -> Result<Self, Error> {
        if span != Span::Symmetric && !self.gaps.is_empty() {
            return Err(Error::invalid("gaps", self.gaps.len(), "none on a one-sided surface"));
        }
        self.span = span;
        Ok(self)
    }
}

/// A coordinate of an outline.
pub const COORDINATE: DeclaredQuantity = DeclaredQuantity::free("m");

/// The first arc is zero by definition.
impl<P: Scalar> Parameters<P> for Planform<P> {
    type In<Q: Scalar> = Planform<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> Planform<Q> {
        let mut of = |key: &str, numbers: &[P], fixed: usize| {
            let number = |(i, number): (usize, &P)| match i < fixed {
                true => at.fixed(*number),
                false => at.item("planform", "", i, |at| at.number(key, &COORDINATE, *number)),
            };
            numbers.iter().enumerate().map(number).collect()
        };
        Planform {
            span: self.span,
            arcs: of("arc_m", &self.arcs, 1),
            leading: of("leading_edge_m", &self.leading, 0),
            trailing: of("trailing_edge_m", &self.trailing, 0),
            gaps: at.list(("gaps", ""), &self.gaps, |at, gap| Gap {
                from_arc_m: at.number("from_arc_m", &COORDINATE, gap.from_arc_m),
                to_arc_m: at.number("to_arc_m", &COORDINATE, gap.to_arc_m),
            }),
        }
    }
}

impl<P: Scalar> Planform<P> {
    /// What the outline is laid out to.
    pub fn span(&self) -> Span {
        self.span
    }
    /// Arc length from the root at the arc coordinate `s`, m.
    pub fn from_root(&self, s: P) -> P {
        match self.span {
            Span::Symmetric => s.abs(),
            Span::Left => s + self.half_span(),
            Span::Right => self.half_span() - s,
        }
    }
    /// Whether the arc coordinate `s` (m) lies on the left half.
    pub fn on_left(&self, s: P) -> bool {
        match self.span {
            Span::Symmetric => s.value() >= 0.0,
            Span::Left => true,
            Span::Right => false,
        }
    }
    /// The arc coordinates at the arc length `arc` from the root, m.
    pub fn coordinates(&self, arc: P) -> Vec<P> {
        match self.span {
            Span::Symmetric => vec![-arc, arc],
            Span::Left => vec![arc - self.half_span()],
            Span::Right => vec![self.half_span() - arc],
        }
    }

    /// Whether the arc length `arc` from the root lies beyond `hinge`, m. A section on a hinge lies within it:
    /// rounding must not give it to one side.
    pub fn beyond(&self, arc: P, hinge: P) -> bool {
        arc - hinge > self.half_span() * ON_HINGE
    }

    /// Arc lengths from the root of the stations, m.
    pub fn station_arcs(&self) -> &[P] {
        &self.arcs
    }
    /// Where there is no wing, ascending from the middle.
    pub fn gaps(&self) -> &[Gap<P>] {
        &self.gaps
    }
    /// Whether there is wing at the arc coordinate `s` (m) (either side).
    pub fn covers(&self, s: P) -> bool {
        let inboard = s.abs() <= self.half_span();
        let s = self.from_root(s);
        // A gap from the plane of symmetry on is one gap with its mirror image.
        let inside = |g: &Gap<P>| (s > g.from_arc_m || g.from_arc_m.value() == 0.0) && s < g.to_arc_m;
        inboard && !self.gaps.iter().any(inside)
    }
    /// Half span without the gaps, m.
    pub fn covered_half_span(&self) -> P {
        self.gaps.iter().fold(self.half_span(), |span, g| span - (g.to_arc_m - g.from_arc_m))
    }

    /// Mean chord without the gaps, m.
    pub fn mean_chord(&self) -> P {
        self.area() / (self.covered_half_span() * 2.0)
    }

    /// Number of stations.
    pub fn stations(&self) -> usize {
        self.arcs.len()
    }

    /// Half of the length along the arc from end to end, m.
    pub fn half_span(&self) -> P {
        let outline = self.arcs[self.arcs.len() - 1];
        if self.span == Span::Symmetric { outline } else { outline * 0.5 }
    }
    /// Leading and trailing edge ahead of the hinge line at the arc coordinate
    /// `s` (either side), m.
    pub fn edges(&self, s: P) -> (P, P) {
        let at = |ys| piecewise_linear(&self.arcs, ys, self.from_root(s));
        (at(&self.leading), at(&self.trailing))
    }
    /// Chord at the arc coordinate `s`, m.
    pub fn chord(&self, s: P) -> P {
        let (leading, trailing) = self.edges(s);
        leading - trailing
    }
    /// Slope, dimensionless, of the line of the quarter chords along the arc coordinate `s` (m), positive where the line runs
    /// forward to the left: that of the outline between two stations; in the middle of a symmetric wing, where it has two,
    /// none.
    pub fn sweep(&self, s: P) -> P {
        if self.span == Span::Symmetric && s.is_zero() {
            return P::ZERO;
        }
        let arc = self.from_root(s);
        let last = self.arcs.len() - 1;
        let k = self.arcs.partition_point(|station| *station <= arc).clamp(1, last);
        let quarter = |i: usize| self.leading[i] * 0.75 + self.trailing[i] * 0.25;
        let slope = (quarter(k) - quarter(k - 1)) / (self.arcs[k] - self.arcs[k - 1]);
        if self.on_left(s) { slope } else { -slope }
    }
    /// Area of all halves laid out, without the gaps, m2 (trapezoids between stations).
    pub fn area(&self) -> P {
        let whole = self.area_between(P::ZERO, self.arcs[self.arcs.len() - 1]);
        let halves: f64 = if self.span == Span::Symmetric { 2.0 } else { 1.0 };
        self.gaps.iter().fold(whole, |area, g| area - self.area_between(g.from_arc_m, g.to_arc_m)) * halves
    }

    /// Integrals of the chord, m2, and of its square, m3, between two arc coordinates, `from` < `to`, m.
    pub fn chord_integrals(&self, from: P, to: P) -> [P; 2] {
        self.stretches(from, to).windows(2).fold([P::ZERO; 2], |[area, square], s| {
            let (length, a, b) = (s[1] - s[0], self.chord(s[0]), self.chord(s[1]));
            [area + length * (a + b) / 2.0, square + length * (a * a + a * b + b * b) / 3.0]
        })
    }

    /// How far ahead of the straight lines between two arc coordinates, m, the leading and the trailing edge lie at `s` between
    /// them, m.
    pub fn ahead_of_lines(&self, [from, to]: [P; 2], s: P) -> [P; 2] {
        let [(leading, trailing), (leading_to, trailing_to), (leading_at, trailing_at)] =
            [from, to, s].map(|arc| self.edges(arc));
        let share = (s - from) / (to - from);
        let line = |a: P, b: P| a + (b - a) * share;
        [leading_at - line(leading, leading_to), trailing_at - line(trailing, trailing_to)]
    }

    /// The mean of [`Planform::ahead_of_lines`] from `from` to `to`, m: nothing without a station between them.
    pub fn bulge(&self, from: P, to: P) -> [P; 2] {
        let stretches = self.stretches(from, to);
        let at = |s: P| if s == from || s == to { [P::ZERO; 2] } else { self.ahead_of_lines([from, to], s) };
        stretches.windows(2).fold([P::ZERO; 2], |mean, s| {
            let (share, ahead) = ((s[1] - s[0]) / (to - from), [at(s[0]), at(s[1])]);
            std::array::from_fn(|edge| mean[edge] + share * (ahead[0][edge] + ahead[1][edge]) * 0.5)
        })
    }

    /// The arc coordinates between which the edges are straight, from `from` to `to`, m.
    fn stretches(&self, from: P, to: P) -> Vec<P> {
        let stations = self.arcs.iter().flat_map(|arc| self.coordinates(*arc));
        let mut bounds: Vec<P> = stations.filter(|s| *s > from && *s < to).chain([from, to]).collect();
        wingbeat_math::order::ascend_by(&mut bounds, |item| item.value());
        bounds
    }

    /// Area of one half between two arc lengths from the root, m2.
    fn area_between(&self, from: P, to: P) -> P {
        let between = self.arcs.iter().copied().filter(|s| *s > from && *s < to);
        let bounds: Vec<P> = std::iter::once(from).chain(between).chain([to]).collect();
        let chord = |arc: P| {
            piecewise_linear(&self.arcs, &self.leading, arc)
                - piecewise_linear(&self.arcs, &self.trailing, arc)
        };
        let pieces = bounds.windows(2).map(|a| (a[1] - a[0]) * 0.5 * (chord(a[0]) + chord(a[1])));
        pieces.fold(P::ZERO, |sum, piece| sum + piece)
    }
}
