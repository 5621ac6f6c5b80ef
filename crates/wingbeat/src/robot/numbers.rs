//! The physical numbers of a robot, which may carry derivatives.

use super::mechanism::SIDES;
use super::{PlacementNumbers, Robot};
use crate::Error;
use crate::aero::SurfaceNumbers;
use crate::body::{BodyNumbers, FourierSeries, JointNumbers, Linkage, LinkageDimensions, Motor, Response};
use crate::math::{Dual, Scalar, Vec3};
use crate::names::one_of;

/// Spring and damper of a joint whose coordinate is a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpringNumbers<P: Scalar = f64> {
    /// N m/rad, or N/m of a sliding joint.
    pub stiffness: P,
    /// N m s/rad, or N s/m.
    pub damping: P,
    /// Coordinate without effort, rad or m.
    pub rest: P,
    /// Its stops.
    pub stops: Option<StopNumbers<P>>,
}

/// Stops of a joint whose coordinate is a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StopNumbers<P: Scalar = f64> {
    /// Coordinate of the lower stop, rad or m.
    pub low: P,
    /// Of the upper one.
    pub high: P,
    /// N m/rad, or N/m of a sliding joint.
    pub stiffness: P,
}

/// Share of the range over which the corner of a stop is rounded off.
const STOP_ROUNDING: f64 = 0.01;

impl<P: Scalar> StopNumbers<P> {
    /// Width over which the corners are rounded off.
    pub(super) fn width(&self) -> P {
        (self.high - self.low) * STOP_ROUNDING
    }

    fn map<Q: Scalar>(&self, f: impl Fn(P) -> Q) -> StopNumbers<Q> {
        StopNumbers { low: f(self.low), high: f(self.high), stiffness: f(self.stiffness) }
    }
}

/// Numbers of a robot that are varied together: their derivatives fill one register of the processor. An evaluation under
/// law `lev` then takes 2 to 3 MB of stack; [`parallel`](crate::parallel) gives its threads more.
pub const TOGETHER: usize = 4;
/// A number with the derivatives by them.
pub type Varying = Dual<TOGETHER>;

/// Numbers of a robot: masses, springs, sections, air, drive. As duals they tell how everything that the robot
/// does depends on them: [`Robot::varied`].
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers<P: Scalar = f64> {
    /// Of the body, then of the links.
    pub bodies: Vec<BodyNumbers<P>>,
    /// Places of the joints.
    pub places: Vec<JointNumbers<P>>,
    /// Series of the joints that have one, and their lags, rad.
    pub series: Vec<(FourierSeries<P>, P)>,
    /// Dimensions of the linkage, where there is one.
    pub linkage: Option<LinkageDimensions<P>>,
    /// Response of the structure's elements.
    pub response: Response<P>,
    /// Of the elastic and free joints, in the order of their coordinates.
    pub springs: Vec<SpringNumbers<P>>,
    /// Of the surfaces.
    pub surfaces: Vec<SurfaceNumbers<P>>,
    /// Of their places on the links.
    pub placements: Vec<PlacementNumbers<P>>,
    /// Drag area of the body along its axes, m2.
    pub drag_area: Vec3<P>,
    /// Density of the air that the body's drag takes, kg/m3; each surface has its own.
    pub density: P,
    /// Rate of the gait's phase, rad/s.
    pub phase_rate: P,
    /// Phase of the gait at t = 0, rad.
    pub phase_start: P,
    /// The motor, where one turns the crank.
    pub motor: Option<Motor<P>>,
}

impl<P: Scalar> Numbers<P> {
    /// The same numbers in another type, `f` of each.
    pub(super) fn map<Q: Scalar>(&self, f: impl Fn(P) -> Q + Copy) -> Numbers<Q> {
        let vector = |v: Vec3<P>| v.each(f);
        let body = |b: &BodyNumbers<P>| BodyNumbers {
            mass: f(b.mass),
            com: vector(b.com),
            moments: vector(b.moments),
        };
        let spring = |s: &SpringNumbers<P>| SpringNumbers {
            stiffness: f(s.stiffness),
            damping: f(s.damping),
            rest: f(s.rest),
            stops: s.stops.map(|stops| stops.map(f)),
        };
        let motor = |m: &Motor<P>| Motor {
            stall_torque: f(m.stall_torque),
            no_load_speed: f(m.no_load_speed),
            gear_ratio: f(m.gear_ratio),
            efficiency: f(m.efficiency),
            inertia: f(m.inertia),
        };
        let place = |p: &JointNumbers<P>| JointNumbers { origin: vector(p.origin), turn: vector(p.turn) };
        Numbers {
            bodies: self.bodies.iter().map(body).collect(),
            places: self.places.iter().map(place).collect(),
            series: self.series.iter().map(|(series, lag)| (series.map(f), f(*lag))).collect(),
            linkage: self.linkage.as_ref().map(|dimensions| dimensions.map(f)),
            response: self.response.map(f),
            springs: self.springs.iter().map(spring).collect(),
            surfaces: self.surfaces.iter().map(|surface| surface.map(f)).collect(),
            placements: self.placements.iter().map(|placement| placement.map(f)).collect(),
            drag_area: vector(self.drag_area),
            density: f(self.density),
            phase_rate: f(self.phase_rate),
            phase_start: f(self.phase_start),
            motor: self.motor.as_ref().map(motor),
        }
    }

