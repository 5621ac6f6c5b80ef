//! The numbers of a surface that may carry derivatives.

use super::planform::COORDINATE;
use super::{FlapNumbers, MembraneNumbers, Planform, ProfileDrag, law};
use arrayvec::ArrayVec;
use std::f64::consts::FRAC_PI_2;
use wingbeat_math::range::Range;
use wingbeat_math::{DeclaredQuantity, Parameters, Scalar, Walk};

/// What the density of the air is called, which each surface has for itself.
pub const AIR_DENSITY: &str = "air.density_kg_m3";

/// Most lags of the wash on a chord.
pub const MAX_WASH_LAGS: usize = 3;

/// One lag of the wash on a chord: a term of Wagner's function in plane flow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LagNumbers<P: Scalar = f64> {
    /// Weight of the lag in the lift wash, dimensionless.
    pub weight: P,
    /// Rate per semichord travelled, dimensionless.
    pub rate: P,
}

/// Numbers of a surface's section and of its air. Of type `f64` they are constants; as duals they tell how loads
/// depend on them.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceNumbers<P: Scalar = f64> {
    /// Air density, kg/m3.
    pub density: P,
    /// Lift slope of the section, 1/rad.
    pub section_slope: P,
    /// Incidence of the chord at which the section bears no lift, rad.
    pub zero_lift_angle: P,
    /// Drag coefficient along the wind at no incidence.
    pub cd0: P,
    /// Drag coefficient broadside on.
    pub cd90: P,
    /// Incidence at which the attached lift is largest, rad.
    pub stall_angle: P,
    /// Dimensionless leading-edge suction parameter A0 beyond which the edge holds no more suction.
    pub critical_suction: P,
    /// The air that the sections carry, in parts of what potential flow says: 1 unless it is fitted.
    pub added_mass_scale: P,
    /// The lags of the wash; what weight they leave acts at once.
    pub lags: ArrayVec<LagNumbers<P>, MAX_WASH_LAGS>,
    /// The membrane, where it is one.
    pub membrane: Option<MembraneNumbers<P>>,
    /// The flap, where there is one.
    pub flap: Option<FlapNumbers<P>>,
    /// The outline, where the model was laid on one.
    pub outline: Option<Planform<P>>,
    /// Arc lengths from the root at which strips or cells end at hinges, m.
    pub hinges: Vec<P>,
    /// How far beyond each hinge the surface passes over to the outer side, m: strips end there too; 0, or none, at once.
    pub webs: Vec<P>,
}

impl<P: Scalar> SurfaceNumbers<P> {
    /// Arc lengths from the root at which strips end: hinges, and the ends of what passes over beyond them, m.
    pub(crate) fn bounds(&self) -> Vec<P> {
        let ends = self.hinges.iter().zip(&self.webs).filter(|(_, web)| !web.is_zero());
        self.hinges.iter().copied().chain(ends.map(|(hinge, web)| *hinge + *web)).collect()
    }

    /// Profile drag.
    #[inline]
    pub fn drag(&self) -> ProfileDrag<P> {
        ProfileDrag { cd0: self.cd0, cd90: self.cd90 }
    }
}

/// Density of the air.
pub const DENSITY: DeclaredQuantity = DeclaredQuantity::within("kg/m3", Range::POSITIVE, 1e-3, 1e4);
// Of the section a fit may find effective numbers that no plate has: what keys give is narrower.
const SLOPE: DeclaredQuantity = DeclaredQuantity::within("1/rad", Range::between(0.1, 20.0), 0.1, 20.0);
const ZERO_LIFT: DeclaredQuantity = DeclaredQuantity::free("rad");
const CD0: DeclaredQuantity = DeclaredQuantity::within("", law::CD0.range, 0.0, 2.0);
const CD90: DeclaredQuantity = DeclaredQuantity::within("", law::CD90.range, 0.0, 10.0);
const STALL: DeclaredQuantity = DeclaredQuantity::within("rad", Range::inside(0.0, FRAC_PI_2), 0.01, 1.5);
const SUCTION: DeclaredQuantity = DeclaredQuantity::within("", Range::over(0.0, 3.0), 1e-3, 3.0);
const CARRIED: DeclaredQuantity = DeclaredQuantity::within("", Range::NOT_NEGATIVE, 0.0, 10.0);
const LAG: DeclaredQuantity = DeclaredQuantity::free("");

/// A length over which a surface passes over, m: where there is none, that is no number.
pub fn walk_web<P: Scalar, Q: Scalar>(at: &mut Walk<'_, P, Q>, web: P) -> Q {
    if web.is_zero() { at.fixed(web) } else { at.number("web_m", &COORDINATE, web) }
}

impl<P: Scalar> Parameters<P> for SurfaceNumbers<P> {
    type In<Q: Scalar> = SurfaceNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> SurfaceNumbers<Q> {
        SurfaceNumbers {
            density: at.apart(AIR_DENSITY, &DENSITY, self.density),
            section_slope: at.number("lift_slope_per_rad", &SLOPE, self.section_slope),
            zero_lift_angle: at.number("zero_lift_angle_rad", &ZERO_LIFT, self.zero_lift_angle),
            cd0: at.number("cd0", &CD0, self.cd0),
            cd90: at.number("cd90", &CD90, self.cd90),
            stall_angle: at.number("stall_angle_rad", &STALL, self.stall_angle),
            critical_suction: at.number("critical_suction", &SUCTION, self.critical_suction),
            added_mass_scale: at.number("added_mass_scale", &CARRIED, self.added_mass_scale),
            lags: at
                .list(("lags", ""), &self.lags, |at, lag| LagNumbers {
                    weight: at.number("weight", &LAG, lag.weight),
                    rate: at.number("rate", &LAG, lag.rate),
                })
                .into_iter()
                .collect(),
            membrane: self.membrane.as_ref().map(|skin| at.within("membrane", |at| skin.walk(at))),
            flap: self.flap.as_ref().map(|flap| at.within("flap", |at| flap.walk(at))),
            outline: self.outline.as_ref().map(|outline| outline.walk(at)),
            hinges: (1..)
                .zip(&self.hinges)
                .map(|(i, hinge)| {
                    at.item("panels", "panels", i, |at| at.number("from_arc_m", &COORDINATE, *hinge))
                })
                .collect(),
            webs: (1..)
                .zip(&self.webs)
                .map(|web| at.item("panels", "panels", web.0, |at| walk_web(at, *web.1)))
                .collect(),
        }
    }
}
