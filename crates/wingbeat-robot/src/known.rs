//! Derivatives of the rates that the mass matrix knows: by inputs, which enter by the accelerations of structure elements alone, and
//! by the accelerations of gravity and air.

use super::Robot;
use super::dynamics::{BodySystem, Evaluation, InstantInertia, add};
use super::joints::Displaced;
use super::sections::Carriers;
use super::{Joints, MAX_ELEMENTS};
use crate::body::MAX_LINKS;
use arrayvec::ArrayVec;
use wingbeat_aero::{ByStates, Coupling, ImpulseRates, MAX_STRIPS};
use wingbeat_math::linear::solve_symmetric_rows;
use wingbeat_math::{Dual, GRAVITY, Jet, Mat3, Quat, Scalar, Vec3, Wrench, append_copies, kept};
use wingbeat_ocp::plant::{Fault, Known, Late, MAX_COORDINATES, MAX_DEGREES};

/// Derivatives carried by the solve: by the accelerations of gravity and air, then by those of the elements.
const FIELDS: usize = 6;
/// The accelerations of gravity along the axes of B, or of the air, as columns of the mass matrix.
type Field = [[f64; 3]; MAX_DEGREES];

impl Robot {
    /// See [`Plant::known`](wingbeat_ocp::plant::Plant::known). Elements are taken for coordinates beyond those that the dynamics decide, of
    /// which the accelerations are known: with the mass matrix M and its parts M_s of links and M_a of the air,
    /// M da = M_s dg + M_a dg_air - M_y dy'', the fields g uniform accelerations in B.
    ///
    /// Equation: robot.known_columns
    /// `M da = M_s dg + M_a dg_air - M_y dy'', followed impulses P' + B a free of it but for B dg_air - B_y dy''`
    /// Source: virtual work; a uniform field is an acceleration of the frame.
    /// Test: `what_has_no_derivative_is_left_out_and_nothing_else`.
    pub(super) fn known_columns(
        &self,
        t: f64,
        x: &[f64],
        u: &[f64],
        dx: &mut [f64],
        known: &mut Known,
    ) -> Result<bool, Fault> {
        let (own, elements) = (self.degrees(), self.elements.len());
        let fit = own + elements <= MAX_COORDINATES && FIELDS + elements <= Late::LANES;
        // Elements with an inertia have accelerations that the dynamics decide.
        if !fit || !self.loaded.is_empty() || self.response.commands() != u.len() {
            return Ok(false);
        }
        kept(Box::<ByStates>::default, |by_states| self.known_in(by_states, t, x, u, dx, known))
    }