    /// All numbers with their names, those of links and surfaces by the names that `robot` gives them.
    fn by_name<'a>(&'a mut self, robot: &Robot) -> Vec<(String, &'a mut P)> {
        let mut all: Vec<(String, &mut P)> = Vec::new();
        let (tree, joints) = (robot.tree(), &robot.mechanism.coordinates);
        for (name, body) in robot.body_names().zip(&mut self.bodies) {
            all.push((format!("{name}.mass_kg"), &mut body.mass));
            all.extend(along(&name, "com_m", &mut body.com));
            all.extend(along(&name, "inertia_kg_m2", &mut body.moments));
        }
        for (link, place) in self.places.iter_mut().enumerate() {
            let name = format!("links.{}", tree.name(link));
            all.extend(along(&name, "origin_m", &mut place.origin));
            all.extend(along(&name, "turn_rad", &mut place.turn));
        }
        for ((joint, ..), (series, lag)) in robot.mechanism.series().zip(&mut self.series) {
            let name = format!("links.{}.series", tree.name(joint));
            all.push((format!("{name}.lag_rad"), lag));
            all.extend(series.by_name().into_iter().map(|(key, number)| (format!("{name}.{key}"), number)));
        }
        if let Some(dimensions) = &mut self.linkage {
            let named = dimensions.by_name().into_iter();
            all.extend(named.map(|(key, number)| (format!("linkage.{key}"), number)));
        }
        let response = self.response.by_name().into_iter();
        all.extend(response.map(|(key, number)| (format!("structure.{key}"), number)));
        for (&joint, spring) in joints.iter().zip(&mut self.springs) {
            let key = |key: &str| format!("links.{}.elastic.{key}", tree.name(joint));
            all.push((key("stiffness"), &mut spring.stiffness));
            all.push((key("damping"), &mut spring.damping));
            all.push((key("rest"), &mut spring.rest));
            if let Some(StopNumbers { low, high, stiffness }) = &mut spring.stops {
                all.push((key("stops.low"), low));
                all.push((key("stops.high"), high));
                all.push((key("stops.stiffness"), stiffness));
            }
        }
        for ((name, _), surface) in robot.surfaces().zip(&mut self.surfaces) {
            for (key, value) in surface.by_name() {
                let air = key == "density_kg_m3";
                all.push((if air { format!("air.{key}") } else { format!("surfaces.{name}.{key}") }, value));
            }
        }
        for ((name, _), placement) in robot.surfaces().zip(&mut self.placements) {
            let named = placement.by_name().into_iter();
            all.extend(named.map(|(key, number)| (format!("surfaces.{name}.{key}"), number)));
        }
        all.extend(along("body", "drag_area_m2", &mut self.drag_area));
        all.push(("air.density_kg_m3".into(), &mut self.density));
        all.push(("gait.phase_rate_rad_s".into(), &mut self.phase_rate));
        all.push(("gait.phase_rad".into(), &mut self.phase_start));
        if let Some(motor) = &mut self.motor {
            all.push(("motor.stall_torque_n_m".into(), &mut motor.stall_torque));
            all.push(("motor.no_load_speed_rad_s".into(), &mut motor.no_load_speed));
            all.push(("motor.gear_ratio".into(), &mut motor.gear_ratio));
            all.push(("motor.efficiency".into(), &mut motor.efficiency));
            all.push(("motor.inertia_kg_m2".into(), &mut motor.inertia));
        }
        all
    }
}

/// The components of a vector by name.
fn along<'a, P: Scalar>(
    of: &str,
    key: &str,
    vector: &'a mut Vec3<P>,
) -> impl Iterator<Item = (String, &'a mut P)> {
    let name = format!("{of}.{key}");
    vector.0.iter_mut().enumerate().map(move |(i, value)| (format!("{name}[{i}]"), value))
}

