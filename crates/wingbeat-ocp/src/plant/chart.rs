//! A local three-component attitude in place of the quaternion.

use super::{Channel, Early, Fault, Known, Late, MAX_STATES, PartsInEarly, Plant, Role};
use arrayvec::ArrayVec;
use std::ops::{Deref, Range};
use wingbeat_math::{Dual, Mat3, Over, Quat, Scalar, Vec3, append, append_copies, lift};

/// The plant seen in a chart around a reference attitude: q_WB = q_ref exp(d),
/// with the rotation vector d (rad, body axes) in place of the quaternion, so
/// that the plan has as many states as degrees of freedom.
///
/// Regular for |d| < 2 pi; re-centre it at every plan. [Given states](Plant::given_states) of the plant are none of the chart: they
/// move as [`motion_mut`](Self::motion_mut) says.
pub struct LocalChart<'a, P: Plant> {
    plant: Charted<'a, P>,
    reference: Quat,
    states: Vec<Channel>,
    motion: GivenMotion,
}

/// A plant of another, or one of its own.
enum Charted<'a, P> {
    Of(&'a P),
    Own(Box<P>),
}

impl<P> Deref for Charted<'_, P> {
    type Target = P;
    #[inline]
    fn deref(&self) -> &P {
        match self {
            Self::Of(plant) => plant,
            Self::Own(plant) => plant,
        }
    }
}

/// Given states over time: linear between rows at equal steps, held before the first and after the last.
#[derive(Clone, Debug, Default)]
pub struct GivenMotion {
    /// Number of given states.
    pub width: usize,
    /// Time of the first row, s.
    pub start: f64,
    /// Time from row to row, s.
    pub step: f64,
    /// The states in their order, row by row, in the units of their channels.
    pub rows: Vec<f64>,
}

impl GivenMotion {
    /// The states at the time `t`, s.
    fn at(&self, t: f64) -> ArrayVec<f64, MAX_STATES> {
        let last = (self.rows.len() / self.width).saturating_sub(1);
        let place = ((t - self.start) / self.step).clamp(0.0, last as f64);
        let k = (place as usize).min(last.saturating_sub(1));
        let share = place - k as f64;
        let (one, other) = (&self.rows[k * self.width..], &self.rows[(k + 1).min(last) * self.width..]);
        let mut states = ArrayVec::new();
        for i in 0..self.width {
            states.push(one[i] + (other[i] - one[i]) * share);
        }
        states
    }
}

impl<'a, P: Plant> LocalChart<'a, P> {
    /// A chart of `plant` centred at no rotation.
    pub fn new(plant: &'a P) -> Self {
        Self::charting(Charted::Of(plant))
    }

    /// A chart that has its `plant`.
    pub fn owning(plant: P) -> Self {
        Self::charting(Charted::Own(Box::new(plant)))
    }

    fn charting(plant: Charted<'a, P>) -> Self {
        let mut states = plant.states().to_vec();
        for run in plant.given_states().iter().rev() {
            states.drain(run.clone());
        }
        if let Some(a) = plant.attitude() {
            let axis =
                |(i, name)| Channel::free(format!("rotation_{name}"), "rad", "B").of(Role::Rotation(i));
            states.splice(a..a + 4, ["x", "y", "z"].into_iter().enumerate().map(axis));
        }
        let width = plant.given_states().iter().map(Range::len).sum();
        let motion = GivenMotion { width, rows: vec![0.0; width], step: 1.0, ..GivenMotion::default() };
        Self { plant, reference: Quat::IDENTITY, states, motion }
    }

    /// How the given states move.
    pub fn motion_mut(&mut self) -> &mut GivenMotion {
        &mut self.motion
    }

    /// Centres the chart at the attitude of the plant state `x`.
    pub fn center_at(&mut self, x: &[f64]) {
        if let Some(a) = self.plant.attitude() {
            self.reference = Quat::from_wxyz(&x[a..]).normalized();
        }
    }

    /// The attitude at which the chart is centred.
    pub fn reference(&self) -> Quat {
        self.reference
    }

    /// Index of the rotation vector in the local state, if the plant has an attitude.
    pub fn rotation(&self) -> Option<usize> {
        self.plant.attitude()
    }