    fn known_in(
        &self,
        by_states: &mut ByStates,
        t: f64,
        x: &[f64],
        u: &[f64],
        dx: &mut [f64],
        known: &mut Known,
    ) -> Result<bool, Fault> {
        let (l, own) = (&self.layout, self.degrees());
        let ((early, air), clock) = (x.split_at(l.aero), Jet::new(t, 1.0, 0.0));
        let structure = &early[l.structure..];
        let (mut out, mut mass) = (Evaluation::empty(), [[0.0; 6]; 6]);
        let inertia = InstantInertia::Summed(&mut mass);
        let (mut net, setting) = self.instant((t, &clock), early, u, (&[], inertia), dx, &mut out)?;
        if !self.add_elements(&clock, structure, &mut out)? {
            return Ok(false);
        }
        let Evaluation { links, base, coordinates, carriers, .. } = &mut out;
        let mut carriers = Carriers::within(carriers, coordinates);
        carriers.follow(base, &self.carriers, links, [setting.wind_dot, setting.gravity]);
        carriers.ground = self.ground_below(setting.attitude, early[l.position + 2]);
        let mut system = BodySystem::<f64, f64>::new(coordinates.count());
        let BodySystem { mass: matrix, forces, .. } = &mut system;
        self.mechanism.tree.coordinate_inertia(links, setting.gravity, coordinates, Some(matrix), forces);
        self.add_efforts(structure, 1.0, &mut system.forces);
        self.add_inertances(&mut system.mass);
        add(&mut system.mass, &mass);
        let mut of_links: Field = [[0.0; 3]; MAX_DEGREES];
        of_links.iter_mut().zip(&system.mass).for_each(|(of, row)| of.copy_from_slice(&row[..3]));
        let mut impulses = ImpulseRates::none();
        let lacking = self.covering.aero.follow_impulses().then_some(&mut impulses);
        let (wind, rates) = (setting.wind, &mut dx[l.aero..]);
        let late = known.wants_late && self.covering.aero.know_by_states();
        net += if late {
            self.weigh_strips(&carriers, own, &mut by_states.weights);
            let mut strips = [Wrench::ZERO; MAX_STRIPS];
            let coupling = Coupling { mass: Some(&mut system.mass), strips: &mut strips, impulses: lacking };
            let riding = self.covering.riding(&carriers);
            let Some((load, added)) =
                self.covering.aero.by_states(&riding, wind, air, rates, coupling, by_states)
            else {
                return Ok(false);
            };
            add(&mut system.mass, &added);
            let of_strips = by_states.weights.chunks_exact(self.covering.strips());
            for (force, weights) in system.of_air.iter_mut().zip(of_strips) {
                *force +=
                    weights.iter().zip(&strips).map(|(weights, load)| weighed(weights, load)).sum::<f64>();
            }
            load
        } else {
            system.add_air::<f64, f64>(self, &carriers, (wind, lacking), air, rates)
        };
        let singular = Fault::MassMatrix { time: t };
        let accelerations = system.responses(&net, &of_links, [own, self.elements.len()]).ok_or(singular)?;
        known.clear(x.len(), u.len());
        self.put_degrees((&accelerations, &system.mass), &impulses, known);
        self.put_columns(&accelerations, (&setting.attitude, &impulses), early, dx, known);
        if late {
            system.accelerate(by_states).ok_or(singular)?;
            self.put_late(by_states, (&setting.attitude, &impulses), x.len(), known);
        }
        let (wind, wind_dot) = self.wind.at(t);
        (known.wind, known.accelerations) = (wind, [Vec3::new(0.0, 0.0, -GRAVITY), wind_dot]);
        [known.position, known.velocity, known.rate] =
            [l.position, l.velocity, l.rate].map(|state| known.row(state));
        Ok(true)
    }

    /// What the loads of the strips weigh in the forces on `count` coordinates, as [`ByStates::weights`] has them.
    fn weigh_strips(&self, carriers: &Carriers<f64>, count: usize, weights: &mut Vec<[f64; 6]>) {
        let strips = self.covering.strips();
        weights.clear();
        weights.resize(count * strips, [0.0; 6]);
        if count == 0 {
            return;
        }
        let riding = self.covering.riding(carriers);
        for (i, k) in (0..strips).flat_map(|i| (0..6).map(move |k| (i, k))) {
            let mut unit = [0.0; 6];
            unit[k] = 1.0;
            let load = Wrench { force: Vec3::from_slice(&unit), moment: Vec3::from_slice(&unit[3..]) };
            let mut forces = [0.0; MAX_COORDINATES];
            self.covering.share_strip(i, &riding, &load, |link, load| {
                if let Some(link) = link {
                    carriers.project(link, &load, &mut forces);
                }
            });
            for c in 0..count {
                weights[c * strips + i][k] = forces[c];
            }
        }
    }

    /// Notes the accelerations found and the mass matrix on them, and what falls with them.
    fn put_degrees(
        &self,
        (accelerations, mass): (&[Late], &[[f64; MAX_DEGREES]]),
        impulses: &ImpulseRates<f64>,
        known: &mut Known,
    ) {
        let count = 6 + self.degrees();
        known.degrees.clear();
        known.mass.clear();
        known.falling.clear();
        known.degrees.extend(accelerations[..count].iter().map(|acceleration| acceleration.re));
        mass[..count].iter().for_each(|row| known.mass.extend(&row[..count]));
        known.falling.extend(impulses.rows().map(|(state, by)| (self.layout.aero + state, *by)));
    }

