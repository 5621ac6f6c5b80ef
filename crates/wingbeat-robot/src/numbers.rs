//! The physical numbers of a robot, which may carry derivatives.

use super::loaded::INERTIA;
use super::mechanism::SIDES;
use super::{PlacementNumbers, Robot, spar};
use crate::CrankMotor;
use crate::body::{BodyNumbers, FourierSeries, JointNumbers, Linkage, LinkageDimensions, Response};
use wingbeat_aero::{AIR_DENSITY, DENSITY, SurfaceNumbers};
use wingbeat_math::Error;
use wingbeat_math::names::one_of;
use wingbeat_math::range::Range;
use wingbeat_math::{Declared, DeclaredQuantity, Dual, Meets, NamedNumber, Parameters, Scalar, Vec3, Walk};

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
    /// Of the upper one, rad or m.
    pub high: P,
    /// N m/rad, or N/m of a sliding joint.
    pub stiffness: P,
}

/// Share of the range over which the corner of a stop is rounded off.
const STOP_ROUNDING: f64 = 0.01;

impl<P: Scalar> StopNumbers<P> {
    /// Half the width over which the corners are rounded off.
    fn width(&self) -> P {
        (self.high - self.low) * STOP_ROUNDING
    }

    /// How far `q` lies beyond them, less than nothing below the lower one: s(q - high) - s(low - q) of `robot.joint_spring`.
    pub(super) fn beyond<S: Scalar + Meets<P>>(&self, q: S) -> S {
        let (zero, width) = (S::ZERO, S::from(self.width()));
        let past = |x: S| {
            let share = x / (width * 2.0) + 0.5;
            let share = share.if_below(zero, zero, share);
            let share = share.if_below(S::ONE, share, S::ONE);
            let corner = share * share * share * (S::from(1.0) - share * 0.5) * (width * 2.0);
            corner + (x - width).if_below(zero, zero, x - width)
        };
        past(q - self.high) - past(-q + self.low)
    }
}

impl StopNumbers {
    /// Energy that they store at the coordinate `q`, J.
    pub(super) fn energy(&self, q: f64) -> f64 {
        let width = self.width();
        let past = |x: f64| {
            let share = (0.5 * x / width + 0.5).clamp(0.0, 1.0);
            let straight = x.max(width);
            width * width * share.powi(4) * (1.0 - 0.4 * share) + 0.5 * (straight * straight - width * width)
        };
        self.stiffness * (past(q - self.high) + past(self.low - q))
    }
}

/// Coordinate of a joint.
const COORDINATE: DeclaredQuantity = DeclaredQuantity::free("rad");
/// Stiffness of a spring.
pub(super) const STIFFNESS: DeclaredQuantity =
    DeclaredQuantity::within("N m/rad", Range::NOT_NEGATIVE, 0.0, 1e6);
/// Damping of a joint.
pub(super) const DAMPING: DeclaredQuantity =
    DeclaredQuantity::within("N m s/rad", Range::NOT_NEGATIVE, 0.0, 1e6);
/// Stiffness of a stop.
pub(super) const STOP_STIFFNESS: DeclaredQuantity = DeclaredQuantity { range: Range::POSITIVE, ..STIFFNESS };
/// Drag area of the body along an axis.
pub(super) const DRAG_AREA: DeclaredQuantity = DeclaredQuantity::within("m2", Range::NOT_NEGATIVE, 0.0, 1e6);
/// Rate of the gait's phase.
const PHASE_RATE: DeclaredQuantity = DeclaredQuantity::free("rad/s");
/// Phase of the gait.
const PHASE: DeclaredQuantity = DeclaredQuantity::free("rad");

impl<P: Scalar> Parameters<P> for StopNumbers<P> {
    type In<Q: Scalar> = StopNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> StopNumbers<Q> {
        StopNumbers {
            low: at.number("low", &COORDINATE, self.low),
            high: at.number("high", &COORDINATE, self.high),
            stiffness: at.number("stiffness", &STOP_STIFFNESS, self.stiffness),
        }
    }
}