    /// R_WB of a local state.
    pub fn rotation_matrix<S: Scalar>(&self, local: &[S]) -> Mat3<S> {
        match self.plant.attitude() {
            Some(a) => self.attitude_of(local, a).matrix(),
            None => Mat3::IDENTITY,
        }
    }

    /// Local coordinates of the plant state `x`, in the units of their channels, the attitude as a rotation vector in rad.
    pub fn localise(&self, x: &[f64], local: &mut [f64]) {
        let Some(a) = self.plant.attitude() else {
            local.copy_from_slice(x);
            return;
        };
        local[..a].copy_from_slice(&x[..a]);
        (self.reference.conjugate() * Quat::from_wxyz(&x[a..])).log().store(&mut local[a..]);
        local[a + 3..].copy_from_slice(&x[a + 4..]);
    }

    /// Local coordinates in this chart of a state given in a chart centred at `center`, in the units of their channels, the
    /// attitude as a rotation vector in rad.
    pub fn adopt(&self, center: Quat, local: &mut [f64]) {
        if let Some(a) = self.plant.attitude() {
            let turned = self.reference.conjugate() * center * Quat::exp(Vec3::from_slice(&local[a..]));
            turned.log().store(&mut local[a..]);
        }
    }

    /// Plant state of the local coordinates, in the units of its channels, without the states that are given.
    pub fn globalise<S: Scalar>(&self, local: &[S], x: &mut [S]) {
        let Some(a) = self.plant.attitude() else {
            x.copy_from_slice(local);
            return;
        };
        x[..a].copy_from_slice(&local[..a]);
        self.attitude_of(local, a).store_wxyz(&mut x[a..]);
        x[a + 4..].copy_from_slice(&local[a + 3..]);
    }

    /// As [`globalise`](Self::globalise) into room not yet filled, the attitude being at `a`, with what is given at the time `t`, s.
    fn extend_globally<S: Scalar>(&self, t: f64, local: &[S], a: usize, x: &mut States<S>) {
        let n = local.len() + 1 + self.motion.width;
        assert!(n <= MAX_STATES, "{n} states exceed the chart's capacity {MAX_STATES}");
        let Quat { w, v } = self.attitude_of(local, a);
        for values in [&local[..a], &[w, v[0], v[1], v[2]]] {
            append(x, values);
        }
        match self.motion.width {
            0 => append(x, &local[a + 3..]),
            _ => self.extend_given(t, a + 4, &local[a + 3..], x),
        }
    }

    /// `values` of the plant's states from `first` on, at the time `t` (s), behind those in `x`, with the given states among and after them.
    #[inline(never)]
    fn extend_given<S: From<f64> + Copy>(&self, t: f64, first: usize, mut values: &[S], x: &mut States<S>) {
        let given = self.motion.at(t);
        let (mut at, mut passed) = (first, 0);
        for run in self.plant.given_states() {
            if run.start >= at {
                let count = (run.start - at).min(values.len());
                append(x, &values[..count]);
                values = &values[count..];
                at += count;
                if run.start > at {
                    return;
                }
                given[passed..passed + run.len()].iter().for_each(|value| x.push(S::from(*value)));
                at = run.end;
            }
            passed += run.len();
        }
        append(x, values);
    }

    /// The `late` states of the plant at the time `t`, s; `room` is where those with given ones among them are put together.
    #[inline(always)]
    fn late_of<'v, S: From<f64> + Copy>(&self, t: f64, late: &'v [S], room: &'v mut States<S>) -> &'v [S] {
        if self.motion.width == 0 {
            return late;
        }
        self.extend_given(t, self.plant.late_states(), late, room);
        room
    }

    fn attitude_of<S: Scalar>(&self, local: &[S], a: usize) -> Quat<S> {
        Quat::constant(self.reference) * Quat::exp(Vec3::from_slice(&local[a..]))
    }
}

/// Room for the states of a plant, or their rates, of which no more is written than there are.
type States<S> = ArrayVec<S, MAX_STATES>;

/// `n` rates, all zero.
fn rest<S: Scalar>(rates: &mut States<S>, n: usize) {
    assert!(n <= MAX_STATES, "{n} states exceed the chart's capacity {MAX_STATES}");
    append_copies(rates, S::ZERO, n);
}

