//! One strip of air and wing: the directions of a moving section, the wind it
//! meets, and the air that it carries along.

use super::{SectionFields, SectionMotion, Sections, Wrench};
use wingbeat_math::{Meets, Over, Scalar, Vec3};
use wingbeat_ocp::plant::MAX_DEGREES;

/// The line along which the wind meets a section without lift, by its angle from the chord. A thin section lifts as the
/// flat plate along this line (Glauert 1926, ch. 7).
#[derive(Clone, Copy, Debug)]
pub(super) enum ZeroLift<P = f64> {
    /// Along the chord.
    Chord,
    /// By its cosine and sine.
    Inclined(P, P),
}

impl<P: Scalar> ZeroLift<P> {
    /// The line at the incidence `angle` of the chord, rad.
    pub fn new(angle: P) -> Self {
        if angle.is_zero() { Self::Chord } else { Self::Inclined(angle.cos(), angle.sin()) }
    }
    /// Unit vectors along the line and normal to it, from those of the chord.
    ///
    /// Equation: aero.zero_lift
    /// `a section lifts as the flat plate along its zero-lift line; g = a0 b cos L, D = (g - d) sum(q_k l_k)`
    /// Source: Glauert 1926, The Elements of Aerofoil and Airscrew Theory, ch. 7; D so that the steady jump is the
    /// circulation: own derivation.
    /// Test: `the_polar_shifts_by_the_zero_lift_angle_under_every_law`.
    #[inline(always)]
    pub fn turned<S: Scalar + Meets<P>>(self, chordwise: Vec3<S>, normal: Vec3<S>) -> (Vec3<S>, Vec3<S>) {
        match self {
            Self::Chord => (chordwise, normal),
            Self::Inclined(cosine, sine) => (
                chordwise.scaled(cosine) + normal.scaled(sine),
                normal.scaled(cosine) + chordwise.scaled(-sine),
            ),
        }
    }
    /// Rate of the normal to the line, 1/s, from the rate of the chord's normal and that of its direction.
    #[inline(always)]
    pub fn turned_rate<S: Scalar + Meets<P>>(
        self,
        normal_rate: Vec3<S>,
        chordwise_rate: impl FnOnce() -> Vec3<S>,
    ) -> Vec3<S> {
        match self {
            Self::Chord => normal_rate,
            Self::Inclined(cosine, sine) => normal_rate.scaled(cosine) + chordwise_rate().scaled(-sine),
        }
    }
    /// Unit normal of the chord from the directions along the line and normal to it.
    #[inline(always)]
    pub fn upward<S: Scalar + Meets<P>>(self, chordwise: Vec3<S>, normal: Vec3<S>) -> Vec3<S> {
        match self {
            Self::Chord => normal,
            Self::Inclined(cosine, sine) => normal.scaled(cosine) + chordwise.scaled(sine),
        }
    }
}

/// Directions, winds and rates of one section, resolved in B.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectionFlow<S: Scalar> {
    /// Unit vector along the zero-lift line towards the trailing edge.
    pub chordwise: Vec3<S>,
    /// Unit vector to the upper side, chordwise x across.
    pub normal: Vec3<S>,
    /// Unit vector across the section, from left tip to right tip; nose up is positive about it.
    pub across: Vec3<S>,
    /// Mid-chord point.
    pub middle: Vec3<S>,
    /// Wind along the zero-lift line, m/s.
    pub uc: S,
    /// Wind along the normal at 1/2 chord, m/s.
    pub w_half: S,
    /// Wind along the normal at 3/4 chord, m/s.
    pub w_three_quarter: S,
    /// Velocity across the section relative to the air, m/s.
    pub drift: S,
    /// Rate of pitch, nose up, rad/s.
    pub pitch_rate: S,
    /// Rate at which the normal turns towards `across`, rad/s.
    pub roll_rate: S,
    /// Acceleration of mid chord along the normal, m/s2.
    pub acceleration: S,
    /// Acceleration of pitch, nose up, rad/s2.
    pub pitch_acceleration: S,
}

