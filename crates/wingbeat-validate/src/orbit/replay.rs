//! The motion of a shipped orbit, prescribed cycle after cycle: to strips under any law, and to the vortex lattice.

use std::sync::Arc;

use wingbeat::aero::{Planform, SectionMotion};
use wingbeat::body::Harmonic;
use wingbeat::math::interpolation::piecewise_linear;
use wingbeat::math::{GRAVITY, Jet, Quat, RK4, Vec3, Workspace, Wrench};
use wingbeat::plant::{Fault, Plant};
use wingbeat::robot::{BodyMotion, DrivenSpec, Robot};
use wingbeat::scenario::{ConfigError, Document, Scenario, ScenarioSpec};
use wingbeat::simulate::{Column, Record};
use wingbeat_lattice::{
    FlightStretch, Lattice, LatticeLoads, LatticeSettings, LatticeSurface, MovingSections, PanelLayout,
    Panels, Scene, Spacing,
};

use super::found;
use crate::Error;
use crate::shipped::{Shipped, scenario};

/// Steps of the orbit, s; those of the strips are twice as long, so that their stages fall on them.
const STEP: &str = "trim.step_s=2.5e-4";
/// Harmonics in which the air moves a twist.
const HARMONICS: usize = 24;
/// Cycles under strips, whose slowest lags last some.
const STRIP_CYCLES: usize = 20;
/// Cycles in the lattice.
const LATTICE_CYCLES: usize = 3;
/// How far from a hinge a chord line belongs to one of its links, m.
const BESIDE: f64 = 1e-6;
/// Parts of a web between the chord lines that may pass through the panel before it. Choice.
const WEB_PARTS: usize = 8;

/// How fine a lattice is.
#[derive(Clone, Copy, Debug)]
pub struct LatticeFineness {
    /// Panels along the chord; the way of the trailing edges in a step, rms, is one of them.
    pub chordwise: usize,
    /// Strips of preset `full`, whose wing the lattice has: straight between the chord lines at their edges, but with the outline that strips
    /// carry. So it has the surface that closes a hinge which twists, and that is as wide as one of these strips.
    pub strips: usize,
    /// Strips of the lattice in each of them.
    pub parts: usize,
    /// Core of the wake, mean chords of a panel. The vortex nearest to a trailing edge lies half of that behind the last control points, so that
    /// a core of 0.32 takes 0.3 of what it does there, and lift that swings is 0.15 too large with 8 panels; this goes with the root of
    /// their size.
    pub core: f64,
}

/// A cycle of an orbit at even times.
pub struct OrbitMotion {
    name: &'static str,
    scenario: Scenario,
    robot: Robot,
    inputs: Vec<f64>,
    duration: f64,
    displacement: Vec3,
    /// States, and their rates.
    x: Vec<Vec<f64>>,
    dx: Vec<Vec<f64>>,
}

/// A cycle of the lattice for endless panels, at the instants of `fine`, from it and from `coarse`, whose panels along the chord are `share`
/// (dimensionless) times those of `fine`, at first order.
pub fn extrapolated(coarse: &[InstantLoads], fine: &[InstantLoads], share: f64) -> Vec<InstantLoads> {
    let phases: Vec<f64> = (0..=coarse.len()).map(|k| k as f64 / coarse.len() as f64).collect();
    // The cycle closes.
    let closed = || coarse.iter().chain(&coarse[..1]).copied();
    let columns = LOADS.map(|load| closed().map(|mut instant| *load(&mut instant)).collect::<Vec<f64>>());
    let of = |(k, instant): (usize, &InstantLoads)| {
        let mut instant = *instant;
        for (load, column) in LOADS.iter().zip(&columns) {
            let value = load(&mut instant);
            let before = piecewise_linear(&phases, column, k as f64 / fine.len() as f64);
            *value += (*value - before) * share / (1.0 - share);
        }
        instant
    };
    fine.iter().enumerate().map(of).collect()
}

