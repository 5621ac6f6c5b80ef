//! Preset `full`: a strip model with three-dimensional, delayed wash.
//!
//! Every strip carries two or three lags of the wash on its chord and one or two of the wash of
//! the wake. The potential jump on the chord, not only the circulation, induces
//! a three-dimensional wash, which makes lift and added mass drop together at
//! low aspect ratio; flow is tangent at 3/4 chord under the true horseshoes of
//! the folded, moving wing. Valid for attached flow, aspect ratio 3 and more.

mod constants;
mod grid;
mod influence;
mod loads;
mod motion;
mod response;
mod settings;

pub use constants::Lags;
pub use settings::{LagSet, StripSettings};

use crate::Error;
use crate::aero::law::separation_scale;
use crate::aero::{Loads, MAX_STRIPS, Planform, SectionMotion, Sections, Wrench};
use crate::math::{Scalar, Vec3};
use crate::plant::Channel;
use grid::Grid;
use influence::{Column, Matrix, Targets, invert};
use motion::{Edge, Strip};
use std::f64::consts::PI;

/// Core radius of a trailing vortex over the half width of the narrower strip beside it: a
/// choice, small against the strip, that keeps a folded panel finite where it meets a vortex.
const CORE: f64 = 0.15;

/// The strip model of a wing. Sections are the edges between strips.
#[derive(Clone, Debug)]
pub struct StripModel {
    settings: StripSettings,
    grid: Grid,
    separation_scale: f64,
    lags: &'static Lags,
    /// Smoothing speed, m/s.
    floor: f64,
    /// Squared core radii of the vortices that leave the edges, m2.
    cores: Vec<f64>,
    /// Per strip: circulation over lift wash 2 pi b cos(sweep), m.
    slope: Vec<f64>,
    /// Per strip: chord doublet over wash, pi b cos(sweep) / 1.5, m.
    doublet: Vec<f64>,
    /// Per strip: circulatory force over wash and speed, rho dy 2 pi b cos(sweep), kg/m.
    lift_scale: Vec<f64>,
    /// Per strip: profile drag over speed squared and coefficient, rho c dy / 2, kg/m.
    drag_scale: Vec<f64>,
    /// Per strip: added mass as part of an infinite wing, kg.
    strip_mass: Vec<f64>,
    /// Per strip: own two-dimensional wash of the bound vortex, 1/m.
    own_bound: Vec<f64>,
    /// Per strip: own two-dimensional wash of bound vortex and trailing edge, 1/m.
    own_ring: Vec<f64>,
    /// One over the lengths over which the wake lags act, 1/m.
    inverse_wake_length: Vec<f64>,
    /// Per strip: one over the half chord, 1/m.
    turnover: Vec<f64>,
}

/// What the strips know of the air at one instant.
struct Flow<S: Scalar, const N: usize> {
    strips: [Strip<S>; N],
    /// Chordwise and smooth speed of the air at 3/4 chord, m/s.
    along: Column<S, N>,
    speed: Column<S, N>,
    /// Wash of motion at 3/4 and 1/2 chord, m/s, and the rate of the latter, m/s2.
    wash: Column<S, N>,
    half: Column<S, N>,
    half_rate: Column<S, N>,
    /// Wash of horseshoes without the own two-dimensional part, 1/m.
    remainder: Matrix<S, N>,
    /// Half the wash far behind, 1/m.
    far: Matrix<S, N>,
    /// The same as `remainder` for the chord doublet, 1/m.
    doublet: Matrix<S, N>,
    /// Inverse of 1 - doublet diag(d): the wash which motion leaves on the chord.
    relief: Matrix<S, N>,
}