impl<S: Scalar> SectionFlow<S> {
    /// Geometry and kinematics of a section in the air velocity `wind`; the
    /// chord line is rigid, 1/`inverse_chord` m long and perpendicular to the span, the section a flat plate along its
    /// zero-lift line.
    ///
    /// The normal turns by n' = q e_c + p across with q = -v_te/le.n / c, p = -w.e_c.
    ///
    /// Equation: aero.section_kinematics
    /// `n' = q e_c + p across, p = -w.e_c`
    /// Source: rigid-body kinematics.
    /// Test: `the_carried_air_gives_no_mean_force`.
    #[inline(always)]
    pub fn new<P: Scalar>(
        motion: &SectionMotion<S>,
        wind: Vec3<S>,
        inverse_chord: P,
        zero_lift: ZeroLift<P>,
    ) -> Self
    where
        S: Meets<P>,
    {
        let chord = (motion.te - motion.le) * S::from(inverse_chord);
        let across = motion.span;
        let upward = chord.cross(across);
        let (chordwise, normal) = zero_lift.turned(chord, upward);
        let velocity = motion.velocity(0.5) - wind;
        let velocity_change = motion.v_te - motion.v_le;
        let normal_change = velocity_change.dot(normal);
        let roll_rate = -motion.w.dot(chordwise);
        let w_half = -velocity.dot(normal);
        let (chord_change, chord_rate) = match zero_lift {
            ZeroLift::Chord => (normal_change, -roll_rate),
            ZeroLift::Inclined(..) => (velocity_change.dot(upward), motion.w.dot(chord)),
        };
        Self {
            chordwise,
            normal,
            across,
            middle: motion.point(0.5),
            uc: -velocity.dot(chordwise),
            w_half,
            w_three_quarter: w_half - normal_change * 0.25,
            drift: velocity.dot(across),
            pitch_rate: chord_change * -inverse_chord,
            roll_rate,
            acceleration: motion.acceleration(0.5).dot(normal),
            pitch_acceleration: ((motion.a_te - motion.a_le).dot(upward)
                - chord_rate * velocity_change.dot(across))
                * -inverse_chord,
        }
    }

    /// Force of the carried air at mid chord, for the strip's added mass `mass`
    /// kg: Kirchhoff's F = -d/dt(m v_n n) with the couple -m v_n v_span
    /// (across x n). The mean force over any closed cycle is zero.
    ///
    /// Equation: aero.added_mass
    /// `F = -d/dt(m v_n n), couple -m v_n v_span (across x n), m = rho pi c^2 dy / 4`
    /// Source: Kirchhoff 1869; Lamb 1932, art. 124.
    /// Test: `the_carried_air_gives_no_mean_force`.
    #[inline]
    pub fn added_mass<P: Scalar>(&self, mass: P) -> SectionForce<S>
    where
        S: Meets<P>,
    {
        let momentum = self.w_half * mass;
        let rate = self.acceleration - self.pitch_rate * self.uc + self.roll_rate * self.drift;
        SectionForce {
            chordwise: momentum * self.pitch_rate,
            normal: rate * -mass,
            across: momentum * self.roll_rate,
            nose_up: S::ZERO,
            about_chord: momentum * self.drift,
        }
    }

    /// Nose-up couple, N m, about the quarter chord of a pitching section of the added mass `mass`, kg, beyond the mid-chord
    /// force: -m [(b/2) V q + (b^2/8) q'].
    ///
    /// Equation: aero.section_moment
    /// `-m [(b/2) V q + (b^2/8) q'] about c/4`
    /// Source: Theodorsen 1935, NACA Rep. 496.
    /// Test: `the_carried_air_of_a_pitching_plate_is_theodorsens`.
    #[inline]
    pub fn section_moment<P: Scalar>(&self, mass: P, half_chord: P, speed: S) -> S
    where
        S: Meets<P>,
    {
        speed * self.pitch_rate * (mass * (half_chord * -0.5))
            - self.pitch_acceleration * (mass * half_chord * half_chord / 8.0)
    }

    /// Adds this strip's share of the added-mass matrix (upper triangle) on
    /// [acceleration; angular acceleration] of the body origin: `mass` along
    /// the normal at mid chord, `inertia` kg m2 about the section's axis.
    #[inline]
    pub fn add_inertia<P: Scalar>(&self, mass: P, inertia: P, matrix: &mut [[S; 6]; 6])
    where
        S: Meets<P>,
    {
        let [n, m] = [self.normal, self.middle.cross(self.normal)];
        let g = [n[0], n[1], n[2], m[0], m[1], m[2]];
        for i in 0..6 {
            let scaled = g[i] * mass;
            for j in i..6 {
                matrix[i][j] = matrix[i][j].plus_product(scaled, g[j]);
            }
        }
        for i in 0..3 {
            let scaled = self.across[i] * inertia;
            for j in i..3 {
                matrix[3 + i][3 + j] = matrix[3 + i][3 + j].plus_product(scaled, self.across[j]);
            }
        }
    }

    /// Adds this strip's share of the rows and columns 6.. of the added-mass matrix, on the second
    /// rates of the coordinates of `sections`, with [`add_inertia`](Self::add_inertia)'s `mass` and
    /// `inertia`.
    pub fn add_coupled_inertia<P: Scalar>(
        &self,
        mass: P,
        inertia: P,
        i: usize,
        sections: &(impl Sections<S> + ?Sized),
        zero_lift: ZeroLift<P>,
        matrix: &mut [[S; MAX_DEGREES]],
    ) where
        S: Meets<P>,
    {
        let count = sections.coordinates();
        let motion = sections.on_link(i);
        let inverse_chord = (motion.te - motion.le).norm().recip();
        let normals = [self.normal, zero_lift.upward(self.chordwise, self.normal)];
        let (mut heave, mut pitch) = ([S::ZERO; MAX_DEGREES], [S::ZERO; MAX_DEGREES]);
        self.normal.store(&mut heave);
        self.middle.cross(self.normal).store(&mut heave[3..]);
        self.across.store(&mut pitch[3..]);
        let mut fields = SectionFields::new();
        sections.fields(i, &mut fields);
        for (c, field) in fields.iter().enumerate() {
            (heave[6 + c], pitch[6 + c]) = field.heave_and_pitch(P::from(0.5), normals, inverse_chord);
        }
        for r in 6..6 + count {
            let (heaving, pitching) = (heave[r] * mass, pitch[r] * inertia);
            for k in 0..r {
                let share = heaving * heave[k] + pitching * pitch[k];
                matrix[r][k] += share;
                matrix[k][r] += share;
            }
            matrix[r][r] += heaving * heave[r] + pitching * pitch[r];
        }
    }