/// All that wings bear.
const LOADS: [fn(&mut InstantLoads) -> &mut f64; 4] =
    [|i| &mut i.up, |i| &mut i.forward, |i| &mut i.body_up, |i| &mut i.power];

/// What wings bear at an instant, and what the joints give to the air for it.
#[derive(Clone, Copy, Debug, Default)]
pub struct InstantLoads {
    /// Upward force over the weight.
    pub up: f64,
    /// Forward force over the weight.
    pub forward: f64,
    /// Upward force of the body's drag over the weight, where it is known.
    pub body_up: f64,
    /// Power of the joints against the air, W/kg.
    pub power: f64,
}

/// Means over a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct CycleMeans {
    /// Upward force over the weight.
    pub up: f64,
    /// Forward force over the weight.
    pub forward: f64,
    /// Upward force of the body's drag over the weight.
    pub body_up: f64,
    /// Mean of the positive part of the power over the mass, W/kg.
    pub power: f64,
}

impl CycleMeans {
    /// Those of a cycle.
    pub fn of(cycle: &[InstantLoads]) -> Self {
        let mean = |of: &dyn Fn(&InstantLoads) -> f64| cycle.iter().map(of).sum::<f64>() / cycle.len() as f64;
        Self {
            up: mean(&|i| i.up),
            forward: mean(&|i| i.forward),
            body_up: mean(&|i| i.body_up),
            power: mean(&|i| i.power.max(0.0)),
        }
    }
}

fn refused(error: ConfigError) -> Error {
    Error::reference("orbit", error.to_string())
}

impl OrbitMotion {
    /// That of a shipped scenario.
    pub fn of(shipped: Shipped) -> Result<Self, Error> {
        let scenario = scenario(shipped, &[STEP])?;
        let cycle = scenario.cycle()?;
        let orbit = found(&scenario, &cycle)?;
        let robot = cycle.robot().paced(orbit.point.pace);
        let (inputs, duration) = (orbit.point.inputs.clone(), orbit.end.duration);
        let mut x = vec![cycle.start(&orbit.point)];
        cycle.fly(&orbit.point.z, orbit.point.pace, &inputs, |_, _, state| {
            x.push(state.to_vec());
            Ok(())
        })?;
        x.pop();
        let step = duration / x.len() as f64;
        let rates = |(k, x): (usize, &Vec<f64>)| {
            let mut dx = vec![0.0; x.len()];
            robot.rates_in_numbers(k as f64 * step, x, &inputs, &mut dx).map(|()| dx)
        };
        let dx = x.iter().enumerate().map(rates).collect::<Result<_, Fault>>()?;
        Ok(Self {
            robot,
            inputs,
            duration,
            displacement: orbit.end.displacement,
            x,
            dx,
            scenario,
            name: shipped,
        })
    }

    /// The body's motion as it is, the strokes of driven joints times the share `share`.
    pub fn gentler(self, share: f64) -> Result<Self, Error> {
        let mut spec = self.scenario.spec.clone();
        let series = spec.robot.links.iter_mut().filter_map(|link| link.driven.as_mut());
        for harmonic in series.flat_map(|series| &mut series.harmonics) {
            harmonic.amplitude_rad *= share;
        }
        let (scenario, robot) = self.built(&spec)?;
        Ok(Self { scenario, robot, ..self })
    }

    /// The scenario of `spec`, and its robot at the orbit's frequency.
    fn built(&self, spec: &ScenarioSpec) -> Result<(Scenario, Robot), Error> {
        let scenario = Document::of_scenario("replayed", spec).and_then(Scenario::new).map_err(refused)?;
        let pace = self.robot.frequency_hz() / self.scenario.model().frequency_hz();
        let robot = scenario.model().paced(pace);
        Ok((scenario, robot))
    }

