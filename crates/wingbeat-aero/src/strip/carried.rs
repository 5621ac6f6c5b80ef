//! The air that the strips carry along: its impulse by the motion of the wing, and its inertia.

use super::influence::{
    StripColumn, column, dot, dot_some, lanes, large, multiply, multiply_some, multiply_transposed,
};
use super::motion::{Strips, Vectors};
use super::{StripFlow, StripModel};
use crate::{ImpulseRates, ImpulseRow, SectionFields, Sections};
use arrayvec::ArrayVec;
use std::ops::Range;
use wingbeat_math::{Meets, Over, Scalar, Vec3};
use wingbeat_ocp::plant::{MAX_COORDINATES, MAX_DEGREES};

/// What drives the carried air of a strip at 1/2 chord, or where aero.strip.carried_place has it: its normal acceleration per acceleration
/// and angular acceleration of the body (6), the wash there, m/s, and its rate, m/s2.
type CarriedDrive<S> = [S; 8];

/// How the strips move per unit rate of a coordinate.
struct CoordinateField<S: Scalar, const N: usize> {
    /// Normal velocity where the wash drives the carried air, m/s over the unit of the rate.
    heave: StripColumn<S, N>,
    /// Pitch rate, rad/s over the unit of the rate.
    pitch: StripColumn<S, N>,
    /// From the first to the last strip that moves.
    strips: Range<usize>,
}

impl<S: Scalar, const N: usize> CoordinateField<S, N> {
    const STILL: Self = Self { heave: [S::ZERO; N], pitch: [S::ZERO; N], strips: 0..0 };
}

