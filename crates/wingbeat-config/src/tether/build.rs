//! The wing in its wind that a case file says.

use super::spec::{CoordinateSpec, HingeSpec, ReadTable, TetherSpec, TetheredWingSpec, WindSpec};
use crate::Smoothed;
use crate::spar_numbers::SparNumbers;
use std::path::PathBuf;
use wingbeat_aero::{Aero, CD0, Planform};
use wingbeat_flight::tether::{CoefficientScales, Hinge, Motion, Plane, Side, Spar, Tether, Wing};
use wingbeat_judge::RunLimits;
use wingbeat_judge::data::Finding;
use wingbeat_math::{Error, Vec3};
use wingbeat_robot::SurfaceOutline;

/// The folder from which the path at a key is seen.
type Folder<'a> = &'a dyn Fn(&str) -> PathBuf;

/// What the tables of a motion say.
#[derive(Default)]
pub(super) struct MotionTables {
    pub(super) smoothed: Vec<Smoothed>,
    pub(super) found: Vec<Finding>,
}

impl TetherSpec {
    pub(super) fn build(
        &self,
        folder: Folder,
        read: ReadTable,
        limits: &RunLimits,
    ) -> Result<(Tether, MotionTables), Error> {
        self.check()?;
        let (motion, tables) = self.motion(folder, read, limits)?;
        let clock = self.time.clock();
        let (planform, wing, aero) = self.own_aero()?;
        let (aero, numbers) = self.numbered(&aero)?;
        let spar = self.built_spar(&aero, &planform, numbers)?;
        let halves = if self.wing.side == Side::Both { 1.0 } else { 0.5 };
        let area = planform.area() * halves;
        let tether = Tether {
            reference: CoefficientScales {
                density_kg_m3: aero.numbers().density,
                speed_m_s: self.reference_speed()?,
                area_m2: self.reference.area_m2.unwrap_or(area),
                chord_m: self
                    .reference
                    .chord_m
                    .unwrap_or(area / (2.0 * halves * planform.covered_half_span())),
            },
            wing,
            motion,
            ground: self.wind.ground_m.map(|height| Plane::new(&aero, height)),
            aero,
            wind: self.wind.velocity(),
            side: self.wing.side,
            clock,
            spar,
        };
        let names = [("air", "wind"), ("hinges", "wing.hinges")];
        tether.check().map_err(|e| e.renamed(&names))?;
        Ok((tether, tables))
    }

    /// Its planform, its wing, and the model of that with no number by its name.
    pub(super) fn own_aero(&self) -> Result<(Planform, Wing, Aero), Error> {
        let planform = self.wing.outline().map_err(|e| e.within("wing"))?;
        self.wing
            .flap
            .iter()
            .try_for_each(|flap| flap.end_within(&planform))
            .map_err(|e| e.within("wing"))?;
        let outer = self.wing.hinges.iter().enumerate().filter(|(_, hinge)| hinge.arc_m > 0.0);
        let (keys, arcs): (Vec<String>, Vec<f64>) =
            outer.map(|(i, hinge)| (format!("wing.hinges[{i}].arc_m"), hinge.arc_m)).unzip();
        let wing = self.wing.build(planform.clone())?;
        let mut names = vec![
            ("half_span".to_owned(), format!("wing.{}", self.wing.tip_key())),
            ("gaps".into(), "wing.gaps".into()),
            ("membrane".into(), "wing.membrane".into()),
            ("flap".into(), "wing.flap".into()),
            ("drag".into(), "wing".into()),
            ("density_kg_m3".into(), "wind.density_kg_m3".into()),
        ];
        names.extend(keys.into_iter().enumerate().map(|(k, key)| (format!("hinge_arcs_m[{k}]"), key)));
        let outline = SurfaceOutline {
            name: "wing".into(),
            key: "wing".into(),
            planform: planform.clone(),
            hinges: arcs,
            webs: Vec::new(),
            cd0: self.wing.cd0.unwrap_or(if self.aero.law.separates() { CD0.default } else { 0.0 }),
            cd90: self.wing.cd90,
            section: self.wing.section,
            membrane: self.wing.membrane.clone(),
            flap: self.wing.flap,
            preset: None,
            law: None,
            strips: None,
        };
        let aero = self.aero.build(&outline, self.wind.density_kg_m3, false, &names)?;
        Ok((planform, wing, aero))
    }

