//! A wing whose halves are bent by the air: beams between its root and its strips.

use super::recorder::TetherRecorder;
use super::wing::{Frame, motion};
use super::{Coordinate, Side, Tether, TetherRun};
use crate::simulate::{Column, Held, Moment, Observed, Sizes, Stepper, System};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;
use wingbeat_aero::{Aero, Loads, SectionMotion};
use wingbeat_math::{Error, Jet, Mat3, Scalar, Vec3, Wrench, require};
use wingbeat_ocp::plant::{Early, Fault};
use wingbeat_structure::{
    Beam, Implicit, Place, Rule, Setting, Stage, StepFactors, Swung, frequencies, linear, of_first_order,
    step,
};

/// Newton steps in the search of a shape at rest.
const MOST: usize = 25;
/// Change of the strains over their size at which a shape is found.
const FOUND: f64 = 1e-9;
/// Twist and curvature, rad/m, that are none. *Choice.*
const NO_STRAIN: f64 = 1e-6;
/// Size of the states of the air over the speed of reference, m/s over m/s, by which changes of smaller ones are measured. *Choice.*
const NO_WASH: f64 = 1e-3;
/// Reduced frequency omega c/(2 V) up to which a motion of the beam is flutter where it grows: lift is compared up to 1. Faster ones are hardly damped by air, none
/// with its axis at 3/4 of the chord, and the error of the strips makes them grow by 2e-5 of their frequency. *Choice.*
const FAST: f64 = 2.0;
/// Shares of the loads under which the shape is sought one after another.
const SHARES: usize = 4;

/// Lowest frequencies of a spar that are judged. *Choice.*
const JUDGED: usize = 3;

/// What the columns of its coordinates begin with.
pub const STRAIN: &str = "spar_strain_";

/// The beam of each half, mirror images of each other: x outboard, y aft, z up.
#[derive(Clone, Debug)]
pub struct Spar {
    /// The beam of the left half.
    pub beam: Beam,
    /// The same with more coordinates, which tells how much the shape at rest depends on them.
    pub finer: Option<Beam>,
    /// Arc at which it is clamped; the wing is rigid inboard, m.
    pub root_m: f64,
    /// Its reference line ahead of the hinge line, m.
    pub ahead_m: f64,
    /// Acceleration of gravity in W that it feels, m/s2.
    pub gravity: Vec3,
    /// Damping over stiffness, s.
    pub damping_s: f64,
}

/// Frequencies of the unbent beam without air, Hz.
fn unbent_hz(beam: &Beam) -> Vec<f64> {
    let rest = frequencies(&linear(beam, &Setting::default(), &vec![0.0; beam.coordinates()]));
    rest.iter().map(|mode| mode.0 / std::f64::consts::TAU).collect()
}

/// The shape of the beam at one instant.
#[derive(Clone, Debug, Default)]
pub struct Bent {
    /// Coordinates, their rates and accelerations, in the units of the beam's strains, per s and per s2.
    pub q: [Vec<f64>; 3],
    /// What holds the root of the left half, in W about it, N and N m.
    pub root: Wrench<f64>,
}

impl Bent {
    /// The same at rest.
    pub fn still(&self) -> Self {
        let zero = vec![0.0; self.q[0].len()];
        Self { q: [self.q[0].clone(), zero.clone(), zero], root: self.root }
    }
}

/// A shape at rest in the wind, and what becomes of small disturbances.
#[derive(Clone, Debug, Default)]
pub struct Steady {
    /// Whether it was found.
    pub found: bool,
    /// Coordinates of the beam, in the units of its strains.
    pub q: Vec<f64>,
    /// States of the air, in the units of its models.
    pub x: Vec<f64>,
    /// Displacement of the tip's reference line up and ahead (m) and its twist nose up (rad), in the axes of the root.
    pub tip: [f64; 3],
    /// Frequencies of the unbent beam without air, Hz, ascending.
    pub frequencies_hz: Vec<f64>,
    /// Growth rate (1/s) and frequency (rad/s) of the motion that decays least beside its own frequency, or the lowest of the beam where that is larger:
    /// of those up to a reduced frequency of 2, or the third of the beam where that is faster.
    pub least_damped: [f64; 2],
    /// The same of faster ones.
    pub least_damped_fast: Option<[f64; 2]>,
    /// Relative distance: how far the tip of a beam with more coordinates is from this one, over its displacement or, where
    /// that is larger, a hundredth of its length.
    pub grid_change: Option<f64>,
    /// Relative change of the lowest frequency of the unbent beam with more coordinates, and the largest of the three lowest.
    pub frequency_change: Option<[f64; 2]>,
}