impl<P: Scalar> StripModel<P> {
    /// What A0^-1 leaves of the motion, the impulse of the carried air and, unless motions are `complete`, its inertia.
    pub(super) fn carry_air<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &mut StripFlow<K, G, N>,
        complete: bool,
    ) {
        let mut rate_left = [G::ZERO; N];
        self.place_wash(flow);
        if !complete {
            self.add_inertia(flow, &mut rate_left);
        }
        if complete || const { size_of::<G>() > size_of::<K>() } {
            let [wash, rate] = self.driving(flow);
            (flow.half_left, rate_left) = (
                multiply(&flow.relief, wash, self.settings.strips),
                multiply(&flow.relief, rate, self.settings.strips),
            );
        }
        if self.settings.section.added_mass {
            self.impulses_of_motion(flow, &rate_left);
        } else {
            (flow.impulse, flow.impulse_rate) = ([G::ZERO; N], [G::ZERO; N]);
        }
        if !complete {
            self.finish_added_mass(flow);
        }
    }

    /// Takes the wash that drives the carried air where it is not at 1/2 chord.
    #[inline(always)]
    fn place_wash<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &mut StripFlow<K, G, N>,
    ) {
        let Some(behind) = &self.tables.behind else { return };
        let strips = &flow.strips;
        for i in 0..lanes::<G, N>(self.settings.strips) {
            flow.placed[0][i] = strips.wash_half[i] + strips.pitch[i] * behind[i];
            flow.placed[1][i] = strips.wash_half_rate[i] + strips.pitch_rate[i] * behind[i];
        }
    }

    /// The wash that drives the carried air, m/s, and its rate, m/s2.
    #[inline(always)]
    fn driving<'a, K: Scalar, G: Over<K>, const N: usize>(
        &self,
        flow: &'a StripFlow<K, G, N>,
    ) -> [&'a StripColumn<G, N>; 2] {
        match self.tables.behind {
            Some(_) => flow.placed.each_ref(),
            None => [&flow.strips.wash_half, &flow.strips.wash_half_rate],
        }
    }

    /// Adds the inertia of the carried air, not yet symmetric, and sets what A0^-1 leaves of the wash at 1/2 chord and, in `rate_left`, of
    /// its rate, as far as places tell them.
    #[inline(always)]
    fn add_inertia<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &mut StripFlow<K, G, N>,
        rate_left: &mut StripColumn<G, N>,
    ) {
        let drives = self.drives(flow);
        for i in 0..lanes::<K, N>(self.settings.strips) {
            let left = self.left_at(i, flow, &drives);
            (flow.half_left[i], rate_left[i]) = (G::from(left[6]), G::from(left[7]));
            let mass = if self.settings.section.added_mass { self.tables.mass[i] } else { P::ZERO };
            for r in 0..6 {
                let driven = drives[i][r] * mass;
                for c in 0..6 {
                    flow.added_mass[r][c] = left[c].mul_add(driven, flow.added_mass[r][c]);
                }
            }
        }
    }

    fn drives<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &StripFlow<K, G, N>,
    ) -> [CarriedDrive<K>; N] {
        let (strips, [wash, rate]) = (&flow.strips, self.driving(flow));
        let drive = |i: usize| {
            let ([a, b, c], [d, e, f]) = (strips.normal.get(i).0, self.turn(strips, i).0);
            [a, b, c, d, e, f, wash[i].beneath(), rate[i].beneath()]
        };
        if const { large::<K>() } {
            let still = |i: usize| if i < self.settings.strips { drive(i) } else { [K::ZERO; 8] };
            return std::array::from_fn(still);
        }
        let mut drives = [[K::ZERO; 8]; N];
        for i in 0..lanes::<K, N>(self.settings.strips) {
            drives[i] = drive(i);
        }
        drives
    }

    /// Normal velocity of the air that strip `i` carries per angular velocity about the body origin, m.
    #[inline(always)]
    fn turn<K: Scalar + Meets<P>, G: Over<K>, const N: usize>(
        &self,
        strips: &Strips<K, G, N>,
        i: usize,
    ) -> Vec3<K> {
        let at_half = strips.half.get(i).cross(strips.normal.get(i));
        match &self.tables.behind {
            Some(behind) => at_half - strips.across.get(i).scaled(behind[i]),
            None => at_half,
        }
    }

    /// Row `i` of A0^-1 times the drives.
    #[inline(always)]
    fn left_at<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        drives: &[CarriedDrive<K>; N],
    ) -> CarriedDrive<K> {
        let mut left = [K::ZERO; 8];
        for j in 0..self.settings.strips {
            for k in 0..8 {
                left[k] = drives[j][k].mul_add(flow.relief[j][i], left[k]);
            }
        }
        left
    }

    /// P = B w12 + rho dy ma A0^-1 [K (D - Y) + R Y], with B the symmetric part of rho dy ma A0^-1 (reciprocity).
    /// Sets the first part and its rate, the rate of A0 left out: see aero.strip.followed_impulse.
    ///
    /// Equation: aero.strip.impulse
    /// `P = sym(rho dy ma A0^-1) w12 + rho dy ma A0^-1 [K (D - Y) + R Y]`
    /// Source: Kirchhoff 1869; reciprocity.
    /// Test: `the_added_mass_is_symmetric_and_positive`.
    fn impulses_of_motion<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &mut StripFlow<K, G, N>,
        rate_left: &StripColumn<G, N>,
    ) {
        let [wash, rate] = self.driving(flow);
        let by_half = self.reciprocal(flow, wash);
        let by_rate = self.reciprocal(flow, rate);
        for i in 0..lanes::<G, N>(self.settings.strips) {
            let mass = self.tables.mass[i];
            flow.impulse[i] = (flow.half_left[i] * mass + by_half[i]) * 0.5;
            flow.impulse_rate[i] = (rate_left[i] * mass + by_rate[i]) * 0.5;
        }
    }

    /// Adds the rows and columns 6.. of the added-mass matrix, on the second rates of the coordinates
    /// of `sections`: as the body's own, with J the normal velocity at 1/2 chord per unit rate.
    pub(super) fn couple<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &StripFlow<K, G, N>,
        sections: &dyn Sections<G>,
        matrix: &mut [[G; MAX_DEGREES]],
    ) {
        let (strips, n) = (&flow.strips, self.settings.strips);
        let mut fields = ArrayVec::new();
        let moved = self.heave_and_pitch(flow, sections, &mut fields);
        if moved == 0 {
            return;
        }
        let mut impulses = ArrayVec::new();
        self.symmetric_impulses(flow, moved, &mut impulses);
        let mut moments = Vectors::<K, N>::ZERO;
        for i in 0..lanes::<K, N>(n) {
            moments.set(i, self.turn(strips, i));
        }
        let resistance: StripColumn<K, N> = column(n, |i| {
            if !self.settings.section.section_moment {
                return K::ZERO;
            }
            let b = self.tables.chord[i] * 0.5;
            self.section_mass(i, flow) * (b * b * 0.125)
        });
        for (c, field) in fields.iter().enumerate() {
            let CoordinateField { heave, pitch, strips: some } = field;
            let mut carried = multiply_some(&impulses, heave, some.clone(), n);
            let mut turned = *pitch;
            for i in 0..lanes::<G, N>(n) {
                turned[i] = turned[i] * resistance[i];
            }
            if self.hinges.is_some() {
                self.relieve_field(flow, [heave, pitch], [&mut carried, &mut turned]);
            }
            let mut add = |k: usize, share: G| {
                matrix[6 + c][k] += share;
                if k != 6 + c {
                    matrix[k][6 + c] += share;
                }
            };
            for k in 0..3 {
                let turning = dot_some(&strips.across.0[k], &turned, some.clone());
                add(k, dot_some(&strips.normal.0[k], &carried, 0..n));
                add(3 + k, dot_some(&moments.0[k], &carried, 0..n) + turning);
            }
            for (other, of) in fields[..=c].iter().enumerate() {
                let heaving = dot_some(&carried, &of.heave, of.strips.clone());
                add(6 + other, heaving + dot_some(&turned, &of.pitch, of.strips.clone()));
            }
        }
    }

    /// Adds B J for the strips whose impulses are followed: how their forces fall with the accelerations of the body and of
    /// the coordinates of `sections`, J as for [`couple`](Self::couple).
    pub(super) fn follow<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &StripFlow<K, G, N>,
        sections: &dyn Sections<G>,
        rates: &mut ImpulseRates<G>,
    ) {
        let (drives, n) = (self.drives(flow), self.settings.strips);
        let first = rates.rows.len();
        let rows = (0..n).map(|i| ImpulseRow {
            state: rates.first_state + self.followed_states() + i,
            by: [G::ZERO; MAX_DEGREES],
        });
        rates.rows.extend(rows);
        let (mut fields, mut impulses) = (ArrayVec::new(), ArrayVec::new());
        self.heave_and_pitch(flow, sections, &mut fields);
        self.symmetric_impulses(flow, u64::MAX, &mut impulses);
        let body = (0..6).map(|c| (std::array::from_fn(|i| G::from(drives[i][c])), 0..n));
        let own = fields.iter().map(|field| (field.heave, field.strips.clone()));
        for (c, (heave, some)) in body.chain(own).enumerate() {
            let carried = multiply_some(&impulses, &heave, some, n);
            for (row, carried) in rates.rows[first..].iter_mut().zip(carried) {
                row.by[c] = carried;
            }
        }
    }

    /// How strips move per unit rate of each coordinate, which is what `fields` gets; returns the strips that move, as bits.
    fn heave_and_pitch<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &StripFlow<K, G, N>,
        sections: &dyn Sections<G>,
        fields: &mut ArrayVec<CoordinateField<G, N>, MAX_COORDINATES>,
    ) -> u64 {
        let strips = &flow.strips;
        let mut edges = [SectionFields::new(), SectionFields::new()];
        let mut moves = [sections.fields(0, &mut edges[0]), 0];
        fields.extend(edges[0].iter().map(|_| CoordinateField::STILL));
        let mut moved = 0;
        for i in 0..self.settings.strips {
            let (a, b) = (i % 2, (i + 1) % 2);
            moves[b] = sections.fields(i + 1, &mut edges[b]);
            let mut coordinates = moves[0] | moves[1];
            if coordinates == 0 {
                continue;
            }
            moved |= 1 << i;
            let [fraction, quarter, half, _] = self.tables.section(i);
            let inverse_chord =
                (strips.half.get(i) - strips.quarter.get(i)).norm().recip() * (half - quarter);
            let (chordwise, normal) = (strips.chordwise.get(i), strips.normal.get(i));
            let normals = [normal, self.zero_lift.upward(chordwise, normal)].map(Vec3::lifted);
            let inverse_chord = G::from(inverse_chord);
            while coordinates != 0 {
                let c = coordinates.trailing_zeros() as usize;
                coordinates &= coordinates - 1;
                let field = edges[a][c].mixed(&edges[b][c], fraction);
                let of = &mut fields[c];
                (of.heave[i], of.pitch[i]) = field.heave_and_pitch(half, normals, inverse_chord);
                if let Some(behind) = &self.tables.behind {
                    of.heave[i] -= of.pitch[i] * behind[i];
                }
                let first = if of.strips.is_empty() { i } else { of.strips.start };
                of.strips = first..i + 1;
            }
        }
        moved
    }

    /// The columns of B, the symmetric part of rho dy ma A0^-1, of the strips `wanted`, as bits; those of others are zero, and without added
    /// mass all are.
    fn symmetric_impulses<K: Scalar + Meets<P>, G: Scalar, const N: usize>(
        &self,
        flow: &StripFlow<K, G, N>,
        wanted: u64,
        columns: &mut ArrayVec<StripColumn<K, N>, N>,
    ) {
        let (n, relief) = (self.settings.strips, &flow.relief);
        for j in 0..n.min(N) {
            let empty = wanted >> j & 1 == 0 || !self.settings.section.added_mass;
            let mass = self.tables.mass[j];
            columns.push(column(n, |i| {
                if empty { K::ZERO } else { (relief[j][i] * self.tables.mass[i] + relief[i][j] * mass) * 0.5 }
            }));
        }
    }

    /// The transpose of rho dy ma A0^-1 times `v`.
    fn reciprocal<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &StripFlow<K, G, N>,
        v: &StripColumn<G, N>,
    ) -> StripColumn<G, N> {
        let weighted: StripColumn<G, N> = column(self.settings.strips, |i| v[i] * self.tables.mass[i]);
        multiply_transposed(&flow.relief, &weighted, self.settings.strips)
    }

    /// M = sym(J' rho dy ma A0^-1 J) with J = [n; r x n] per strip, plus the pitch inertia of the
    /// sections; `flow` holds the first part before it is made symmetric.
    ///
    /// Equation: aero.strip.added_mass_matrix
    /// `M = J' B J, J = [n; r x n]`
    /// Source: virtual work.
    /// Test: `loads_are_affine_in_the_body_acceleration`.
    fn finish_added_mass<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, const N: usize>(
        &self,
        flow: &mut StripFlow<K, G, N>,
    ) {
        if self.settings.section.section_moment {
            let across = &flow.strips.across.0;
            let mut turned = [[K::ZERO; N]; 3];
            for i in 0..lanes::<K, N>(self.settings.strips) {
                let b = self.tables.chord[i] * 0.5;
                let inertia = self.section_mass(i, flow) * (b * b * 0.125);
                for axis in 0..3 {
                    turned[axis][i] = across[axis][i] * inertia;
                }
            }
            for r in 0..3 {
                for c in 0..3 {
                    flow.added_mass[3 + r][3 + c] += dot(&turned[r], &across[c], self.settings.strips);
                }
            }
        }
        // In place: a copy of what has just been written piece by piece waits for its pieces.
        let matrix = &mut flow.added_mass;
        for r in 0..6 {
            for c in 0..r {
                let mean = (matrix[r][c] + matrix[c][r]) * 0.5;
                (matrix[r][c], matrix[c][r]) = (mean, mean);
            }
        }
    }
}
