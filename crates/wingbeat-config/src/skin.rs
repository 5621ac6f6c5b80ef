//! What a run says of its membranes.

use serde::Serialize;
use std::f64::consts::TAU;
use wingbeat_aero::{Aero, membrane_rise};
use wingbeat_judge::Judge;
use wingbeat_judge::limits::membrane::{
    BENDING, BEYOND_BENDING, BEYOND_CAMBER, BEYOND_FREQUENCY, BEYOND_LAG, BEYOND_STRAIN, CAMBER, FREQUENCY,
    LAG, SLACK, SLACK_SPAN, STRAIN, WEIGHT,
};

/// Rise over the chord below which no load bends a membrane. *Choice.*
const UNBENT: f64 = 1e-9;

/// Membranes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MembraneSummary {
    /// Largest rise over the chord.
    pub camber_max: f64,
    /// Largest strain along the chord, or along the span at rest, dimensionless.
    pub strain_max: f64,
    /// Share of strips and instants in which the membrane is slack along the chord.
    pub slack_fraction: f64,
    /// Strain along the span at rest where ribs hold it, dimensionless.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prestrain_span: Option<f64>,
    /// Frequency of the motion, in a flight at least 1/(2 pi duration), over the least one of the membranes with the mean tension along the chord.
    pub frequency_fraction: f64,
    /// Angular frequency of the motion times `damping_s`, rad; in a flight at least `damping_s` over its duration.
    pub lag_rad: f64,
    /// Rise by the weight of the membrane, which is left out, over the largest rise; 0 where no load bends it.
    pub weight_fraction: f64,
    /// Ratio of the load that its bending stiffness, which is left out, would bear to what the mean tension bears.
    pub bending_fraction: f64,
}

impl MembraneSummary {
    /// Of the surface `aero` from the heights over the chord of its strips at all instants; none without a membrane or an instant.
    pub fn of(aero: &Aero, heights: impl Iterator<Item = [f64; 2]>, frequency_hz: f64) -> Option<Self> {
        let model = aero.membrane()?;
        let (mut camber_max, mut slack, mut taut, mut count) = (0.0_f64, 0.0, 0.0, 0.0);
        let mut strain_max = model.membrane_prestrain_span().unwrap_or(0.0);
        for [camber, forward] in heights {
            camber_max = camber_max.max(membrane_rise(camber, forward));
            let stretch = model.membrane_stretch(camber, forward).unwrap_or_default();
            strain_max = strain_max.max(stretch);
            slack += if stretch < 0.0 { 1.0 } else { 0.0 };
            taut += stretch.max(0.0);
            count += 1.0;
        }
        if count == 0.0 {
            return None;
        }
        let scales = model.membrane_scales(taut / count)?;
        let over = |part: f64, whole: f64| if part == 0.0 { 0.0 } else { part / whole };
        // In still air at rest nothing bends it, and there is no load beside which its weight counts.
        let loaded = camber_max > UNBENT;
        Some(Self {
            camber_max,
            strain_max,
            slack_fraction: slack / count,
            prestrain_span: model.membrane_prestrain_span(),
            frequency_fraction: over(frequency_hz, scales.frequency_hz),
            lag_rad: TAU * frequency_hz * scales.damping_s,
            weight_fraction: if loaded { over(scales.weight_rise, camber_max) } else { 0.0 },
            bending_fraction: model.membrane_bending(taut / count)?,
        })
    }

    /// The worse of two.
    pub fn worse(self, other: Self) -> Self {
        Self {
            camber_max: self.camber_max.max(other.camber_max),
            strain_max: self.strain_max.max(other.strain_max),
            slack_fraction: self.slack_fraction.max(other.slack_fraction),
            prestrain_span: [self.prestrain_span, other.prestrain_span]
                .into_iter()
                .flatten()
                .reduce(f64::min),
            frequency_fraction: self.frequency_fraction.max(other.frequency_fraction),
            lag_rad: self.lag_rad.max(other.lag_rad),
            weight_fraction: self.weight_fraction.max(other.weight_fraction),
            bending_fraction: self.bending_fraction.max(other.bending_fraction),
        }
    }

    /// Holds them against their limits.
    pub fn judge(&self, judge: &mut Judge) {
        judge.hold(&CAMBER, self.camber_max);
        judge.hold(&STRAIN, self.strain_max);
        judge.hold(&BEYOND_STRAIN, self.strain_max);
        judge.hold(&BEYOND_CAMBER, self.camber_max);
        judge.hold(&SLACK, self.slack_fraction);
        judge.hold_if(&SLACK_SPAN, self.prestrain_span);
        judge.hold(&FREQUENCY, self.frequency_fraction);
        judge.hold(&BEYOND_FREQUENCY, self.frequency_fraction);
        judge.hold(&LAG, self.lag_rad);
        judge.hold(&BEYOND_LAG, self.lag_rad);
        judge.hold(&WEIGHT, self.weight_fraction);
        judge.hold(&BENDING, self.bending_fraction);
        judge.hold(&BEYOND_BENDING, self.bending_fraction);
    }
}