/// What of the value at `key` the number called `name` takes: all of it where the key is its name or, without the
/// side, that of its mirrored pair; less than nothing where the image has the other sign.
pub(crate) fn share(key: &str, name: &str) -> Option<f64> {
    if key == name {
        return Some(1.0);
    }
    let link = name.strip_prefix("links.")?.split('.').next()?;
    let (side, pair) = SIDES.iter().enumerate().find_map(|(i, side)| Some((i, link.strip_suffix(side)?)))?;
    if key != name.replacen(link, pair, 1) {
        return None;
    }
    // Of polar vectors the part across the plane of symmetry changes sign, of turns those in it.
    let turned = ["com_m[1]", "origin_m[1]", "turn_rad[0]", "turn_rad[2]"];
    Some(if side == 1 && turned.iter().any(|end| name.ends_with(end)) { -1.0 } else { 1.0 })
}

impl<P: Scalar> Robot<P> {
    /// The numbers that may carry derivatives.
    pub fn numbers(&self) -> Numbers<P> {
        Numbers {
            bodies: self.mechanism.tree.numbers(),
            places: self.mechanism.tree.places(),
            series: self.mechanism.series().map(|(_, series, lag)| (series.clone(), lag)).collect(),
            linkage: self.mechanism.linkage.as_ref().map(|linkage| linkage.dimensions().clone()),
            response: self.response.clone(),
            springs: self.mechanism.springs().map(|spring| spring.numbers).collect(),
            surfaces: self.covering.aero.surfaces().iter().map(|s| s.aero().numbers().clone()).collect(),
            placements: self.covering.placements.clone(),
            drag_area: self.drag_area,
            density: self.density,
            phase_rate: self.phase_rate,
            phase_start: self.phase_start,
            motor: self.motor,
        }
    }
}

impl Robot {
    /// What the bodies are called: the central one, then the links.
    pub(super) fn body_names(&self) -> impl Iterator<Item = String> {
        let link = |link: usize| format!("links.{}", self.tree().name(link));
        std::iter::once("body".to_string()).chain((0..self.tree().links()).map(link))
    }

    /// Names and values of the numbers that may carry derivatives: `links.twist_left.mass_kg`,
    /// `surfaces.wing.cd0`, `air.density_kg_m3`. Several numbers may share one name.
    pub fn named_numbers(&self) -> Vec<(String, f64)> {
        self.numbers().by_name(self).into_iter().map(|(name, value)| (name, *value)).collect()
    }

    /// The same robot with other numbers, which may carry derivatives. What has no mass keeps none.
    ///
    /// # Errors
    /// [`Error::Invalid`] when strips or nodes do not fit an outline.
    ///
    /// # Panics
    /// When there are not as many as [`numbers`](Self::numbers) gives.
    pub fn with<P: Scalar>(&self, numbers: &Numbers<P>) -> Result<Robot<P>, Error> {
        let Numbers { surfaces, placements, .. } = numbers;
        Ok(Robot {
            mechanism: self.mechanism.with(numbers),
            phase_rate: numbers.phase_rate,
            phase_start: numbers.phase_start,
            motor: numbers.motor,
            response: numbers.response.clone(),
            strokes: self.strokes.clone(),
            elements: self.elements.clone(),
            thrusters: self.thrusters.clone(),
            covering: self.covering.with(surfaces, placements, &self.carriers)?,
            clearances: self.clearances.clone(),
            carriers: self.carriers.clone(),
            drag_area: numbers.drag_area,
            density: numbers.density,
            wind: self.wind.map(P::from),
            residual: self.residual.clone(),
            layout: self.layout,
            states: self.states.clone(),
            inputs: self.inputs.clone(),
        })
    }

    /// The robot with the numbers called `keys` as variables: what it computes carries the derivatives by them, in
    /// their order. A key without the side of a mirrored pair stands for both links, which stay each other's image.
    /// Take many numbers a few at a time, as [`in_batches`](Self::in_batches) does: an evaluation holds 1 + N numbers
    /// for every one of its own on the stack, and 14 at once outgrow a thread's 2 MiB.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the names that there are when one is unknown.
    pub fn varied<const N: usize>(&self, keys: [&str; N]) -> Result<Robot<Dual<N>>, Error> {
        self.varied_by(keys.map(Some))
    }

    /// The same where a variable without a key moves nothing of the robot.
    fn varied_by<const N: usize>(&self, keys: [Option<&str>; N]) -> Result<Robot<Dual<N>>, Error> {
        let mut values = self.numbers();
        let mut numbers = values.map(Dual::<N>::constant);
        let values = values.by_name(self);
        check(keys.into_iter().flatten(), &values)?;
        for (name, number) in numbers.by_name(self) {
            for (variable, key) in number.eps.iter_mut().zip(keys) {
                *variable = key.and_then(|key| share(key, &name)).unwrap_or(0.0);
            }
        }
        self.with(&numbers)
    }