    /// Name of the scenario.
    pub fn name(&self) -> &'static str {
        self.name
    }

    fn step(&self) -> f64 {
        self.duration / self.x.len() as f64
    }

    /// The weight, N.
    fn weight(&self) -> f64 {
        self.robot.mass() * GRAVITY
    }

    /// How the body moves at sample `k`.
    fn body(&self, k: usize) -> BodyMotion {
        let (l, k) = (self.robot.layout(), k % self.x.len());
        let (x, dx) = (&self.x[k], &self.dx[k]);
        BodyMotion {
            attitude: Quat::from_wxyz(&x[l.attitude..]).matrix(),
            velocity: Vec3::from_slice(&x[l.velocity..]),
            rate: Vec3::from_slice(&x[l.rate..]),
            acceleration: Vec3::from_slice(&dx[l.velocity..]),
            angular_acceleration: Vec3::from_slice(&dx[l.rate..]),
        }
    }

    /// The instant at which the wings bear `wrench` (in B about the body's origin) and take `taken` W from the air, the body at `k`.
    fn instant(&self, body: &BodyMotion, wrench: &Wrench<f64>, taken: f64) -> InstantLoads {
        let force = body.attitude * wrench.force;
        let rigid = force.dot(body.velocity) + wrench.moment.dot(body.rate);
        InstantLoads {
            up: force[2] / self.weight(),
            forward: force[0] / self.weight(),
            body_up: 0.0,
            power: (rigid - taken) / self.robot.mass(),
        }
    }

    /// The robot whose elastic joints are driven as the air moves them, changed by `change`, at the orbit's frequency.
    pub fn driven(&self, change: impl Fn(&mut ScenarioSpec)) -> Result<Robot, Error> {
        let joints = self.robot.joint_names().count();
        let robot = self.driven_beside(&change, &vec![0.0; joints])?;
        // Elements that move the rest of a spring move the joint itself now.
        let loads = robot.carried_in_numbers(
            &Jet::new(0.0, 1.0, 0.0),
            &self.body(0),
            &self.carried_start(&robot),
            &self.inputs,
            &mut vec![0.0; robot.carried_states()],
        )?;
        let seen = self.robot.observe(0.0, &self.x[0], &self.inputs)?.joints;
        let beside: Vec<f64> = loads.joints.iter().zip(&seen).map(|(driven, seen)| driven.x - seen).collect();
        self.driven_beside(&change, &beside)
    }

    /// Its states at the begin: elements rest under the commands held.
    fn carried_start(&self, robot: &Robot) -> Vec<f64> {
        let l = self.robot.layout();
        let mut x = vec![0.0; robot.carried_states()];
        x[..l.joints - l.structure].copy_from_slice(&self.x[0][l.structure..l.joints]);
        x
    }

    fn driven_beside(&self, change: &impl Fn(&mut ScenarioSpec), beside: &[f64]) -> Result<Robot, Error> {
        let joints: Vec<&str> = self.robot.joint_names().collect();
        let mut spec = self.scenario.spec.clone();
        spec.start.states.clear();
        change(&mut spec);
        for link in &mut spec.robot.links {
            let sides = [link.name.clone(), format!("{}_left", link.name)];
            let Some(joint) = joints.iter().position(|joint| sides.iter().any(|side| side == joint)) else {
                continue;
            };
            if link.elastic.take().is_some() {
                let series = self.series(joint)?;
                link.driven = Some(DrivenSpec { mean_rad: series.mean_rad - beside[joint], ..series });
            }
        }
        Ok(self.built(&spec)?.1)
    }

    /// The angle of a joint as a series.
    fn series(&self, joint: usize) -> Result<DrivenSpec, Error> {
        let angle = |(k, x): (usize, &Vec<f64>)| {
            Ok(self.robot.observe(k as f64 * self.step(), x, &self.inputs)?.joints[joint])
        };
        let angles = self.x.iter().enumerate().map(angle).collect::<Result<Vec<f64>, Fault>>()?;
        let n = angles.len() as f64;
        let part = |harmonic: usize, wave: fn(f64) -> f64| -> f64 {
            let phase = |k: usize| self.robot.phase(k as f64 * self.step());
            let terms = angles.iter().enumerate().map(|(k, a)| a * wave(harmonic as f64 * phase(k)));
            terms.sum::<f64>() * 2.0 / n
        };
        let harmonic = |h: usize| {
            let (c, s) = (part(h, f64::cos), part(h, f64::sin));
            Harmonic { amplitude_rad: c.hypot(s), phase_rad: s.atan2(c) }
        };
        Ok(DrivenSpec {
            mean_rad: 0.5 * part(0, f64::cos),
            harmonics: (1..=HARMONICS).map(harmonic).collect(),
            ..DrivenSpec::default()
        })
    }

    /// The last cycle under the strips of `robot`.
    pub fn strips(&self, robot: &Robot) -> Result<Vec<InstantLoads>, Error> {
        let mut x = self.carried_start(robot);
        let at = |t: f64| {
            let k = (t / self.step()).round() as usize;
            (Jet::new(k as f64 * self.step(), 1.0, 0.0), self.body(k))
        };
        robot.settle_carried(&at(0.0).0, &self.body(0), &mut x, &self.inputs)?;
        let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| -> Result<(), Fault> {
            let (clock, body) = at(t);
            robot.carried_in_numbers(&clock, &body, x, &self.inputs, dx).map(drop)
        };
        let mut work = Workspace::new(x.len(), RK4.b.len());
        let (steps, step) = (self.x.len() / 2, 2.0 * self.step());
        let mut seen = Vec::with_capacity(steps);
        for k in 0..STRIP_CYCLES * steps {
            let (clock, body) = at(k as f64 * step);
            if k + steps >= STRIP_CYCLES * steps {
                let mut dx = vec![0.0; x.len()];
                let loads = robot.carried_in_numbers(&clock, &body, &x, &self.inputs, &mut dx)?;
                let drag = body.attitude * loads.body_drag.force;
                let instant =
                    self.instant(&body, &loads.air.total(), loads.air_power - drag.dot(body.velocity));
                seen.push(InstantLoads { body_up: drag[2] / self.weight(), ..instant });
            }
            RK4.step(&mut rates, k as f64 * step, step, &mut x, &mut work)?;
        }
        Ok(seen)
    }

    /// The cycles as a record.
    fn record(&self) -> Result<Record, Error> {
        let (states, inputs) = (self.robot.states(), self.robot.inputs());
        let names = states.iter().chain(inputs).map(|channel| channel.name.clone());
        let columns = std::iter::once("t".into()).chain(names).map(|name: String| Column::new(name, "", ""));
        let n = self.x.len();
        let mut record = Record::new(columns.collect(), LATTICE_CYCLES * n + 1)?;
        let position = self.robot.layout().position;
        for k in 0..=LATTICE_CYCLES * n {
            let mut x = self.x[k % n].clone();
            for i in 0..3 {
                x[position + i] += (k / n) as f64 * self.displacement[i];
            }
            record.append(&[&[k as f64 * self.step()], &x[..], &self.inputs].concat());
        }
        Ok(record)
    }

    /// The edges of so many strips of preset `full` on the wing, m, from left to right.
    fn strip_edges(&self, strips: usize) -> Result<Vec<f64>, Error> {
        let mut spec = self.scenario.spec.clone();
        spec.start.states.clear();
        spec.aero.full.strips = strips;
        let robot = self.built(&spec)?.1;
        Ok(robot.surfaces().next().map_or_else(Vec::new, |(_, aero)| aero.arcs().to_vec()))
    }

    /// The last two cycles in the lattice, which has the left half of the wings and its mirror image.
    pub fn lattice(&self, fineness: LatticeFineness) -> Result<[Vec<InstantLoads>; 2], Error> {
        let LatticeFineness { chordwise, strips, parts, core } = fineness;
        let outlines = self.scenario.spec.robot.outlines()?;
        let planform = &outlines[0].planform;
        let chord = planform.mean_chord();
        let flight = Arc::new(self.flight()?);
        let panels = Panels { chordwise, spanwise: strips * parts, spacing: Spacing::Lan };
        let density = self.scenario.spec.air.density_kg_m3;
        let (mut scene, _) = Scene::flown(&flight, &outlines, 0.0, density, panels)?;
        let [LatticeSurface { layout, sections }] = &mut scene.surfaces[..] else {
            return Err(Error::reference("orbit", format!("{} pieces of wing", scene.surfaces.len())));
        };
        let edges = self.strip_edges(strips)?;
        let mut bends = Vec::new();
        sections.bends(0.0, &edges, &mut bends);
        if !bends.is_empty() {
            return Err(Error::reference("orbit", "a wing that bends".to_owned()));
        }
        *layout = left_half(chordwise, &edges, parts);
        *sections =
            Arc::new(StraightBetween { sections: sections.clone(), edges, planform: planform.clone() });
        scene.symmetric = true;
        let way = scene.edge_speed(self.duration) * self.duration;
        let steps = (way * chordwise as f64 / chord).round() as usize;
        let core = core * chord / chordwise as f64;
        let mut lattice = Lattice::new(scene, LatticeSettings::new(self.duration / steps as f64, core))?;
        let mut cycles: [Vec<InstantLoads>; 2] = Default::default();
        for _ in 0..LATTICE_CYCLES {
            cycles.rotate_left(1);
            cycles[1].clear();
            for _ in 0..steps {
                let loads = lattice.step()?;
                cycles[1].push(self.borne(&flight, &loads));
            }
        }
        Ok(cycles)
    }

    /// Leading and trailing edge of a surface at sample `k`.
    fn line(&self, surface: usize, k: usize, arc: f64) -> Result<[Vec3; 2], Fault> {
        let at = self.robot.stance(k as f64 * self.step(), &self.x[k]);
        let mut found = Vec::new();
        self.robot.chord_lines(&at, surface, &[arc], &mut found)?;
        Ok([found[0].le, found[0].te])
    }

    /// Share of the cycle in which a chord line beyond a hinge of the first surface, the first one or one within its web, passes through the
    /// panel before the hinge, which folds and twists there.
    pub fn passes_through_itself(&self) -> Result<f64, Error> {
        let outlines = self.scenario.spec.robot.outlines()?;
        let hinges = outlines[0].hinges.iter().zip(&outlines[0].webs).filter(|(arc, _)| **arc > 0.0);
        let webs: Vec<f64> = hinges.clone().map(|(_, web)| *web).collect();
        let ends: Vec<f64> = std::iter::once(0.0).chain(hinges.map(|(arc, _)| *arc)).collect();
        let mut passes = 0;
        for k in 0..self.x.len() {
            let mut through = false;
            for (pair, web) in ends.windows(2).zip(&webs) {
                let ([a, b], [c, d]) =
                    (self.line(0, k, pair[0] + BESIDE)?, self.line(0, k, pair[1] - BESIDE)?);
                for part in 0..=WEB_PARTS {
                    let beyond = self.line(0, k, pair[1] + BESIDE + web * part as f64 / WEB_PARTS as f64)?;
                    through |= pierces(beyond, [a, b, c]) || pierces(beyond, [b, c, d]);
                }
            }
            passes += usize::from(through);
        }
        Ok(passes as f64 / self.x.len() as f64)
    }

    /// The cycles as a flight.
    fn flight(&self) -> Result<FlightStretch, Error> {
        Ok(FlightStretch::new(&self.robot, &self.record()?, 0.0, LATTICE_CYCLES as f64 * self.duration)?)
    }

    /// What the wings bear under `loads`.
    fn borne(&self, flight: &FlightStretch, loads: &LatticeLoads) -> InstantLoads {
        let at = self.robot.stance(loads.time, &flight.state(loads.time));
        let body = BodyMotion { rate: at.rate, ..BodyMotion::steady(at.attitude, at.velocity) };
        let Wrench { force, moment } = loads.joukowski;
        let in_body = Wrench {
            force: at.attitude.transpose_mul(force),
            moment: at.attitude.transpose_mul(moment - at.origin.cross(force)),
        };
        self.instant(&body, &in_body, loads.power)
    }
}