    /// A section force as a wrench, N and N m in B, about the body origin.
    #[inline]
    pub fn wrench<T: Over<S>>(&self, f: SectionForce<T>) -> Wrench<T> {
        f.wrench(self.middle, self.chordwise, self.normal, self.across)
    }
}

/// Force and couple on a section at mid chord, along its own directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectionForce<S: Scalar> {
    /// Force towards the trailing edge, N.
    pub chordwise: S,
    /// Force to the upper side, N.
    pub normal: S,
    /// Force from left tip to right tip, N.
    pub across: S,
    /// Couple about `across`, N m.
    pub nose_up: S,
    /// Couple about `chordwise`, N m.
    pub about_chord: S,
}

impl<S: Scalar> SectionForce<S> {
    /// A force in the plane of the section, acting `ahead` m of mid chord.
    #[inline]
    pub fn in_plane(chordwise: S, normal: S, ahead: S) -> Self {
        Self { chordwise, normal, across: S::ZERO, nose_up: normal * ahead, about_chord: S::ZERO }
    }

    /// The same force with more derivatives, all zero.
    #[inline]
    pub fn lifted<T: Over<S>>(self) -> SectionForce<T> {
        SectionForce {
            chordwise: T::from(self.chordwise),
            normal: T::from(self.normal),
            across: T::from(self.across),
            nose_up: T::from(self.nose_up),
            about_chord: T::from(self.about_chord),
        }
    }

    /// As a wrench (N and N m, in B) about the body origin, given mid chord (m) and the section's directions.
    #[inline]
    pub fn wrench<G: Scalar>(
        self,
        middle: Vec3<G>,
        chordwise: Vec3<G>,
        normal: Vec3<G>,
        across: Vec3<G>,
    ) -> Wrench<S>
    where
        S: Over<G>,
    {
        let in_plane = normal.times_plus(self.normal, chordwise.times(self.chordwise));
        let force = across.times_plus(self.across, in_plane);
        let couple = chordwise.times_plus(self.about_chord, across.times(self.nose_up));
        Wrench { force, moment: middle.cross_over(force) + couple }
    }
}

impl<S: Scalar> std::ops::Add for SectionForce<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self {
            chordwise: self.chordwise + o.chordwise,
            normal: self.normal + o.normal,
            across: self.across + o.across,
            nose_up: self.nose_up + o.nose_up,
            about_chord: self.about_chord + o.about_chord,
        }
    }
}

/// Forward force that the rate of pitch `pitch` (rad/s, nose up) adds to the chord force of a strip
/// that carries the air `mass` (kg), its lift slope being `slope_share` = s of that of a thin plate:
/// m q (w - 2 s w_l) - (1 - s) m b q^2/2.
///
/// The suction goes with the square of the wash at the leading edge's singularity, which is the lift wash
/// w_l less b q/2: S = s 2 pi rho b dy (w_l - b q/2)^2, and m = pi rho b^2 dy. Of it the turned lift holds
/// s 2 pi rho b dy w_l^2 and the carried air -m q (w - b q/2), w its wash at 3/4 chord; the rest is this.
///
/// Equation: aero.pitch_suction
/// `m q (w - 2 s w_l) - (1 - s) m b q^2/2 forward, s = a0/2 pi, so that the suction is s 2 pi rho b dy (w_l - b
/// q/2)^2, m = pi rho b^2 dy`
/// Source: Garrick 1936, NACA Rep. 567.
/// Test: `a_pitching_strip_has_garricks_suction`.
#[inline]
pub(super) fn pitch_suction<P: Scalar, G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
    (mass, slope_share, half_chord): (P, P, P),
    pitch: G,
    wash: S,
    lift_wash: S,
) -> S {
    let linear = wash - lift_wash * (slope_share * 2.0);
    (linear - pitch * ((-slope_share + 1.0) * (half_chord * 0.5))) * (pitch * mass)
}

/// Share of leading-edge suction at the cosine x of the effective incidence:
/// 1 in attached, 0 in reversed flow, (1 + tanh(4 artanh x)) / 2 between: a choice, smooth
/// and rational.
#[inline]
pub(super) fn suction_share<S: Scalar>(x: S) -> S {
    let x2 = x * x;
    let rise = x * (x2 + 1.0) * 2.0 / (x2 * (x2 + 6.0) + 1.0);
    rise + 0.5
}
