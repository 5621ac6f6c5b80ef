//! The numbers of a surface that may carry derivatives.

use super::ProfileDrag;
use crate::math::Scalar;

/// Numbers of a surface's section and of its air. Of type `f64` they are constants; as duals they tell how loads
/// depend on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceNumbers<P: Scalar = f64> {
    /// Air density, kg/m3.
    pub density: P,
    /// Lift slope of the section, 1/rad.
    pub section_slope: P,
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
}

impl<P: Scalar> SurfaceNumbers<P> {
    /// Profile drag.
    pub fn drag(&self) -> ProfileDrag<P> {
        ProfileDrag { cd0: self.cd0, cd90: self.cd90 }
    }

    /// All of them by name, as [`Robot::numbers`](crate::robot::Robot::numbers) calls them behind the surface's.
    pub fn by_name(&mut self) -> [(&'static str, &mut P); 7] {
        [
            ("density_kg_m3", &mut self.density),
            ("section_slope", &mut self.section_slope),
            ("cd0", &mut self.cd0),
            ("cd90", &mut self.cd90),
            ("stall_angle_rad", &mut self.stall_angle),
            ("critical_suction", &mut self.critical_suction),
            ("added_mass_scale", &mut self.added_mass_scale),
        ]
    }
}
