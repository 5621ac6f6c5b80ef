//! Derivatives of rates and loads by all states of the nodes at once. What a node holds acts on itself, and on all others by one induced
//! wash, so that one pass carries the derivatives by the states of each node and by that wash side by side; the wash is linear in the
//! circulations.

use super::LiftingLine;
use crate::strip::{ByStates, row, without_slopes};
use crate::{Coupling, MAX_STRIPS, Sections, Wrench};
use arrayvec::ArrayVec;
use wingbeat_math::{Dual, Scalar, Vec3, append_copies};

/// Most derivatives that the pass carries: by the wash and by the states of a node. *Choice*: two registers of AVX2.
const LANES: usize = 8;
/// Most states.
const MOST: usize = MAX_STRIPS * (LANES - 1);

type NodeDual = Dual<LANES>;

impl LiftingLine {
    /// Whether [`by_states`](Self::by_states) takes this line: preset `as_printed` scales the wash.
    pub(crate) fn knows_by_states(&self) -> bool {
        !self.settings.as_printed && self.strips() <= MAX_STRIPS && self.states() < LANES * self.strips()
    }

    /// As an evaluation of one surface alone, with the derivatives by all of its states: df_i/dx_j = df_i/dx_i (i = j) - df_i/dw_i D_ij of
    /// circulations x_j, of the wash w_i = -sum D_ij x_j.
    #[inline(never)]
    pub(crate) fn by_states(
        &self,
        sections: &impl Sections<f64>,
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
        coupling: Coupling<'_, f64, f64>,
        out: &mut ByStates,
    ) -> (Wrench<f64>, [[f64; 6]; 6]) {
        let (m, states) = (self.strips(), self.states());
        let (mut seeded, mut rates) = (ArrayVec::<NodeDual, MOST>::new(), ArrayVec::<NodeDual, MOST>::new());
        append_copies(&mut seeded, NodeDual::ZERO, states);
        append_copies(&mut rates, NodeDual::ZERO, states);
        for s in 0..states {
            seeded[s] = NodeDual::variable(x[s], 1 + s / m);
        }
        let mut strips = ArrayVec::<Wrench<NodeDual>, MAX_STRIPS>::new();
        append_copies(&mut strips, Wrench::ZERO, m);
        let by_strip = coupling.strips;
        let coupling = Coupling { mass: coupling.mass, strips: &mut strips, impulses: None };
        let induced = |i| NodeDual::variable(self.induced_wash(i, &x[..m]), 0);
        let states_of = (&seeded[..], &mut rates[..]);
        let (total, added_mass) = self.sum_in(sections, wind, states_of, Some(coupling), induced);
        for i in 0..states {
            dx[i] = rates[i].re;
        }
        for i in 0..m {
            by_strip[i] = without_slopes(&strips[i]);
        }
        out.states = states;
        out.rates.clear();
        out.rates.resize(states * states, 0.0);
        for (s, of) in out.rates.chunks_exact_mut(states).enumerate() {
            let i = s % m;
            let (washed, own) = of.split_at_mut(m);
            self.add_washed(washed, i, rates[s].eps[0]);
            washed[i] += rates[s].eps[1];
            for block in 1..states / m {
                own[(block - 1) * m + i] = rates[s].eps[1 + block];
            }
        }
        let loads = 6 + out.weights.len() / m;
        out.loads.clear();
        out.loads.resize(loads * states, 0.0);
        for (r, of) in out.loads.chunks_exact_mut(states).enumerate() {
            for i in 0..m {
                let load = row(r, i, &out.weights, m, &strips[i]);
                self.add_washed(&mut of[..m], i, load.eps[0]);
                for block in 0..states / m {
                    of[block * m + i] += load.eps[1 + block];
                }
            }
        }
        (without_slopes(&total), added_mass)
    }

    /// Adds what circulations do to a number that changes by `slope` with the wash at node `i`.
    #[inline]
    fn add_washed(&self, by: &mut [f64], i: usize, slope: f64) {
        let influence = &self.layout.influence[i * by.len()..][..by.len()];
        for j in 0..by.len() {
            by[j] -= slope * influence[j];
        }
    }
}