/// Rate of the rotation vector d of q = q_ref exp(d) for the angular rate w in the rotated axes, rad/s: d' = w + (d x w)/2 + k
/// d x (d x w), k = 1/a^2 - (1 + cos a)/(2 a sin a), a = |d| (Bortz 1971, eq. 8).
pub fn rotation_vector_rate<S: Scalar>(d: Vec3<S>, w: Vec3<S>) -> Vec3<S> {
    let a2 = d.norm_squared();
    let k = if a2.value() < 1e-4 {
        S::from(1.0 / 12.0) + a2 * (1.0 / 720.0) + a2 * a2 * (1.0 / 30240.0)
    } else {
        let a = a2.sqrt();
        let (s, c) = a.sin_cos();
        a2.recip() - (c + 1.0) / (a * s * 2.0)
    };
    let dw = d.cross(w);
    w + dw * S::from(0.5) + d.cross(dw) * k
}

impl<P: Plant> Plant for LocalChart<'_, P> {
    fn states(&self) -> &[Channel] {
        &self.states
    }
    fn inputs(&self) -> &[Channel] {
        self.plant.inputs()
    }
    fn rates<S: Scalar>(&self, t: S, local: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        self.localised(t.value(), local, 0, dx, |x, dx| self.plant.rates(t, x, u, dx))
    }
    fn clearances(&self) -> &[Channel] {
        self.plant.clearances()
    }
    fn clear<S: Scalar>(&self, t: S, local: &[S], values: &mut [S]) -> Result<(), Fault> {
        let Some(a) = self.plant.attitude() else {
            return self.plant.clear(t, local, values);
        };
        let mut x = States::new();
        self.extend_globally(t.value(), local, a, &mut x);
        self.plant.clear(t, &x, values)
    }
    fn unfelt_states(&self) -> Range<usize> {
        self.plant.unfelt_states()
    }
    fn driven_states(&self) -> Range<usize> {
        let driven = self.plant.driven_states();
        let attitude = self.plant.attitude().filter(|attitude| *attitude < driven.start);
        let given = self.plant.given_states().iter().filter(|run| run.start < driven.start);
        let before = attitude.map_or(0, |_| 1) + given.map(Range::len).sum::<usize>();
        driven.start - before..driven.end - before
    }
    fn placing_states(&self) -> [Range<usize>; 2] {
        let less = usize::from(self.plant.attitude().is_some());
        self.plant.placing_states().map(|run| run.start.saturating_sub(less)..run.end.saturating_sub(less))
    }
    fn known(
        &self,
        t: f64,
        local: &[f64],
        u: &[f64],
        dx: &mut [f64],
        known: &mut Known,
    ) -> Result<bool, Fault> {
        let mut knows = false;
        if let Some(a) = self.plant.attitude() {
            // Of the quaternion three rows are left, for the rotation vector.
            known.left_out.push(a..a + 1);
            known.left_out.extend_from_slice(self.plant.given_states());
        }
        self.localised(t, local, 0, dx, |x, dx| {
            knows = self.plant.known(t, x, u, dx, known)?;
            Ok(())
        })?;
        Ok(knows)
    }
    fn derived_states(&self) -> Range<usize> {
        let derived = self.plant.derived_states();
        derived.start
            ..derived.end.saturating_sub(usize::from(self.plant.attitude().is_some())).max(derived.start)
    }
    fn derive(&self, local: &[f64], f: &[f64], known: &Known, a: &mut [f64]) {
        let Some(at) = self.plant.attitude() else {
            return self.plant.derive(local, f, known, a);
        };
        let mut seeded = States::new();
        for (i, value) in local[..at + 3].iter().enumerate() {
            seeded.push(i.checked_sub(at).map_or(Dual::constant(*value), |k| Dual::<3>::variable(*value, k)));
        }
        known.turn(&self.rotation_matrix(&seeded), (local, f), at, a);
        let rate = Vec3::constant(Vec3::from_slice(&local[known.rate..]));
        let turning = rotation_vector_rate(Vec3::from_slice(&seeded[at..]), rate);
        for (row, rate) in a[at * local.len()..].chunks_exact_mut(local.len()).zip(turning.0) {
            row[at..at + 3].copy_from_slice(&rate.eps);
        }
    }
    fn late_states(&self) -> usize {
        let late = self.plant.late_states();
        let given = self.plant.given_states().iter().filter(|run| run.start < late);
        late - usize::from(self.plant.attitude().is_some()) - given.map(Range::len).sum::<usize>()
    }
    fn rates_by_late<S: Over<f64>>(
        &self,
        t: f64,
        early: &[f64],
        late: &[S],
        u: &[f64],
        dx: &mut [S],
    ) -> Result<(), Fault> {
        let mut room = States::new();
        let late = self.late_of(t, late, &mut room);
        self.localised(t, early, late.len(), dx, |x, dx| self.plant.rates_by_late(t, x, late, u, dx))
    }
    fn rates_in_numbers(&self, t: f64, local: &[f64], u: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        self.localised(t, local, 0, dx, |x, dx| self.plant.rates_in_numbers(t, x, u, dx))
    }
    fn rates_in_early(&self, t: f64, local: &[Early], u: &[Early], dx: &mut [Early]) -> Result<(), Fault> {
        self.localised(t, local, 0, dx, |x, dx| self.plant.rates_in_early(t, x, u, dx))
    }
    fn rates_in_moving(&self, t: f64, local: &[Early], u: &[Early], dx: &mut [Early]) -> Result<(), Fault> {
        self.localised(t, local, 0, dx, |x, dx| self.plant.rates_in_moving(t, x, u, dx))
    }
    fn rates_about(
        &self,
        known: &Known,
        places: bool,
        (t, [early, late], u): PartsInEarly<'_>,
        [dx, late_dx]: [&mut [Early]; 2],
    ) -> Result<(), Fault> {
        if self.motion.width == 0 {
            return self.localised(t, early, 0, dx, |x, dx| {
                self.plant.rates_about(known, places, (t, [x, late], u), [dx, late_dx])
            });
        }
        let (mut local, mut rates) = (States::new(), States::new());
        append(&mut local, early);
        append(&mut local, late);
        rest(&mut rates, local.len());
        self.localised(t, &local, 0, &mut rates, |x, dx| {
            let (early, late) = x.split_at(self.plant.late_states());
            let (dx, late_dx) = dx.split_at_mut(early.len());
            self.plant.rates_about(known, places, (t, [early, late], u), [dx, late_dx])
        })?;
        dx.copy_from_slice(&rates[..dx.len()]);
        late_dx.copy_from_slice(&rates[dx.len()..]);
        Ok(())
    }
    fn rates_in_late(
        &self,
        t: f64,
        early: &[f64],
        late: &[Late],
        u: &[f64],
        dx: &mut [Late],
    ) -> Result<(), Fault> {
        let mut room = States::new();
        let late = self.late_of(t, late, &mut room);
        self.localised(t, early, late.len(), dx, |x, dx| self.plant.rates_in_late(t, x, late, u, dx))
    }
}

