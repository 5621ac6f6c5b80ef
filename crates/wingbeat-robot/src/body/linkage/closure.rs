//! One loop of two moving bodies between two known points.

use super::super::planar::Planar;
use super::MARGIN_LIMIT;
use wingbeat_math::{Meets, Scalar};
use wingbeat_ocp::plant::Fault;

/// A closed loop: span = length * bar + body * arm.
pub(super) struct Loop<S: Scalar> {
    /// Unit vector of the bar.
    pub(super) bar: Planar<S>,
    /// Unit vector of the body that carries the arm.
    pub(super) body: Planar<S>,
    /// 1 - |cos| of the angle between bar and arm.
    pub(super) margin: f64,
}

impl<S: Scalar> Loop<S> {
    /// Intersects the circle of radius `length` about the start of `span` with the
    /// circle of radius |arm| about its end: with k = (|span|^2 + length^2 - |arm|^2)/(2 length),
    /// bar = span (k + i sqrt(|span|^2 - k^2)) / |span|^2. Of the two intersections, the
    /// bar turned counter-clockwise from the span is the one of this mechanism.
    #[inline]
    pub(super) fn close<P: Scalar>(
        closure: usize,
        span: Planar<S>,
        length: P,
        arm: Planar<S>,
    ) -> Result<Self, Fault>
    where
        S: Meets<P>,
    {
        let (span2, arm2) = (span.norm_squared(), arm.norm_squared());
        let (span2, margin) = span2
            .at_least(MARGIN_LIMIT, [span2, arm2], |[span2, arm2]| margin(span2, length.value(), arm2))
            .map_err(|margin| Fault::LinkageSingular { closure, margin, limit: MARGIN_LIMIT })?;
        let along = (span2 - arm2).shifted(length * length).scaled(P::from(0.5) / length);
        let across = (span2 - along * along).sqrt();
        let bar = (span * Planar::new(along, across)).scaled(span2.recip());
        let body = ((span - bar.times(length)) * arm.conjugate()).scaled(arm2.recip());
        Ok(Self { bar, body, margin })
    }
}

/// 1 - |cos| of the angle between bar and arm (law of cosines); negative when out of reach.
#[inline]
fn margin(span2: f64, length: f64, arm2: f64) -> f64 {
    1.0 - ((span2 - length * length - arm2) / (2.0 * length * arm2.sqrt())).abs()
}