/// What a spar carries from step to step.
#[derive(Clone, Default)]
struct Memory {
    a: Vec<f64>,
    w: Vec<f64>,
    factors: StepFactors,
}

/// A wing with the air and its beam.
struct CoupledSpar<'a> {
    tether: &'a Tether,
    spar: &'a Spar,
    /// Held as it is at this time, where it is.
    still: Option<f64>,
    /// Share of the loads.
    share: f64,
}

/// A way to evaluate the model of the air in one kind of number.
type SparAir<'a, S> = dyn Fn(&[SectionMotion<S>], Vec3<S>, &[S], &mut [S], &mut Loads<S>) + 'a;

fn lifted<S: Scalar>(m: &SectionMotion<f64>) -> SectionMotion<S> {
    let v = |v: Vec3| v.each(S::from);
    SectionMotion {
        le: v(m.le),
        te: v(m.te),
        v_le: v(m.v_le),
        v_te: v(m.v_te),
        a_le: v(m.a_le),
        a_te: v(m.a_te),
        span: v(m.span),
        w: v(m.w),
        alpha: v(m.alpha),
    }
}

/// The same section of the other half.
fn mirrored<S: Scalar>(m: SectionMotion<S>) -> SectionMotion<S> {
    let v = |v: Vec3<S>| Vec3([v[0], -v[1], v[2]]);
    let axial = |v: Vec3<S>| Vec3([-v[0], v[1], -v[2]]);
    SectionMotion {
        le: v(m.le),
        te: v(m.te),
        v_le: v(m.v_le),
        v_te: v(m.v_te),
        a_le: v(m.a_le),
        a_te: v(m.a_te),
        span: -v(m.span),
        w: axial(m.w),
        alpha: axial(m.alpha),
    }
}

impl Spar {
    /// Arc coordinates outboard of the root at which the beam needs nodes for the sections of a model, m from the root.
    pub fn arcs(aero: &Aero, root_m: f64) -> Vec<f64> {
        // Those of the edges, and those of the strips, whose motion gives their power.
        let all = aero.arcs().iter().chain(aero.strip_arcs());
        all.map(|arc| arc - root_m).filter(|arc| *arc > 0.0).collect()
    }

    /// Refuses motions that do not bend both halves alike, and hinges that the beam carries.
    pub(super) fn check(&self, tether: &Tether) -> Result<(), Error> {
        let span = tether.wing.planform().half_span();
        require::between("spar.root_m", self.root_m, 0.0, span)?;
        let refused = |key: &str, value: String, allowed: &str| Err(Error::invalid(key, value, allowed));
        if !matches!(tether.motion.roll, Coordinate::Constant(roll) if roll == 0.0) {
            return refused(
                "body.roll_deg",
                "a motion".into(),
                "0 of a wing with a spar, whose halves bend alike",
            );
        }
        if tether.wind[1] != 0.0 {
            return refused(
                "wind.sideslip_deg",
                "given".into(),
                "0 of a wing with a spar, whose halves bend alike",
            );
        }
        if self.gravity[1] != 0.0 && tether.side == Side::Both {
            return refused(
                "spar.gravity_m_s2",
                format!("{:?}", self.gravity.0),
                "no part to the left of a wing with both halves, which bend alike; wing.side = \"left\" has one",
            );
        }
        for (i, hinge) in tether.wing.hinges().iter().enumerate() {
            if hinge.arc_m > self.root_m || hinge.to_arc_m.is_some() || hinge.side != Side::Both {
                let allowed = format!("at most {}, the root of the spar, of both halves", self.root_m);
                return Err(Error::invalid(format!("hinges[{i}].arc_m"), hinge.arc_m, allowed));
            }
        }
        let length = span - self.root_m;
        if (self.beam.length() - length).abs() > 1e-9 * span {
            let allowed = format!("{length}, from its root to the tip of the wing");
            return Err(Error::invalid("spar.stations", self.beam.length(), allowed));
        }
        Ok(())
    }