impl<P: Scalar> Parameters<P> for SpringNumbers<P> {
    type In<Q: Scalar> = SpringNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> SpringNumbers<Q> {
        SpringNumbers {
            stiffness: at.number("stiffness", &STIFFNESS, self.stiffness),
            damping: at.number("damping", &DAMPING, self.damping),
            rest: at.number("rest", &COORDINATE, self.rest),
            stops: self.stops.as_ref().map(|stops| at.within("stops", |at| stops.walk(at))),
        }
    }
}

/// Numbers of a robot that are varied together: their derivatives fill one register of the processor. An evaluation under
/// law `lev` then takes 2 to 3 MB of stack; [`parallel`](wingbeat_math::parallel) gives its threads more.
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
    /// Springs on the pins of the linkage.
    pub pin_springs: Vec<SpringNumbers<P>>,
    /// Response of the structure's elements.
    pub response: Response<P>,
    /// Inertias of the elements that bear what their joints bear, kg m2 or kg.
    pub inertias: Vec<P>,
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
    pub motor: Option<CrankMotor<P>>,
}

impl<P: Scalar> Parameters<P> for Numbers<P> {
    type In<Q: Scalar> = Numbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> Numbers<Q> {
        let body = |at: &mut Walk<'_, P, Q>, (i, body): (usize, &BodyNumbers<P>)| match i {
            0 => at.within("body", |at| body.walk(at)),
            link => at.item("links", "links", link - 1, |at| body.walk(at)),
        };
        let surface = |at: &mut Walk<'_, P, Q>, surface: &SurfaceNumbers<P>| surface.walk(at);
        let placement = |at: &mut Walk<'_, P, Q>, placement: &PlacementNumbers<P>| placement.walk(at);
        Numbers {
            bodies: self.bodies.iter().enumerate().map(|of| body(at, of)).collect(),
            places: at.list(("links", "links"), &self.places, |at, place| place.walk(at)),
            series: at.list(("links", "series"), &self.series, |at, (series, lag)| {
                at.within("driven", |at| (series.walk(at), at.number("lag_rad", &PHASE, *lag)))
            }),
            linkage: self.linkage.as_ref().map(|linkage| at.within("linkage", |at| linkage.walk(at))),
            pin_springs: at.within("linkage", |at| {
                at.list(("springs", "pins"), &self.pin_springs, |at, spring| spring.walk(at))
            }),
            response: at.within("structure", |at| self.response.walk(at)),
            inertias: at.within("structure", |at| {
                at.list(("elements", "loaded"), &self.inertias, |at, of| at.number("inertia", &INERTIA, *of))
            }),
            springs: at.list(("links", "springs"), &self.springs, |at, spring| {
                at.within("elastic", |at| spring.walk(at))
            }),
            surfaces: at.list(("surfaces", "surfaces"), &self.surfaces, surface),
            placements: at.list(("surfaces", "surfaces"), &self.placements, placement),
            drag_area: at.within("body", |at| at.vector("drag_area_m2", &[DRAG_AREA; 3], self.drag_area)),
            density: at.apart(AIR_DENSITY, &DENSITY, self.density),
            phase_rate: at.number("gait.phase_rate_rad_s", &PHASE_RATE, self.phase_rate),
            phase_start: at.number("gait.phase_rad", &PHASE, self.phase_start),
            motor: self.motor.as_ref().map(|motor| motor.walk(at)),
        }
    }
}

/// Whether the value at `key` is that of the number called `name`: its name, or, without the side, that of its mirrored pair. True
/// within where the number is that of the image.
pub fn stands_for(key: &str, name: &str) -> Option<bool> {
    if key == name {
        return Some(false);
    }
    let link = name.strip_prefix("links.")?.split('.').next()?;
    let (side, pair) = SIDES.iter().enumerate().find_map(|(i, side)| Some((i, link.strip_suffix(side)?)))?;
    (key == name.replacen(link, pair, 1)).then_some(side == 1)
}

