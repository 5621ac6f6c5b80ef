//! What a flight cost, as every summary and table tells it.

use serde::Serialize;
use std::collections::BTreeMap;
use wingbeat_flight::simulate::Cost;
use wingbeat_math::order::filled;
use wingbeat_robot::{Robot, WeightPart};

/// Power of the joints, without that of thrusters, and what carried the weight, as means over whole cycles. Missing where nothing was averaged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct CostSummary {
    /// Mean of the positive part of the total power of the driven joints, W: what one drive gives that takes nothing back.
    pub positive_power_w: Option<f64>,
    /// That over the mass, W/kg.
    pub positive_power_w_kg: Option<f64>,
    /// Sum over the driven joints of the means of their positive powers, W: what drives give that share nothing.
    pub separate_power_w: Option<f64>,
    /// That over the mass, W/kg.
    pub separate_power_w_kg: Option<f64>,
    /// Mean power of the driven joints with its negative part, W: what drives give that take all back.
    pub net_power_w: Option<f64>,
    /// That over the mass, W/kg.
    pub net_power_w_kg: Option<f64>,
    /// Mean upward force of air and thrusters over the weight; the sum of `weight_shares`.
    pub weight_carried: Option<f64>,
    /// The same by part.
    pub weight_shares: BTreeMap<&'static str, f64>,
    /// What a table calls the part of `cd90`.
    #[serde(skip)]
    broadside: &'static str,
}

/// A line of a table: what, its value, and its unit with what it means.
pub type CostLine = (&'static str, String, &'static str);

/// Share of the weight below which a table leaves a part out.
const SHOWN: f64 = 5e-4;

impl CostSummary {
    /// Of a robot; empty without a mean.
    pub fn new(cost: Option<Cost>, robot: &Robot) -> Self {
        let Some(cost) = cost else { return Self::default() };
        let both = |power: f64| (Some(power), Some(power / robot.mass()));
        let (positive_power_w, positive_power_w_kg) = both(cost.positive_power);
        let (separate_power_w, separate_power_w_kg) = both(cost.separate_power);
        let (net_power_w, net_power_w_kg) = both(cost.net_power);
        Self {
            positive_power_w,
            positive_power_w_kg,
            separate_power_w,
            separate_power_w_kg,
            net_power_w,
            net_power_w_kg,
            weight_carried: Some(cost.carried()),
            weight_shares: filled(WeightPart::ALL.iter().map(|part| part.name()).zip(cost.shares)),
            broadside: robot.broadside_words(),
        }
    }

    /// The powers as a table shows them.
    pub fn power_lines(&self) -> [CostLine; 3] {
        let per_mass = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.1}"));
        [
            ("positive power", per_mass(self.positive_power_w_kg), "W/kg, all joints on one drive"),
            ("positive, joint by joint", per_mass(self.separate_power_w_kg), "W/kg, a drive for each"),
            ("net power", per_mass(self.net_power_w_kg), "W/kg, all taken back"),
        ]
    }

    /// What carried the weight as a table shows it: the sum, then each part that says something.
    pub fn weight_lines(&self) -> Vec<CostLine> {
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        let total = self.weight_carried.map_or("-".into(), percent);
        let part = |part: &WeightPart| {
            let share = *self.weight_shares.get(part.name())?;
            (share.abs() >= SHOWN).then(|| (part.words(self.broadside), percent(share), "%"))
        };
        let parts = WeightPart::ALL.iter().filter_map(part);
        std::iter::once(("weight carried", total, "% of the weight, of which")).chain(parts).collect()
    }
}