    /// The place of the root of the left half.
    fn root(&self, tether: &Tether, body: &Frame<f64>, angles: &[Jet<f64>]) -> Swung {
        // Outboard of all hinges.
        let tip = tether.wing.planform().half_span();
        let (Frame { turn, origin }, _) = tether.wing.link(tip, body, angles);
        let [forward, left, up] = [0, 1, 2].map(|k| turn.column(k));
        let p = origin + left.scaled(self.root_m - tip) + forward.scaled(self.ahead_m);
        Place { p, r: Mat3::from_columns(left, -forward, up) }
    }

    fn setting(&self, root: Swung, share: f64) -> Setting {
        let (gravity, damping_s) = (self.gravity * share, self.damping_s);
        Setting { root, free: false, gravity, loads: Vec::new(), damping_s }
    }

    /// The section at an arc of the left half that lies at `place`.
    fn section<S: Scalar>(&self, tether: &Tether, arc: f64, place: &Place<Jet<S>>) -> SectionMotion<S> {
        let [left, aft, up] = [0, 1, 2].map(|k| place.r.column(k));
        let (leading, trailing) = tether.wing.planform().edges(arc);
        let at = |x: f64| place.p + aft.scaled(self.ahead_m - x);
        motion(Mat3::from_columns(-aft, left, up), [at(leading), at(trailing)])
    }

    /// Sections at `arcs` of the wing in the shape `bent`.
    pub(super) fn sections_at(
        &self,
        tether: &Tether,
        arcs: &[f64],
        body: &Frame<f64>,
        angles: &[Jet<f64>],
        bent: &Bent,
    ) -> Vec<SectionMotion<f64>> {
        let setting = self.setting(self.root(tether, body, angles), 1.0);
        let [q, v, a] = &bent.q;
        let places = self.beam.motion(&setting, q, v, a);
        let one = |arc: &f64| self.section_of(tether, *arc, &places, body, angles);
        arcs.iter().map(one).collect()
    }

    fn section_of<S: Scalar>(
        &self,
        tether: &Tether,
        arc: f64,
        places: &[Place<Jet<S>>],
        body: &Frame<f64>,
        angles: &[Jet<f64>],
    ) -> SectionMotion<S> {
        if !tether.wing.planform().beyond(arc.abs(), self.root_m) {
            return lifted(&tether.wing.section(arc, body, angles));
        }
        let left = self.section(tether, arc.abs(), &places[self.beam.nearest(arc.abs() - self.root_m)]);
        if arc < 0.0 { mirrored(left) } else { left }
    }

    /// Displacements of the tip in the axes of the root (up, ahead, nose up), and what holds the root in them.
    pub(super) fn seen(&self, tether: &Tether, t: f64, bent: &Bent) -> [f64; 9] {
        let root = self.root(tether, &tether.motion.body(t).frame(), &tether.motion.angles(t));
        let r = root.r.each(|j: Jet<f64>| j.x);
        // Forward, left, up.
        let own = |v: Vec3| {
            let [left, aft, up] = r.transpose_mul(v).0;
            [-aft, left, up]
        };
        let tip = self.tip(&bent.q[0]);
        let (force, moment) = (own(bent.root.force), own(bent.root.moment));
        [tip[0], tip[1], tip[2], force[0], force[1], force[2], moment[0], moment[1], moment[2]]
    }

    /// Columns of [`seen`](Self::seen).
    pub(super) fn columns(&self) -> Vec<Column> {
        let tip = [("tip_up", "m"), ("tip_ahead", "m"), ("tip_nose_up", "rad")];
        let mut columns: Vec<Column> = tip.map(|(name, unit)| Column::new(name, unit, "root")).into();
        columns.extend(["x", "y", "z"].map(|a| Column::new(format!("spar_force_{a}"), "N", "root")));
        columns.extend(["x", "y", "z"].map(|a| Column::new(format!("spar_moment_{a}"), "N m", "root")));
        let strains = 0..self.beam.coordinates();
        columns.extend(strains.map(|i| Column::new(format!("{STRAIN}{i}"), "1/m", "")));
        columns
    }

    /// Up and ahead (m) and nose up (rad): then the chord, which points aft along y, falls.
    fn tip(&self, q: &[f64]) -> [f64; 3] {
        self.line(q).last().map_or([0.0; 3], |[_, aft, up, nose_up]| [*up, -aft, *nose_up])
    }

    /// The shape of the reference line, in the axes of the root: outboard, aft and up (m), and twist nose up (rad).
    pub fn line(&self, q: &[f64]) -> Vec<[f64; 4]> {
        let along = self.beam.places(&Place::IDENTITY, q);
        along.iter().map(|Place { p, r }| [p[0], p[1], p[2], -r.0[2][1].atan2(r.0[1][1])]).collect()
    }