/// Whether the way from `a` to `b` (m) passes through the triangle.
pub fn pierces([a, b]: [Vec3; 2], [p, q, r]: [Vec3; 3]) -> bool {
    // Signed volumes: both ends on other sides of the plane, the way on one side of all edges.
    let volume = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| (b - a).cross(c - a).dot(d - a);
    let apart = volume(p, q, r, a) * volume(p, q, r, b) < 0.0;
    let around = [volume(a, b, p, q), volume(a, b, q, r), volume(a, b, r, p)];
    apart && (around.iter().all(|v| *v > 0.0) || around.iter().all(|v| *v < 0.0))
}

/// Panels of the left half of a wing: each stretch between `edges` (m, from left to right) divided evenly in `parts`.
pub fn left_half(chordwise: usize, edges: &[f64], parts: usize) -> PanelLayout {
    let mut arcs = Vec::new();
    for pair in edges.windows(2).filter(|pair| pair[0] > BESIDE) {
        // A strip across the middle is halved.
        let end = if pair[1] > BESIDE { pair[1] } else { 0.0 };
        arcs.extend((0..parts).map(|k| pair[0] + (end - pair[0]) * k as f64 / parts as f64));
    }
    let fractions = vec![0.5; arcs.len()];
    arcs.push(0.0);
    PanelLayout { chordwise, arcs, fractions }
}