/// What of the value at `key` a number takes: all of it where it is its own, less than nothing where the image has the other sign.
fn share(key: &str, number: Declared) -> Option<f64> {
    let image = stands_for(key, number.name)?;
    Some(if image && number.quantity.turned { -1.0 } else { 1.0 })
}

impl<P: Scalar> Robot<P> {
    /// The numbers that may carry derivatives.
    pub fn numbers(&self) -> Numbers<P> {
        Numbers {
            bodies: self.mechanism.tree.numbers(),
            places: self.mechanism.tree.places(),
            series: self.mechanism.series().map(|(_, series, lag)| (series.clone(), lag)).collect(),
            linkage: self.mechanism.linkage.as_ref().map(|linkage| linkage.dimensions().clone()),
            pin_springs: self.mechanism.pin_springs.iter().map(|of| of.spring.numbers).collect(),
            response: self.response.clone(),
            inertias: self.loaded.iter().map(|loaded| loaded.inertia).collect(),
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

    /// Makes all that gives way in `numbers` of this robot `factor` times (dimensionless) as stiff: springs of joints and pins, spars, flaps and membranes.
    /// Damping that is given as a time follows, as that of spars, flaps and membranes does; stops stay as they are.
    pub fn stiffen(&self, numbers: &mut Numbers, factor: f64) {
        let pieces: Vec<usize> = self.mechanism.pieces().collect();
        for (spring, joint) in numbers.springs.iter_mut().zip(&self.mechanism.coordinates) {
            spring.stiffness *= factor;
            if pieces.contains(joint) {
                spring.damping *= factor;
            }
        }
        numbers.pin_springs.iter_mut().for_each(|spring| spring.stiffness *= factor);
        for surface in &mut numbers.surfaces {
            surface.membrane.iter_mut().for_each(|skin| skin.stiffness *= factor);
            surface.flap.iter_mut().for_each(|flap| flap.stiffness *= factor);
        }
    }

    /// What an item of a list of numbers is called: what its file calls it.
    pub(super) fn label(&self, kind: &str, within: &str, place: usize) -> Option<&str> {
        let joint = |joint: usize| self.tree().name(joint);
        match kind {
            "links" => Some(joint(place)),
            "series" => self.mechanism.series().nth(place).map(|(of, ..)| joint(of)),
            "springs" => self.mechanism.coordinates.get(place).map(|of| joint(*of)),
            "surfaces" => self.covering.laid.get(place).map(|laid| laid.name.as_str()),
            "panels" => {
                let name = within.strip_prefix("surfaces.")?;
                self.covering.laid.iter().find(|laid| laid.name == name)?.panel(place)
            }
            "pins" => self.mechanism.pin_springs.get(place).map(|of| of.pin.name()),
            "loaded" => Some(self.elements.get(self.loaded.get(place)?.element)?.name.as_str()),
            "elements" => self.elements.get(place).map(|element| element.name.as_str()),
            "regulators" => {
                let name = self.inputs.get(place)?.name.as_str();
                Some(name.strip_prefix("command_").unwrap_or(name))
            }
            "states" => self.states.get(self.layout.structure + place).map(|state| state.name.as_str()),
            _ => None,
        }
    }

    /// The same for a walk.
    pub(super) fn labels(&self) -> impl Fn(&str, &str, usize) -> Option<String> {
        |kind, within, place| self.label(kind, within, place).map(str::to_owned)
    }

    /// The numbers that may carry derivatives, with their names and what is declared of them: `links.twist_left.mass_kg`,
    /// `surfaces.wing.cd0`, `air.density_kg_m3`. Several numbers may share one name.
    /// The numbers of spars, which stand for those of their springs, come last.
    pub fn parameters(&self) -> Vec<NamedNumber> {
        let mut all = self.numbers().named(&self.labels());
        all.extend(self.spar_parameters());
        all
    }

    /// Names and values of the same, in their declared units.
    pub fn named_numbers(&self) -> Vec<(String, f64)> {
        self.parameters().into_iter().map(|number| (number.name, number.value)).collect()
    }

    /// What of the value at `key` a number takes that is `value` now: of its own, of that of a pair, or of that of a spar.
    fn share(&self, key: &str, number: Declared, value: f64) -> Option<f64> {
        share(key, number).or_else(|| self.spar_share(key, number, value))
    }

    /// Numbers in another scalar: `f` of what is declared of each and its value, `plain` of those that are fixed.
    fn each_number<Q: Scalar>(
        &self,
        plain: impl Fn(f64) -> Q,
        f: impl FnMut(Declared, f64) -> Q,
    ) -> Numbers<Q> {
        self.numbers().map_named(&self.labels(), plain, f)
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
        let mechanism = self.mechanism.with(numbers);
        Ok(Robot {
            inertance: self.inertance.of(&mechanism),
            mechanism,
            phase_rate: numbers.phase_rate,
            phase_start: numbers.phase_start,
            strokes_per_cycle: self.strokes_per_cycle,
            motor: numbers.motor,
            response: numbers.response.clone(),
            loaded: self.loaded.iter().zip(&numbers.inertias).map(|(of, m)| of.with(*m)).collect(),
            strokes: self.strokes.clone(),
            elements: self.elements.clone(),
            moved: self.moved.clone(),
            thrusters: self.thrusters.clone(),
            covering: self.covering.with(surfaces, placements, &self.carriers)?,
            clearances: self.clearances.clone(),
            carriers: self.carriers.clone(),
            drag_area: numbers.drag_area,
            density: numbers.density,
            wind: self.wind.map(P::from),
            ground: self.ground,
            residual: self.residual.clone(),
            perch: self.perch,
            layout: self.layout,
            states: self.states.clone(),
            given: self.given.clone(),
            inputs: self.inputs.clone(),
        })
    }

    /// The robot with the numbers called `keys` as variables, at most [`TOGETHER`]: what it computes carries the derivatives by
    /// them, in their order. A key without the side of a mirrored pair stands for both links, which stay each other's image.
    /// [`in_batches`](Self::in_batches) takes as many as one likes: an evaluation holds a derivative by each variable for every
    /// number of its own on the stack, and 14 at once outgrow a thread's 2 MiB.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the names that there are when one is unknown, or when there are too many.
    pub fn varied(&self, keys: &[&str]) -> Result<Robot<Varying>, Error> {
        if keys.len() > TOGETHER {
            return Err(Error::invalid("numbers", keys.join(", "), format!("at most {TOGETHER} at once")));
        }
        self.varied_by(std::array::from_fn(|k| keys.get(k).copied()))
    }

    /// The same where a variable without a key moves nothing of the robot.
    fn varied_by(&self, keys: [Option<&str>; TOGETHER]) -> Result<Robot<Varying>, Error> {
        self.check_names(keys.into_iter().flatten())?;
        let numbers = self.each_number(Varying::constant, |number, value| {
            let eps = keys.map(|key| key.and_then(|key| self.share(key, number, value)).unwrap_or(0.0));
            Dual { re: value, eps }
        });
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

    /// The robot's numbers, those called by the keys at these values in their declared units; keys as for
    /// [`varied`](Self::varied).
    ///
    /// # Errors
    /// [`Error::Invalid`] with the names that there are when one is unknown, or as [`with`](Self::with). Values are not checked.
    pub fn given(&self, to: &[(&str, f64)]) -> Result<Numbers, Error> {
        self.check_names(to.iter().map(|(key, _)| *key))?;
        let (last, first): (Vec<_>, Vec<_>) = to.iter().partition(|(key, _)| spar::follows(key));
        let numbers = self.after(&first);
        if last.is_empty() { Ok(numbers) } else { Ok(self.with(&numbers)?.after(&last)) }
    }

    /// The robot's numbers, those called by the keys at these values.
    fn after(&self, to: &[(&str, f64)]) -> Numbers {
        let given = |number: Declared, own| {
            let of = |(key, value): &(&str, f64)| Some(self.share(key, number, own)? * value);
            to.iter().rev().find_map(of).unwrap_or(own)
        };
        self.each_number(|value| value, given)
    }

    /// The robot with the numbers called by the keys at these values in their declared units; keys as for
    /// [`varied`](Self::varied).
    ///
    /// # Errors
    /// [`Error::Invalid`] with the names that there are when one is unknown, or with what no robot has:
    /// [`renumbered`](Self::renumbered).
    pub fn adjusted(&self, to: &[(&str, f64)]) -> Result<Self, Error> {
        self.check_given(to)?;
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
            robot.mechanism.pin_springs.iter_mut().for_each(|spring| *spring = spring.on(&linkage));
            robot.mechanism.linkage = Some(Box::new(linkage));
        }
        for spring in &robot.mechanism.pin_springs {
            let key = format!("linkage.springs.{}", spring.pin.name());
            spring.check_rest().map_err(|e| e.within(&key))?;
        }
        Ok(robot)
    }
}

impl Robot {
    /// Refuses keys that name nothing, or a number twice.
    fn check_names<'a>(&self, keys: impl Iterator<Item = &'a str>) -> Result<(), Error> {
        let (known, keys) = (self.parameters(), keys.collect::<Vec<_>>());
        let unknown = |key: &&&str| !known.iter().any(|number| stands_for(key, &number.name).is_some());
        let Some(unknown) = keys.iter().find(unknown) else { return self.check_spar_numbers(&keys, &known) };
        let names: Vec<&str> = known.iter().map(|number| number.name.as_str()).collect();
        let allowed = self
            .renamed(unknown)
            .map_or_else(|| one_of(unknown, &names), |new| format!("its new name, {new:?}"));
        Err(Error::invalid("numbers", format!("{unknown:?}"), allowed))
    }

    /// Refuses values, each in the unit of its number, that a number is not given.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn check_given(&self, to: &[(&str, f64)]) -> Result<(), Error> {
        self.check_names(to.iter().map(|(key, _)| *key))?;
        let known = self.parameters();
        to.iter().try_for_each(|(key, value)| {
            let number = known.iter().find(|number| stands_for(key, &number.name).is_some());
            number.map_or(Ok(()), |number| check_given(key, &number.quantity, *value))
        })
    }