    /// The shape at rest in the wind with body and hinges held as they are at the time 0.
    pub fn steady(&self, tether: &Tether) -> Steady {
        let (at, found) = self.shape(tether);
        let frequencies_hz = unbent_hz(&self.beam);
        let (least_damped, least_damped_fast) = match found {
            true => self.least_damped(tether, &at, &frequencies_hz),
            false => ([f64::NAN; 2], None),
        };
        let tip = self.tip(&at.q);
        Steady {
            found,
            tip,
            q: at.q,
            x: at.x,
            frequencies_hz,
            least_damped,
            least_damped_fast,
            grid_change: None,
            frequency_change: None,
        }
    }

    /// The coordinates and the air of that shape, and whether it was found.
    fn shape(&self, tether: &Tether) -> (Stage, bool) {
        let (n, m) = (self.beam.coordinates(), tether.aero.states());
        let zero = |n| vec![0.0; n];
        let mut at = Stage { q: zero(n), v: zero(n), a: zero(n), x: zero(m), w: zero(m) };
        let mut found = false;
        let mut out = zero(n + m);
        // All at once, and where that fails one share after another.
        for k in std::iter::once(SHARES).chain(1..=SHARES) {
            let share = k as f64 / SHARES as f64;
            if k == 1 {
                (at.q, at.x) = (zero(n), zero(m));
            }
            let coupled = CoupledSpar { tether, spar: self, still: Some(0.0), share };
            found = false;
            for _ in 0..MOST {
                coupled.residual(0.0, &at, &mut out);
                let [by_q, _, _, by_x, _] = coupled.tangents(0.0, &at);
                let matrix =
                    DMatrix::from_fn(
                        n + m,
                        n + m,
                        |i, j| {
                            if j < n { by_q[(i, j)] } else { by_x[(i, j - n)] }
                        },
                    );
                let change = matrix.lu().solve(&DVector::from_column_slice(&out));
                let Some(change) = change.filter(|c| c.iter().all(|x| x.is_finite())) else { break };
                at.q.iter_mut().chain(&mut at.x).zip(change.iter()).for_each(|(x, c)| *x -= c);
                let size = at.q.iter().fold(NO_STRAIN, |most: f64, q| most.max(q.abs()));
                found = change.rows(0, n).amax() < FOUND * size;
                if found {
                    break;
                }
            }
            if found == (k == SHARES) {
                break;
            }
        }
        (at, found)
    }

    /// How much the tip at rest moves with more coordinates.
    fn grid_change(&self, tether: &Tether, steady: &Steady) -> Option<f64> {
        let finer = Self { beam: self.finer.clone()?, finer: None, ..self.clone() };
        let (shape, found) = finer.shape(tether);
        let at = found.then(|| finer.tip(&shape.q))?;
        let own = self.tip(&steady.q);
        let scale = own[0].hypot(own[1]).max(0.01 * self.beam.length());
        Some((at[0] - own[0]).hypot(at[1] - own[1]) / scale)
    }

    /// Change of the lowest frequency with more coordinates, over it, and the largest of the three lowest.
    fn frequency_change(&self, steady: &Steady) -> Option<[f64; 2]> {
        let finer = unbent_hz(self.finer.as_ref()?);
        let mut changes =
            steady.frequencies_hz.iter().zip(&finer).map(|(own, finer)| (own / finer - 1.0).abs());
        let lowest = changes.next()?;
        Some([lowest, changes.take(JUDGED - 1).fold(lowest, f64::max)])
    }

    /// Growth rate and angular frequency of the motion about a shape at rest that decays least, over its angular frequency or over the lowest of the unbent
    /// beam, whose `frequencies_hz` are given, where that is larger: of slow ones and of fast ones.
    fn least_damped(
        &self,
        tether: &Tether,
        at: &Stage,
        frequencies_hz: &[f64],
    ) -> ([f64; 2], Option<[f64; 2]>) {
        let coupled = CoupledSpar { tether, spar: self, still: Some(0.0), share: 1.0 };
        let own = |k: usize| std::f64::consts::TAU * frequencies_hz.get(k).copied().unwrap_or_default();
        let planform = tether.wing.planform();
        let chord = planform.area() / (2.0 * planform.covered_half_span());
        let fast = (2.0 * FAST * tether.wind.norm() / chord).max(own(JUDGED - 1));
        let share = |[growth, frequency]: &[f64; 2]| growth / frequency.max(own(0));
        let found = coupled.eigenvalues(at).into_iter().filter(|s| s[1] >= 0.0);
        let (slow, fast): (Vec<_>, Vec<_>) = found.partition(|s| s[1] <= fast);
        let least = |of: Vec<[f64; 2]>| of.into_iter().max_by(|a, b| share(a).total_cmp(&share(b)));
        (least(slow).unwrap_or([f64::NAN; 2]), least(fast))
    }