    /// Completes the rates, and writes their derivatives by inputs and by uniform accelerations, from the accelerations of the body and
    /// the second rates of the coordinates.
    fn put_columns(
        &self,
        accelerations: &[Late],
        (attitude, impulses): (&Mat3, &ImpulseRates<f64>),
        early: &[f64],
        dx: &mut [f64],
        known: &mut Known,
    ) {
        let (l, own, elements) = (&self.layout, self.degrees(), self.elements.len());
        let inputs = self.response.commands();
        let mut gains = ArrayVec::<(usize, usize, f64), { MAX_ELEMENTS * MAX_ELEMENTS }>::new();
        for (i, k) in (0..elements).flat_map(|i| (0..inputs).map(move |k| (i, k))) {
            let gain = self.response.command_gain(i, k);
            if gain != 0.0 {
                gains.push((i, k, gain));
            }
        }
        let mut put = |dx: &mut [f64], state: usize, rate: Late| {
            dx[state] = rate.re;
            let row = known.row(state);
            known.fields[row * FIELDS..][..FIELDS].copy_from_slice(&rate.eps[..FIELDS]);
            let columns = &mut known.inputs[row * inputs..][..inputs];
            for (i, k, gain) in &gains {
                columns[*k] += rate.eps[FIELDS + i] * gain;
            }
        };
        let velocity = attitude.times(Vec3::from_slice(accelerations));
        (0..3).for_each(|i| put(dx, l.velocity + i, velocity[i]));
        (0..3).for_each(|i| put(dx, l.rate + i, accelerations[3 + i]));
        for i in 0..own {
            dx[l.joints + i] = early[l.joints + own + i];
            put(dx, l.joints + own + i, accelerations[6 + i]);
        }
        for i in 0..elements {
            let mut rate = Late::constant(dx[l.structure + elements + i]);
            rate.eps[FIELDS + i] = 1.0;
            put(dx, l.structure + elements + i, rate);
        }
        for (state, by) in impulses.rows() {
            let mut rate = Late::constant(dx[l.aero + state]);
            rate.eps[3..6].copy_from_slice(&by[..3]);
            for i in 0..elements {
                rate.eps[FIELDS + i] = -by[6 + own + i];
            }
            let lacking = accelerations.iter().zip(by).take(6 + own);
            put(
                dx,
                l.aero + state,
                lacking.fold(rate, |rate, (acceleration, by)| rate - *acceleration * *by),
            );
        }
    }

    /// Writes the derivatives by the states of the air, of which `by_states` holds those of the accelerations in place of the loads.
    fn put_late(
        &self,
        by_states: &ByStates,
        (attitude, impulses): (&Mat3, &ImpulseRates<f64>),
        states: usize,
        known: &mut Known,
    ) {
        let (l, n, own) = (&self.layout, by_states.states, self.degrees());
        // Row by row: each is written once.
        for state in 0..states {
            if known.left_out.iter().any(|run| run.contains(&state)) {
                continue;
            }
            match state.checked_sub(l.aero).and_then(|of| by_states.rates.get(of * n..(of + 1) * n)) {
                Some(rates) => known.late.extend_from_slice(rates),
                None => known.late.resize(known.late.len() + n, 0.0),
            }
        }
        let mut add = |state: usize, factor: f64, of: usize| {
            let row = known.row(state);
            let (row, of) = (&mut known.late[row * n..][..n], &by_states.loads[of * n..][..n]);
            for i in 0..n {
                row[i] = factor.mul_add(of[i], row[i]);
            }
        };
        for i in 0..3 {
            (0..3).for_each(|k| add(l.velocity + i, attitude.0[i][k], k));
            add(l.rate + i, 1.0, 3 + i);
        }
        (0..own).for_each(|c| add(l.joints + own + c, 1.0, 6 + c));
        for (state, by) in impulses.rows() {
            (0..6 + own).for_each(|k| add(l.aero + state, -by[k], k));
        }
    }

    /// See [`Plant::derive`](wingbeat_ocp::plant::Plant::derive).
    pub(super) fn turned_columns(&self, x: &[f64], f: &[f64], known: &Known, a: &mut [f64]) {
        let (l, n) = (&self.layout, x.len());
        let q: [Dual<4>; 4] = std::array::from_fn(|k| Dual::variable(x[l.attitude + k], k));
        let q = Quat::from_wxyz(&q);
        known.turn(&q.matrix(), (x, f), l.attitude, a);
        let mut rates = [Dual::constant(0.0); 4];
        q.rate(Vec3::constant(Vec3::from_slice(&x[l.rate..]))).store_wxyz(&mut rates);
        for (row, rate) in a[l.attitude * n..].chunks_exact_mut(n).zip(rates) {
            row[l.attitude..][..4].copy_from_slice(&rate.eps);
        }
    }

