//! The plane over which a tethered wing moves.

use super::Tether;
use wingbeat_aero::{Aero, Ground, Loads, Preset, Surfaces};
use wingbeat_math::{Error, Vec3};

/// A plane that the air does not cross, below the wing or above it, with the model of the wing that feels its own mirror image.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Its height, m in W.
    pub height_m: f64,
    surfaces: Surfaces,
}

impl Plane {
    /// A plane at the height `height_m` m beneath a wing with the model `aero`.
    pub fn new(aero: &Aero, height_m: f64) -> Self {
        Self { height_m, surfaces: Surfaces::from(aero.clone()).over_ground() }
    }

    /// The plane for the model.
    fn ground(&self) -> Ground<f64> {
        Ground { normal: Vec3::new(0.0, 0.0, 1.0), offset: self.height_m }
    }
}

impl Tether {
    /// Number of states of the air.
    pub(super) fn air_states(&self) -> usize {
        self.ground.as_ref().map_or(self.aero.states(), |plane| plane.surfaces.states())
    }

    /// State rates and loads in W about W's origin, of a rigid wing.
    pub fn evaluate(&self, t: f64, x: &[f64], dx: &mut [f64], loads: &mut Loads<f64>) {
        let all = self.sections(t);
        let sections = &all[..self.aero.arcs().len()];
        match &self.ground {
            None => self.aero.evaluate_in_numbers(sections, self.wind, x, dx, loads),
            Some(plane) => {
                plane.surfaces.evaluate_over(Some(plane.ground()), sections, self.wind, x, dx, loads);
            }
        }
    }

    /// What is asked of a wing over a plane.
    pub(super) fn check_ground(&self) -> Result<(), Error> {
        let Some(plane) = &self.ground else { return Ok(()) };
        let refused = |allowed: &str| Err(Error::invalid("air.ground_m", plane.height_m, allowed));
        if !plane.height_m.is_finite() {
            return refused("a finite height");
        }
        if self.aero.preset() != Preset::Full {
            return refused("none where the preset is not \"full\", which alone feels it");
        }
        if self.wind[2] != 0.0 {
            return refused(
                "none in a wind that crosses it: pitch the wing by body.nose_up_deg, not the wind by incidence_deg",
            );
        }
        match self.spar {
            Some(_) => refused("none beneath a wing with a spar"),
            None => Ok(()),
        }
    }

    /// Least distance of the edges of the wing from the plane in the last cycle, on the side on which its middle begins, m; negative
    /// where something passes through.
    pub fn ground_distance(&self) -> Option<f64> {
        let plane = self.ground.as_ref()?;
        let arcs = self.aero.arcs().len();
        let heights = |t: f64| self.sections(t).into_iter().take(arcs).flat_map(|s| [s.le[2], s.te[2]]);
        let above = self.motion.body(0.0).frame().origin[2].x >= plane.height_m;
        let side = if above { 1.0 } else { -1.0 };
        self.instants().flat_map(heights).map(|z| (z - plane.height_m) * side).reduce(f64::min)
    }
}