    /// The name of today of a number that was called `former`; none where that is its name, or no number had it.
    pub fn renamed(&self, former: &str) -> Option<String> {
        let numbers = self.numbers();
        let by_place = |kind: &str, within: &str, place: usize| match kind {
            "panels" | "elements" | "regulators" | "states" => None,
            _ => self.label(kind, within, place).map(str::to_owned),
        };
        let today = self.parameters().into_iter().map(|number| number.name);
        let placed = numbers.named(&by_place);
        let formerly = self::former(former).unwrap_or_else(|| former.to_owned());
        let found = placed.iter().zip(today).find_map(|(placed, today)| {
            let image = stands_for(&formerly, &placed.name)?;
            let pair = formerly != placed.name && !image;
            Some(if pair { pair_of(&today) } else { today })
        })?;
        (found != former).then_some(found)
    }
}

/// Parts of names that numbers once had, and what they are called today. Elements, panels and entries of matrices were once called
/// by their places.
const FORMER_KEYS: [(&str, &str); 2] = [(".series.", ".driven."), (".section_slope", ".lift_slope_per_rad")];

/// The name of today of a number of which a part was once called otherwise.
pub fn former(name: &str) -> Option<String> {
    let part = |(old, new): &(&str, &str)| name.contains(old).then(|| name.replace(old, new));
    FORMER_KEYS.iter().find_map(part)
}

/// The name of a mirrored pair for that of one side.
fn pair_of(name: &str) -> String {
    SIDES.iter().fold(name.to_owned(), |name, side| name.replacen(&format!("{side}."), ".", 1))
}

/// Refuses a value, in the unit of `quantity`, that the number called `name` is not given.
pub fn check_given(name: &str, quantity: &DeclaredQuantity, value: f64) -> Result<(), Error> {
    let [low, high] = quantity.given;
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Error::invalid(name, value, format!("{low} to {high}")))
}