    /// Adds the elements behind the coordinates of `out`, each with the joints that its acceleration moves. False where there is no room.
    fn add_elements(
        &self,
        clock: &Jet<f64>,
        structure: &[f64],
        out: &mut Evaluation<f64>,
    ) -> Result<bool, Fault> {
        let mut held = [Jet::ZERO; MAX_ELEMENTS];
        for (held, y) in held.iter_mut().zip(&structure[..self.elements.len()]) {
            held.x = *y;
        }
        let (tree, own) = (&self.mechanism.tree, self.degrees());
        let mut shares = out.coordinates.shares();
        let mut moved = Joints::new();
        for (i, element) in self.elements.iter().enumerate() {
            let mut add = |joint: usize, ratio: f64| {
                let room = shares < MAX_LINKS;
                if room {
                    out.coordinates.add_joint(own + i, tree, joint, ratio, &out.links);
                    shares += 1;
                }
                room
            };
            let of_joint = |moved: &Displaced| match moved {
                Displaced::Joint(joint) => Some(*joint),
                _ => None,
            };
            let room = if element.moves.iter().all(|moved| of_joint(moved).is_some()) {
                element.moves.iter().filter_map(of_joint).all(|joint| add(joint, 1.0))
            } else {
                // Second rates are linear in those of the displacements, whose rates are zero here.
                let still = Jet::new(clock.x, 0.0, 0.0);
                held[i].dd = 1.0;
                moved.clear();
                self.driven(self.phase_of(&still, structure, &held), &held, &mut moved)?;
                held[i].dd = 0.0;
                moved
                    .iter()
                    .enumerate()
                    .filter(|(_, jet)| jet.dd != 0.0)
                    .all(|(joint, jet)| add(joint, jet.dd))
            };
            if !room {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl BodySystem<f64, f64> {
    /// Accelerations (m/s2 and rad/s2, B) of the body under the wrench `net` and second rates of `own` coordinates, with their
    /// derivatives by uniform accelerations of gravity and of the air, along the axes of B, and by those of the `elements`, which follow
    /// the coordinates; `of_links` are the columns of the mass matrix without the air. `None` when the matrix is not positive
    /// definite.
    fn responses(
        &self,
        net: &Wrench<f64>,
        of_links: &Field,
        [own, elements]: [usize; 2],
    ) -> Option<ArrayVec<Late, MAX_DEGREES>> {
        let mut rhs = ArrayVec::new();
        append_copies(&mut rhs, Late::ZERO, 6 + own);
        for (i, value) in rhs.iter_mut().enumerate() {
            value.re = match i {
                0..3 => net.force[i],
                3..6 => net.moment[i - 3],
                _ => self.of_air[i - 6] + self.forces[i - 6],
            };
            for c in 0..3 {
                value.eps[c] = of_links[i][c];
                value.eps[3 + c] = self.mass[i][c] - of_links[i][c];
            }
            for e in 0..elements {
                value.eps[FIELDS + e] = -self.mass[i][6 + own + e];
            }
        }
        solve_symmetric_rows(&mut self.mass.clone(), &mut rhs)?;
        Some(rhs)
    }

    /// Turns the derivatives of loads by states into those of the accelerations of body and coordinates.
    fn accelerate(&self, by_states: &mut ByStates) -> Option<()> {
        let n = by_states.states;
        let degrees = by_states.loads.len() / n;
        let mut rhs = ArrayVec::<Late, MAX_DEGREES>::new();
        append_copies(&mut rhs, Late::ZERO, degrees);
        for first in (0..n).step_by(Late::LANES) {
            let width = Late::LANES.min(n - first);
            for (i, value) in rhs.iter_mut().enumerate() {
                value.eps[..width].copy_from_slice(&by_states.loads[i * n + first..][..width]);
            }
            solve_symmetric_rows(&mut self.mass.clone(), &mut rhs)?;
            for (i, value) in rhs.iter().enumerate() {
                by_states.loads[i * n + first..][..width].copy_from_slice(&value.eps[..width]);
            }
        }
        Some(())
    }
}

/// The load of a strip by `weights` of its force and moment.
fn weighed(weights: &[f64; 6], load: &Wrench<f64>) -> f64 {
    Vec3::from_slice(weights).dot(load.force) + Vec3::from_slice(&weights[3..]).dot(load.moment)
}