    /// Runs all cycles from the shape at rest.
    pub(super) fn run(&self, tether: &Tether, progress: &mut dyn FnMut(f64) -> ControlFlow<()>) -> TetherRun {
        let mut recorder = TetherRecorder::new(tether);
        let steps = tether.clock.steps();
        let coupled = CoupledSpar { tether, spar: self, still: None, share: 1.0 };
        let mut steady = self.steady(tether);
        steady.grid_change = self.grid_change(tether, &steady).filter(|_| steady.found);
        steady.frequency_change = self.frequency_change(&steady);
        let n = self.beam.coordinates();
        let mut x = vec![0.0; coupled.sizes().states];
        if steady.found {
            x[..n].copy_from_slice(&steady.q);
            x[2 * n..].copy_from_slice(&steady.x);
            // As of a rigid wing: the air has no jump of impulse where the motion begins.
            let bent = Bent { q: [steady.q.clone(), vec![0.0; n], vec![0.0; n]], root: Wrench::ZERO };
            let (body, angles) = (tether.motion.body(0.0).frame(), tether.motion.angles(0.0));
            let sections = self.sections_at(tether, tether.aero.arcs(), &body, &angles, &bent);
            tether.aero.settle(&&sections[..], tether.wind, &mut x[2 * n..]);
        } else {
            x[2 * n..].copy_from_slice(&tether.start());
        }
        let mut watch = Held(|step: usize, at: Moment<Memory>| {
            let (loads, bent) = coupled.observed(at)?;
            recorder.sample(tether, step, &loads, Some(&bent))?;
            let done = step as f64 / steps as f64;
            Ok(if step < steps { progress(done) } else { ControlFlow::Continue(()) })
        });
        let mut stepper = Stepper::new(&coupled, 0.0, &x);
        let ending = stepper.run(tether.clock.step(), steps, &mut watch);
        TetherRun { steady: Some(steady), ..recorder.finish(tether, ending) }
    }
}

