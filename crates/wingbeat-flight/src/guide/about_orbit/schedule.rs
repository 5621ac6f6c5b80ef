//! When which course is flown.

use super::tracking::Demand;
use crate::orbit::Course;

/// Courses after another.
#[derive(Clone, Debug)]
pub(super) struct CourseSchedule {
    /// That of the begin.
    pub first: Course,
    /// In the order of time.
    pub stretches: Vec<Stretch>,
    /// Whether every stretch begins at the first course, in no order of time.
    pub fan: bool,
}

/// From one course to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// Begin, s.
    pub start: f64,
    /// s.
    pub duration: f64,
    pub from: Course,
    pub to: Course,
}

/// Where a stretch of a schedule is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StretchPlace {
    /// Number of the stretch.
    pub stretch: usize,
    /// Share of it that is done.
    pub share: f64,
}

impl CourseSchedule {
    /// The stretch before that led the other way.
    pub fn back(&self, stretch: &Stretch) -> Option<usize> {
        self.stretches.iter().position(|other| other.from == stretch.to && other.to == stretch.from)
    }

    /// Where the time `t` is; `None` before the first stretch begins.
    pub fn place(&self, t: f64) -> Option<StretchPlace> {
        let stretch = self.stretches.partition_point(|stretch| stretch.start <= t).checked_sub(1)?;
        Some(StretchPlace { stretch, share: self.stretches[stretch].share(t) })
    }

    /// What is asked at the time `t`.
    pub fn demand(&self, t: f64) -> Demand {
        Demand { place: self.place(t), height: self.height(t), faster: 0.0, beside: None }
    }

    /// Height of the mean path at the time `t` above that at 0, m.
    pub fn height(&self, t: f64) -> f64 {
        let (mut height, mut time, mut climb) = (0.0, 0.0, self.first.climb);
        for stretch in self.stretches.iter().take_while(|stretch| stretch.start <= t) {
            height += climb * (stretch.start - time) + stretch.height(t);
            (time, climb) = (t.min(stretch.start + stretch.duration), stretch.to.climb);
        }
        height + climb * (t - time)
    }
}

impl Stretch {
    /// Share done at the time `t`: 3 s^2 - 2 s^3 of the share s of the time, without jumps of the rate.
    fn share(&self, t: f64) -> f64 {
        let s = self.passed(t);
        s * s * (3.0 - 2.0 * s)
    }

    fn passed(&self, t: f64) -> f64 {
        ((t - self.start) / self.duration).clamp(0.0, 1.0)
    }

    /// Height gained on it up to the time `t`, m: the integral of the climb, whose share 3 s^2 - 2 s^3 integrates to
    /// s^3 - s^4/2.
    fn height(&self, t: f64) -> f64 {
        let s = self.passed(t);
        let grown = s * s * s * (1.0 - 0.5 * s);
        self.duration * (self.from.climb * s + (self.to.climb - self.from.climb) * grown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_height_is_the_integral_of_the_climb() {
        let course = |climb: f64| Course { speed: 4.0, climb, bank: 0.0 };
        let stretch = |start: f64, from: f64, to: f64| Stretch {
            start,
            duration: 1.5,
            from: course(from),
            to: course(to),
        };
        let schedule = CourseSchedule {
            first: course(0.2),
            stretches: vec![stretch(1.0, 0.2, -2.0), stretch(3.0, -2.0, 0.5)],
            fan: false,
        };
        let climb = |t: f64| match schedule.place(t) {
            None => 0.2,
            Some(StretchPlace { stretch, share }) => {
                let s = &schedule.stretches[stretch];
                s.from.climb + (s.to.climb - s.from.climb) * share
            }
        };
        assert_eq!((climb(0.5), climb(2.7), climb(9.0)), (0.2, -2.0, 0.5));
        let (step, mut height) = (1e-3, 0.0);
        for k in 0..6000 {
            // Simpson's rule is exact for cubics.
            let t = k as f64 * step;
            height += step / 6.0 * (climb(t) + 4.0 * climb(t + 0.5 * step) + climb(t + step));
            assert!((height - schedule.height(t + step)).abs() < 1e-12, "{t}");
        }
        let back = stretch(5.0, 0.5, -2.0);
        assert_eq!(schedule.back(&back), Some(1));
    }
}