/// The wing as strips have it: straight between the chord lines at their edges.
struct StraightBetween {
    sections: Arc<dyn MovingSections>,
    /// From left to right, m.
    edges: Vec<f64>,
    planform: Planform,
}

impl StraightBetween {
    /// How far the outline reaches at `arc` (m) beyond the straight lines between two edges (m), ahead and behind, over the chord between
    /// these lines; `arc` lies the share `share` of the way from the first edge to the second.
    fn beyond(&self, edges: [f64; 2], arc: f64, share: f64) -> [f64; 2] {
        let [ahead, ahead_of_trailing] = self.planform.ahead_of_lines(edges, arc);
        let [from, to] = edges.map(|edge| self.planform.chord(edge));
        [ahead, -ahead_of_trailing].map(|beyond| beyond / (from + (to - from) * share))
    }
}

impl MovingSections for StraightBetween {
    fn sections(&self, t: f64, arcs: &[f64], out: &mut Vec<SectionMotion<f64>>) {
        let mut found = Vec::new();
        self.sections.sections(t, &self.edges, &mut found);
        out.clear();
        out.extend(arcs.iter().map(|arc| {
            let right = self.edges.partition_point(|edge| edge >= arc).clamp(1, self.edges.len() - 1);
            let (a, b) = (&found[right - 1], &found[right]);
            let (from, to) = (self.edges[right - 1], self.edges[right]);
            let share = (from - arc) / (from - to);
            let mix = |a: Vec3, b: Vec3| a + (b - a) * share;
            let [ahead, behind] = self.beyond([from, to], *arc, share);
            let [le, te] = [mix(a.le, b.le), mix(a.te, b.te)];
            let [v_le, v_te] = [mix(a.v_le, b.v_le), mix(a.v_te, b.v_te)];
            let (chord, rate) = (te - le, v_te - v_le);
            SectionMotion {
                le: le - chord * ahead,
                te: te + chord * behind,
                v_le: v_le - rate * ahead,
                v_te: v_te + rate * behind,
                ..SectionMotion::default()
            }
        }));
    }
}