impl CoupledSpar<'_> {
    /// Residuals of the beam and rates of the air; what holds the root.
    fn evaluate<S: Scalar>(
        &self,
        t: f64,
        [q, v, a]: [&[S]; 3],
        x: &[S],
        air: &SparAir<'_, S>,
        (out, dx, loads): (&mut [S], &mut [S], &mut Loads<S>),
    ) -> Wrench<S> {
        let Self { tether, spar, .. } = self;
        let motion = &tether.motion;
        let still = |j: &Jet<f64>| Jet::from(j.x);
        let (body, angles) = match self.still {
            Some(t) => (motion.body(t).frame().still(), motion.angles(t).iter().map(still).collect()),
            None => (motion.body(t).frame(), motion.angles(t)),
        };
        let setting = spar.setting(spar.root(tether, &body, &angles), self.share);
        let places = spar.beam.motion(&setting, q, v, a);
        let arcs = tether.aero.arcs();
        let of = |arc: &f64| spar.section_of(tether, *arc, &places, &body, &angles);
        let sections: Vec<SectionMotion<S>> = arcs.iter().map(of).collect();
        air(&sections, tether.wind.each(S::from), x, dx, loads);
        let mut borne = vec![Wrench::ZERO; places.len()];
        let planform = tether.wing.planform();
        for i in 0..loads.strips {
            let (edges, share) = tether.aero.strip_sections(i);
            let whole = loads.strip[i].total();
            let shares = [1.0 - share, share];
            // An edge within the root lies on its straight extension, since no hinge is between; one of the other half is an image.
            let place = |edge: usize| {
                let image = arcs[edge] < -spar.root_m;
                let arc = if image { -arcs[edge] } else { arcs[edge] } - spar.root_m;
                let Place { p, r } = &places[spar.beam.nearest(arc.max(0.0))];
                let p = if arc < 0.0 { *p + r.column(0).scaled(Jet::from(arc)) } else { *p };
                let Vec3([x, y, z]) = p.each(|j: Jet<S>| j.x);
                Vec3([x, if image { -y } else { y }, z])
            };
            let [at, other] = edges.map(place);
            // A strip moves as the mean of its edges: shares of its force and of its moment about their mean do its work.
            let middle = at.scaled(S::from(shares[0])) + other.scaled(S::from(shares[1]));
            let about = whole.moment - middle.cross(whole.force);
            for (edge, share) in edges.into_iter().zip(shares) {
                // The root bears what lies on an edge there of a strip outboard; a strip across it leaves its inner share to the
                // rigid part.
                let at_root = !planform.beyond(spar.root_m, arcs[edge])
                    && planform.beyond(tether.aero.strip_arcs()[i], spar.root_m);
                if at_root || planform.beyond(arcs[edge], spar.root_m) {
                    let node = spar.beam.nearest(arcs[edge] - spar.root_m);
                    let share = S::from(share * self.share);
                    borne[node] += Wrench { force: whole.force * share, moment: about * share };
                }
            }
        }
        spar.beam.balance(&setting, &places, [q, v], &borne, out)
    }

    fn in_numbers(
        &self,
        t: f64,
        at: &Stage,
        [out, dx]: [&mut [f64]; 2],
        loads: &mut Loads<f64>,
    ) -> Wrench<f64> {
        let air = |s: &[SectionMotion<f64>], w: Vec3, x: &[f64], dx: &mut [f64], l: &mut Loads<f64>| {
            self.tether.aero.evaluate_in_numbers(s, w, x, dx, l);
        };
        self.evaluate(t, [&at.q, &at.v, &at.a], &at.x, &air, (out, dx, loads))
    }

    /// Derivatives of the residuals and of the rates of the air, by the columns `wanted` of q, v, a and x in this order.
    fn derivatives(&self, t: f64, at: &Stage, wanted: std::ops::Range<usize>) -> DMatrix<f64> {
        let (n, m) = (at.q.len(), at.x.len());
        let mut all = DMatrix::zeros(n + m, wanted.len());
        let mut loads = Box::<Loads<Early>>::default();
        let (mut out, mut dx) = (vec![Early::ZERO; n], vec![Early::ZERO; m]);
        let air = |s: &[SectionMotion<Early>],
                   w: Vec3<Early>,
                   x: &[Early],
                   dx: &mut [Early],
                   l: &mut Loads<Early>| {
            self.tether.aero.evaluate_in_early(s, w, x, dx, l);
        };
        for first in wanted.clone().step_by(Early::LANES) {
            let seeded = |values: &[f64], offset: usize| -> Vec<Early> {
                let one = |(i, value): (usize, &f64)| {
                    let mut x = Early::constant(*value);
                    let lane = (offset + i).checked_sub(first);
                    if let Some(lane) = lane.filter(|lane| *lane < Early::LANES) {
                        x.eps[lane] = 1.0;
                    }
                    x
                };
                values.iter().enumerate().map(one).collect()
            };
            let [q, v, a, x] = [(&at.q, 0), (&at.v, n), (&at.a, 2 * n), (&at.x, 3 * n)]
                .map(|(of, offset)| seeded(of, offset));
            self.evaluate(t, [&q, &v, &a], &x, &air, (&mut out, &mut dx, &mut loads));
            for lane in 0..Early::LANES.min(wanted.end - first) {
                let column = first + lane - wanted.start;
                for (i, number) in out.iter().chain(&dx).enumerate() {
                    all[(i, column)] = number.eps[lane];
                }
            }
        }
        // The residual of the air is its rates less those that the model gives.
        all.rows_mut(n, m).neg_mut();
        all
    }

    /// Growth rates (1/s) and angular frequencies (rad/s) of small motions about a stage at rest.
    fn eigenvalues(&self, at: &Stage) -> Vec<[f64; 2]> {
        let n = at.q.len();
        let [by_q, by_v, by_a, by_x, by_w] = self.tangents(0.0, at);
        let join = |parts: &[&DMatrix<f64>]| {
            let columns: Vec<_> = parts.iter().flat_map(|part| part.column_iter()).collect();
            DMatrix::from_columns(&columns)
        };
        let Some(rates) = join(&[&by_a, &by_w]).lu().solve(&join(&[&by_q, &by_v, &by_x])) else {
            return Vec::new();
        };
        of_first_order(&rates, n).iter().map(|s| [s.re, s.im]).collect()
    }
}