    /// The speed of the coefficients: as given, and else the wind's.
    fn reference_speed(&self) -> Result<f64, Error> {
        let wind = self.wind.speed_m_s;
        if wind == 0.0 && self.reference.speed_m_s.is_none() {
            let allowed = "another speed, or still air with a `reference.speed_m_s` for the coefficients";
            return Err(Error::invalid("wind.speed_m_s", wind, allowed).against(["reference.speed_m_s"]));
        }
        Ok(self.reference.speed_m_s.unwrap_or(wind.abs()))
    }

    /// The spar with these numbers, for a wing of that model and outline.
    pub(super) fn built_spar(
        &self,
        aero: &Aero,
        planform: &Planform,
        numbers: Option<SparNumbers>,
    ) -> Result<Option<Spar>, Error> {
        let spar = self.spar.as_ref().zip(numbers);
        let built = spar.map(|(spar, numbers)| numbers.on(spar).build(aero, planform.half_span()));
        built.transpose().map_err(|e| e.within("spar"))
    }

    fn motion(
        &self,
        folder: Folder,
        read: ReadTable,
        limits: &RunLimits,
    ) -> Result<(Motion, MotionTables), Error> {
        let frequency = self.time.frequency_hz;
        let degree = 1.0_f64.to_radians();
        let body = &self.body;
        let mut tables = MotionTables::default();
        let mut build = |spec: &CoordinateSpec, key: &str, factor| {
            let folder = || folder(&format!("{key}.table.file"));
            let built = spec.build(frequency, &folder, read, limits).map_err(|e| e.within(key))?;
            tables.smoothed.extend(built.smoothed.map(|left| Smoothed { key: key.into(), ..left }));
            let keyed = |finding: Finding| {
                let whole = finding.key.as_ref().map(|end| format!("{key}.{end}"));
                finding.mended_by(whole)
            };
            tables.found.extend(built.found.into_iter().map(keyed));
            Ok(built.coordinate.scaled(factor))
        };
        let surge = build(&body.surge_m, "body.surge_m", 1.0)?;
        let heave = build(&body.heave_m, "body.heave_m", 1.0)?;
        let nose_up = build(&body.nose_up_deg, "body.nose_up_deg", degree)?;
        let roll = build(&body.roll_deg, "body.roll_deg", degree)?;
        let hinge = |(i, h): (usize, &HingeSpec)| {
            Ok((h.name.clone(), build(&h.angle_deg, &format!("wing.hinges[{i}].angle_deg"), degree)?))
        };
        let hinges = self.wing.hinges.iter().enumerate().map(hinge).collect::<Result<_, Error>>()?;
        Ok((Motion { surge, heave, nose_up, roll, axis_ahead_m: body.pitch_axis_ahead_m, hinges }, tables))
    }
}

impl TetheredWingSpec {
    /// The planform with its gaps.
    fn outline(&self) -> Result<Planform, Error> {
        Planform::new(&self.planform)?.with_gaps(&self.gaps)
    }

    /// The key that says how long the half wing is.
    fn tip_key(&self) -> String {
        format!("planform[{}].arc_m", self.planform.len().saturating_sub(1))
    }

    fn build(&self, planform: Planform) -> Result<Wing, Error> {
        let hinge = |h: &HingeSpec| Hinge {
            kind: h.kind,
            side: h.side,
            arc_m: h.arc_m,
            to_arc_m: h.to_arc_m,
            ahead_m: h.ahead_m,
        };
        let built = Wing::new(planform, self.hinges.iter().map(hinge).collect());
        built.map_err(|e| e.renamed(&[("half_span", self.tip_key())]).within("wing"))
    }
}

impl WindSpec {
    /// Velocity of the air in W, m/s.
    fn velocity(&self) -> Vec3 {
        let (up, level) = self.incidence_deg.to_radians().sin_cos();
        let (side, ahead) = self.sideslip_deg.to_radians().sin_cos();
        Vec3::new(-level * ahead, -level * side, up) * self.speed_m_s
    }
}