    /// `work` on the robot with [`TOGETHER`] of the `keys` as variables after another, for as many as there are; keys that
    /// `foreign` knows are no numbers of the robot, and leave it as it is. `work` gets the robot and the keys of its variables.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the names that there are when one is unknown.
    pub fn in_batches<R>(
        &self,
        keys: &[&str],
        foreign: impl Fn(&str) -> bool,
        mut work: impl FnMut(Robot<Varying>, &[&str]) -> R,
    ) -> Result<Vec<R>, Error> {
        let batch = |keys: &[&str]| -> Result<R, Error> {
            let variables = std::array::from_fn(|k| keys.get(k).copied().filter(|key| !foreign(key)));
            Ok(work(self.varied_by(variables)?, keys))
        };
        keys.chunks(TOGETHER).map(batch).collect()
    }

    /// The robot's numbers, those called by the keys at these values; keys as for [`varied`](Self::varied).
    ///
    /// # Errors
    /// [`Error::Invalid`] with the names that there are when one is unknown. Values are not checked.
    pub fn given(&self, to: &[(&str, f64)]) -> Result<Numbers, Error> {
        let mut numbers = self.numbers();
        let mut named = numbers.by_name(self);
        check(to.iter().map(|(key, _)| *key), &named)?;
        for (name, number) in &mut named {
            for (key, value) in to {
                if let Some(share) = share(key, name) {
                    **number = share * value;
                }
            }
        }
        Ok(numbers)
    }

    /// The robot with the numbers called by the keys at these values; keys as for [`varied`](Self::varied).
    ///
    /// # Errors
    /// [`Error::Invalid`] with the names that there are when one is unknown, or with what no robot has:
    /// [`renumbered`](Self::renumbered).
    pub fn adjusted(&self, to: &[(&str, f64)]) -> Result<Self, Error> {
        self.renumbered(&self.given(to)?)
    }

    /// The robot with other numbers, held against what a robot can have.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the name of a number that no robot has.
    pub fn renumbered(&self, numbers: &Numbers) -> Result<Self, Error> {
        self.check_numbers(numbers)?;
        let mut robot = self.with(numbers)?;
        if let Some(dimensions) =
            numbers.linkage.as_ref().filter(|_| numbers.linkage != self.numbers().linkage)
        {
            let linkage = Linkage::new(dimensions.clone()).map_err(|e| e.within("linkage"))?;
            robot.mechanism.linkage = Some(Box::new(linkage));
        }
        Ok(robot)
    }
}

/// Lowest and highest value that a number may be given, by the end of its name. *Choices*, wide of any robot: they keep a fit
/// from numbers without meaning.
const BOUNDS: [(&str, [f64; 2]); 14] = [
    ("mass_kg", [0.0, 1e3]),
    ("density_kg_m3", [1e-3, 1e4]),
    ("section_slope", [0.1, 20.0]),
    ("cd0", [0.0, 2.0]),
    ("cd90", [0.0, 10.0]),
    ("stall_angle_rad", [0.01, 1.5]),
    ("critical_suction", [1e-3, 3.0]),
    ("added_mass_scale", [0.0, 10.0]),
    ("stiffness", [0.0, 1e6]),
    ("damping", [0.0, 1e6]),
    ("efficiency", [1e-3, 1.0]),
    ("shift_m[", [-0.1, 0.1]),
    ("turn_rad[", [-0.5, 0.5]),
    ("ripple_rad[", [-0.3, 0.3]),
];

/// Lowest and highest value that the number called `name` may be given.
pub fn bounds(name: &str) -> [f64; 2] {
    let ends = |end: &str| if end.ends_with('[') { name.contains(end) } else { name.ends_with(end) };
    let inertia = name.contains("inertia_kg_m2") || name.contains("drag_area_m2");
    let given = BOUNDS.iter().find(|(end, _)| ends(end)).map(|(_, bounds)| *bounds);
    given.unwrap_or(if inertia { [0.0, 1e6] } else { [-1e6, 1e6] })
}

/// Refuses keys that name nothing.
fn check<'a>(keys: impl IntoIterator<Item = &'a str>, values: &[(String, &mut f64)]) -> Result<(), Error> {
    let unknown = |key: &&str| !values.iter().any(|(name, _)| share(key, name).is_some());
    let Some(unknown) = keys.into_iter().find(unknown) else { return Ok(()) };
    let known: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).collect();
    Err(Error::invalid("numbers", format!("{unknown:?}"), one_of(unknown, &known)))
}
