//! The numbers of a tethered wing's spar that a fit may find.

use super::spar_spec::{SparSpec, SparStationSpec};
use wingbeat_math::range::Range;
use wingbeat_math::{DeclaredQuantity, Parameters, Scalar, Walk};

/// Stiffness of the whole spar over that of its stations, and its damping.
#[derive(Clone, Copy, Debug)]
pub(super) struct SparNumbers<P: Scalar = f64> {
    bending_scale: P,
    edge_bending_scale: P,
    torsion_scale: P,
    damping_s: P,
}

const SCALE: DeclaredQuantity = DeclaredQuantity::within("", Range::POSITIVE, 1e-3, 1e3);
const DAMPING: DeclaredQuantity = DeclaredQuantity::within("s", Range::NOT_NEGATIVE, 0.0, 1e3);

impl SparNumbers {
    /// Those of a spar as its case writes it.
    pub fn of(spar: &SparSpec) -> Self {
        Self { bending_scale: 1.0, edge_bending_scale: 1.0, torsion_scale: 1.0, damping_s: spar.damping_s }
    }

    /// `spar` with these numbers.
    ///
    /// Equation: spar.scales
    /// `k_ij times sqrt(s_i s_j), s the scales of twist and of both bendings`
    /// Source: choice: a stiffness that was positive definite stays so, with its couplings.
    /// Test: `a_spar_is_scaled_as_its_stations_are`.
    pub fn on(&self, spar: &SparSpec) -> SparSpec {
        let [twist, bending, edge] = [self.torsion_scale, self.bending_scale, self.edge_bending_scale];
        let station = |station: &SparStationSpec| {
            let [twist_bending, twist_edge, both] = station.couplings_n_m2;
            SparStationSpec {
                torsion_n_m2: station.torsion_n_m2 * twist,
                bending_n_m2: station.bending_n_m2 * bending,
                edge_bending_n_m2: station.edge_bending_n_m2 * edge,
                couplings_n_m2: [
                    twist_bending * (twist * bending).sqrt(),
                    twist_edge * (twist * edge).sqrt(),
                    both * (bending * edge).sqrt(),
                ],
                ..*station
            }
        };
        SparSpec {
            stations: spar.stations.iter().map(station).collect(),
            damping_s: self.damping_s,
            ..spar.clone()
        }
    }
}

impl<P: Scalar> Parameters<P> for SparNumbers<P> {
    type In<Q: Scalar> = SparNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> SparNumbers<Q> {
        at.within("spar", |at| SparNumbers {
            bending_scale: at.number("bending_scale", &SCALE, self.bending_scale),
            edge_bending_scale: at.number("edge_bending_scale", &SCALE, self.edge_bending_scale),
            torsion_scale: at.number("torsion_scale", &SCALE, self.torsion_scale),
            damping_s: at.number("damping_s", &DAMPING, self.damping_s),
        })
    }
}
