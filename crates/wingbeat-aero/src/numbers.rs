//! The numbers of a surface that may carry derivatives.

use super::{Planform, ProfileDrag};
use arrayvec::ArrayVec;
use wingbeat_math::Scalar;

/// Most lags of the wash on a chord.
pub const MAX_WASH_LAGS: usize = 3;

/// One lag of the wash on a chord: a term of Wagner's function in plane flow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LagNumbers<P: Scalar = f64> {
    /// Weight in the lift wash.
    pub weight: P,
    /// Rate per semichord travelled.
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
    /// Leading-edge suction parameter A0 beyond which the edge holds no more suction.
    pub critical_suction: P,
    /// The air that the sections carry, in parts of what potential flow says: 1 unless it is fitted.
    pub added_mass_scale: P,
    /// The lags of the wash; what weight they leave acts at once.
    pub lags: ArrayVec<LagNumbers<P>, MAX_WASH_LAGS>,
    /// The outline, where the model was laid on one.
    pub outline: Option<Planform<P>>,
    /// Arc lengths from the root at which strips or cells end at hinges, m.
    pub hinges: Vec<P>,
}

impl<P: Scalar> SurfaceNumbers<P> {
    /// Profile drag.
    #[inline]
    pub fn drag(&self) -> ProfileDrag<P> {
        ProfileDrag { cd0: self.cd0, cd90: self.cd90 }
    }

    /// The same numbers in another type, `f` of each.
    pub fn map<Q: Scalar>(&self, f: impl Fn(P) -> Q) -> SurfaceNumbers<Q> {
        let lag = |lag: &LagNumbers<P>| LagNumbers { weight: f(lag.weight), rate: f(lag.rate) };
        SurfaceNumbers {
            density: f(self.density),
            section_slope: f(self.section_slope),
            zero_lift_angle: f(self.zero_lift_angle),
            cd0: f(self.cd0),
            cd90: f(self.cd90),
            stall_angle: f(self.stall_angle),
            critical_suction: f(self.critical_suction),
            added_mass_scale: f(self.added_mass_scale),
            lags: self.lags.iter().map(lag).collect(),
            outline: self.outline.as_ref().map(|outline| outline.map(&f)),
            hinges: self.hinges.iter().map(|hinge| f(*hinge)).collect(),
        }
    }

    /// All of them by name, as [`Robot::numbers`](wingbeat_robot::Robot::numbers) calls them behind the surface's.
    pub fn by_name(&mut self) -> Vec<(String, &mut P)> {
        let section = [
            ("density_kg_m3", &mut self.density),
            ("section_slope", &mut self.section_slope),
            ("zero_lift_angle_rad", &mut self.zero_lift_angle),
            ("cd0", &mut self.cd0),
            ("cd90", &mut self.cd90),
            ("stall_angle_rad", &mut self.stall_angle),
            ("critical_suction", &mut self.critical_suction),
            ("added_mass_scale", &mut self.added_mass_scale),
        ];
        let lags = self.lags.iter_mut().enumerate().flat_map(|(k, LagNumbers { weight, rate })| {
            [(format!("lags[{k}].weight"), weight), (format!("lags[{k}].rate"), rate)]
        });
        let outline = self.outline.iter_mut().flat_map(Planform::by_name);
        let hinges = self.hinges.iter_mut().enumerate();
        let hinges = hinges.map(|(i, hinge)| (format!("panels[{}].from_arc_m", i + 1), hinge));
        let section = section.into_iter().map(|(key, number)| (key.to_string(), number));
        section.chain(lags).chain(outline).chain(hinges).collect()
    }
}