impl<P: Plant> LocalChart<'_, P> {
    /// Rates of the coordinates `local` at the time `t` (s), and of `beyond` states of the plant after them, from its `rates`.
    #[inline(always)]
    fn localised<G: Scalar, S: Over<G>>(
        &self,
        t: f64,
        local: &[G],
        beyond: usize,
        dx: &mut [S],
        rates: impl FnOnce(&[G], &mut [S]) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let Some(a) = self.plant.attitude() else {
            return rates(local, dx);
        };
        let (mut x, mut plant_dx) = (States::new(), States::new());
        self.extend_globally(t, local, a, &mut x);
        rest(&mut plant_dx, x.len() + beyond);
        rates(&x, &mut plant_dx)?;
        for run in self.plant.given_states().iter().rev() {
            plant_dx.drain(run.clone());
        }
        localise_rates(a, &x, local, &plant_dx, dx);
        Ok(())
    }
}

/// Rates of the local coordinates from those of the plant's state `x`, whose attitude is at `a`.
fn localise_rates<G: Scalar, S: Over<G>>(a: usize, x: &[G], local: &[G], rates: &[S], dx: &mut [S]) {
    let (mut attitude, mut rotation) = ([S::ZERO; 4], [S::ZERO; 3]);
    lift(&x[a..], &mut attitude);
    lift(&local[a..], &mut rotation);
    dx[..a].copy_from_slice(&rates[..a]);
    // w = 2 vec(q* q') undoes q' = q (0, w)/2.
    let half_w = (Quat::from_wxyz(&attitude).conjugate() * Quat::from_wxyz(&rates[a..])).v;
    rotation_vector_rate(Vec3(rotation), half_w * S::from(2.0)).store(&mut dx[a..]);
    dx[a + 3..].copy_from_slice(&rates[a + 4..]);
}