impl Implicit for CoupledSpar<'_> {
    /// The ringing of a stiff spar, which no step resolves, dies away.
    fn rule(&self) -> Rule {
        Rule::Radau
    }
    /// Where the air bears nothing, its states are the rounding of differences of washes.
    fn least(&self) -> [f64; 2] {
        [NO_STRAIN, NO_WASH * self.tether.reference.speed_m_s]
    }
    fn residual(&self, t: f64, at: &Stage, out: &mut [f64]) {
        let (own, air) = out.split_at_mut(at.q.len());
        self.in_numbers(t, at, [own, air], &mut Loads::default());
        air.iter_mut().zip(&at.w).for_each(|(x, w)| *x = w - *x);
    }

    fn tangents(&self, t: f64, at: &Stage) -> [DMatrix<f64>; 5] {
        let (n, m) = (at.q.len(), at.x.len());
        let all = self.derivatives(t, at, 0..3 * n + m);
        let part = |from: usize, count: usize| all.columns(from, count).into_owned();
        let mut by_w = DMatrix::zeros(n + m, m);
        by_w.view_mut((n, 0), (m, m)).fill_with_identity();
        [part(0, n), part(n, n), part(2 * n, n), part(3 * n, m), by_w]
    }
}

/// Its states are the beam's coordinates, their rates, and those of the air; an implicit step moves them after each step of the clock.
impl System for CoupledSpar<'_> {
    type Memory = Memory;

    fn sizes(&self) -> Sizes {
        Sizes { states: 2 * self.spar.beam.coordinates() + self.tether.aero.states(), inputs: 0 }
    }
    fn slope(&self, _: Moment<Memory>, dx: &mut [f64]) -> Result<(), Fault> {
        dx.fill(0.0);
        Ok(())
    }
    fn advance(&self, t: f64, dt: f64, x: &mut [f64], _: &[f64], memory: &mut Memory) -> Result<(), Fault> {
        let mut at = self.stage(x, memory);
        if !step(self, t - dt, dt, &mut at, &mut memory.factors).converged {
            return Err(Fault::Structure { time: t });
        }
        let n = at.q.len();
        x[..n].copy_from_slice(&at.q);
        x[n..2 * n].copy_from_slice(&at.v);
        x[2 * n..].copy_from_slice(&at.x);
        (memory.a, memory.w) = (at.a, at.w);
        Ok(())
    }
}

impl CoupledSpar<'_> {
    fn stage(&self, x: &[f64], memory: &Memory) -> Stage {
        let n = self.spar.beam.coordinates();
        let or_zero = |of: &[f64], n: usize| if of.is_empty() { vec![0.0; n] } else { of.to_vec() };
        let air = &x[2 * n..];
        Stage {
            q: x[..n].to_vec(),
            v: x[n..2 * n].to_vec(),
            a: or_zero(&memory.a, n),
            x: air.to_vec(),
            w: or_zero(&memory.w, air.len()),
        }
    }
}

impl Observed for CoupledSpar<'_> {
    type Observation = (Loads<f64>, Bent);

    /// The accelerations are those that the state asks for: the residual is linear in them.
    fn observed(&self, at: Moment<Memory>) -> Result<Self::Observation, Fault> {
        let mut stage = self.stage(at.x, at.memory);
        let (n, m) = (stage.q.len(), stage.x.len());
        let (mut out, mut dx) = (vec![0.0; n], vec![0.0; m]);
        let mut loads = Loads::boxed();
        self.in_numbers(at.t, &stage, [&mut out, &mut dx], &mut loads);
        let by_a = self.derivatives(at.t, &stage, 2 * n..3 * n).rows(0, n).into_owned();
        let change = by_a.lu().solve(&DVector::from_column_slice(&out));
        let Some(change) = change else { return Err(Fault::MassMatrix { time: at.t }) };
        stage.a.iter_mut().zip(change.iter()).for_each(|(a, c)| *a -= c);
        let root = self.in_numbers(at.t, &stage, [&mut out, &mut dx], &mut loads);
        match dx.iter().chain(&stage.a).position(|rate| !rate.is_finite()) {
            Some(state) => Err(Fault::NotFinite { state, time: at.t }),
            None => Ok((*loads, Bent { q: [stage.q, stage.v, stage.a], root })),
        }
    }
}