impl StripModel {
    /// Lays strips on the planform.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting has no physical meaning or there are too few strips
    /// for the hinges.
    pub fn new(planform: &Planform, settings: StripSettings) -> Result<Self, Error> {
        settings.check()?;
        let grid = Grid::new(planform, settings.strips, &settings.hinge_arcs_m)?;
        let lags = settings.lags.lags();
        let per_strip = |f: &dyn Fn(f64, f64, f64) -> f64| -> Vec<f64> {
            (0..settings.strips)
                .map(|i| f(grid.chord[i], grid.cos_half[i], grid.cos_three_quarter[i]))
                .collect()
        };
        // What a gap carries is nothing: its neighbours then shed at its two borders.
        let carried = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let strip = |i: usize| if grid.covered[i] { f(grid.chord[i], grid.cos_half[i]) } else { 0.0 };
            (0..settings.strips).map(strip).collect()
        };
        let per_width = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let scale = carried(f).into_iter().zip(&grid.width);
            scale.map(|(value, width)| settings.density_kg_m3 * width * value).collect()
        };
        let delay_scale = grid.mean_chord * grid.aspect.powf(lags.exponent);
        Ok(Self {
            slope: carried(&|c, cos| PI * c * cos),
            doublet: carried(&|c, cos| PI * c * cos / 3.0),
            lift_scale: per_width(&|c, cos| PI * c * cos),
            drag_scale: per_width(&|c, _| 0.5 * c),
            strip_mass: per_width(&|c, cos| PI * c * c * cos / 4.0),
            own_bound: per_strip(&|c, cos, _| 1.0 / (PI * c * cos)),
            own_ring: per_strip(&|c, cos, cos34| 1.0 / (PI * c * cos) + 2.0 / (PI * c * cos34)),
            inverse_wake_length: lags.wake_delay.iter().map(|t| 1.0 / (t * delay_scale)).collect(),
            turnover: grid.chord.iter().map(|c| 2.0 / c).collect(),
            floor: settings.regularisation_m_s,
            cores: grid.half_widths().map(|h| (CORE * h) * (CORE * h)).collect(),
            separation_scale: separation_scale(settings.stall_angle_rad),
            lags,
            grid,
            settings,
        })
    }

    /// The settings in use.
    pub fn settings(&self) -> &StripSettings {
        &self.settings
    }
    /// Number of strips.
    pub fn strips(&self) -> usize {
        self.settings.strips
    }
    /// Number of states: for each wash lag and then for each wake lag a block
    /// of one value per strip, left tip to right tip.
    pub fn states(&self) -> usize {
        self.settings.strips * self.lags.states_per_strip()
    }
    /// Arc coordinates, m, of the sections wanted: the edges of the strips from left tip
    /// (positive) to right tip.
    pub fn arcs(&self) -> &[f64] {
        &self.grid.arcs
    }
    /// Names and units of the states, in order.
    pub fn channels(&self) -> Vec<Channel> {
        let wash = (1..=self.lags.rate.len()).map(|k| (format!("wash_lag{k}"), "m/s"));
        let wake = (1..=self.lags.wake.len()).map(|k| (format!("wake_lag{k}"), "m2/s"));
        wash.chain(wake)
            .flat_map(|(name, unit)| {
                (0..self.strips()).map(move |i| Channel::free(format!("{name}_{i}"), unit, ""))
            })
            .collect()
    }
    /// Arc coordinates of the control sections, m.
    pub fn strip_arcs(&self) -> &[f64] {
        &self.grid.control_arcs
    }
    /// Widths of the strips, m.
    pub fn widths(&self) -> &[f64] {
        &self.grid.width
    }
    /// Chords of the control sections, m.
    pub fn chords(&self) -> &[f64] {
        &self.grid.chord
    }

    /// Loads and state rates.
    ///
    /// `sections` are the edges in the order of [`arcs`](Self::arcs), `wind` the
    /// velocity of the air in B, `x` the states (m/s for wash lags, m2/s for wake
    /// lags), `dx` receives their rates. The accelerations of the sections leave out what the
    /// body's own acceleration adds: see [`Loads`].
    ///
    /// # Panics
    /// When a slice is shorter than `arcs()` or `states()` ask for.
    pub fn evaluate<S: Scalar>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) {
        let (wrench, added_mass) = self.dispatch(sections, wind, x, dx, Some(&mut *loads));
        loads.wrench = wrench;
        loads.added_mass = added_mass;
    }

    /// As [`evaluate`](Self::evaluate) for the sum alone: the wrench and the
    /// added-mass matrix.
    pub fn evaluate_sum<S: Scalar>(
        &self,
        sections: &(impl Sections<S> + ?Sized),
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
    ) -> (Wrench<S>, [[S; 6]; 6]) {
        let mut edges = [SectionMotion::default(); MAX_STRIPS + 1];
        for (j, edge) in edges[..=self.settings.strips].iter_mut().enumerate() {
            *edge = sections.section(j);
        }
        self.dispatch(&edges, wind, x, dx, None)
    }

    /// Chooses the width of the columns.
    fn dispatch<S: Scalar>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: Option<&mut Loads<S>>,
    ) -> (Wrench<S>, [[S; 6]; 6]) {
        match self.settings.strips {
            0..=8 => self.evaluate_in::<S, 8>(sections, wind, x, dx, loads),
            9..=12 => self.evaluate_in::<S, 12>(sections, wind, x, dx, loads),
            13..=16 => self.evaluate_in::<S, 16>(sections, wind, x, dx, loads),
            17..=24 => self.evaluate_in::<S, 24>(sections, wind, x, dx, loads),
            _ => self.evaluate_in::<S, MAX_STRIPS>(sections, wind, x, dx, loads),
        }
    }

    /// The evaluation with columns of `N` lanes, of which `strips()` count.
    fn evaluate_in<S: Scalar, const N: usize>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: Option<&mut Loads<S>>,
    ) -> (Wrench<S>, [[S; 6]; 6]) {
        let flow = self.flow::<S, N>(sections, wind);
        let states = self.states();
        let response = self.respond(&flow, &x[..states], &mut dx[..states]);
        let wrench = self.load_strips(&flow, &response, loads);
        (wrench, self.added_mass(&flow, &response))
    }

    /// Points, velocities and influence of the wing as it lies and moves now.
    ///
    /// R = horseshoe + 1/(pi c cos L_1/2) on the diagonal,
    /// K = beta (ring + own two-dimensional ring), A0 = 1 - K diag(d).
    ///
    /// Equation: aero.strip.remainder
    #[inline(always)]
    fn flow<S: Scalar, const N: usize>(&self, sections: &[SectionMotion<S>], wind: Vec3<S>) -> Flow<S, N> {
        let n = self.settings.strips;
        let strips: [Strip<S>; N] = std::array::from_fn(|i| self.strip(sections, wind, i.min(n - 1)));
        let mut edges = [Edge::default(); MAX_STRIPS + 1];
        for (j, edge) in edges[..=n].iter_mut().enumerate() {
            *edge = self.edge(sections, wind, j);
        }
        let mut wash = Targets::new(&strips).wash(&edges[..=n], &self.cores);
        if !self.settings.wake_wash {
            wash.horseshoe = [[S::ZERO; N]; N];
            wash.far = [[S::ZERO; N]; N];
        }
        let beta = if self.settings.doublet_wash { self.lags.doublet } else { 0.0 };
        let mut relief = [[S::ZERO; N]; N];
        for j in 0..n {
            if self.settings.wake_wash {
                wash.horseshoe[j][j] = wash.horseshoe[j][j] + self.own_bound[j];
            }
            wash.ring[j][j] = wash.ring[j][j] + self.own_ring[j];
            for i in 0..N {
                wash.ring[j][i] *= beta;
                relief[j][i] = -(wash.ring[j][i] * self.doublet[j]);
            }
            relief[j][j] = relief[j][j] + 1.0;
        }
        invert(&mut relief, n);
        Flow {
            along: std::array::from_fn(|i| strips[i].along),
            speed: std::array::from_fn(|i| strips[i].speed),
            wash: std::array::from_fn(|i| strips[i].wash),
            half: std::array::from_fn(|i| strips[i].wash_half),
            half_rate: std::array::from_fn(|i| strips[i].wash_half_rate),
            strips,
            remainder: wash.horseshoe,
            far: wash.far,
            doublet: wash.ring,
            relief,
        }
    }
}
