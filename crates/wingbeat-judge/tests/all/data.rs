//! The doctor: right data that look odd pass, wrong data are found, each limit from both sides.

use std::f64::consts::TAU;
use wingbeat_judge::data::{
    CyclePair, Finding, MeasuredChannel, Purpose, Series, SpectralLine, compared, cut_off, estimate,
    examined, find_frequency, mean_apart, not_finite, of_few_counts, reversed_among,
};
use wingbeat_judge::{Judge, RunLimits, Status, limits};

/// Even numbers from -1 to 1, without a crate.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A load over `cycles` cycles at `rate` samples in each.
#[derive(Clone)]
struct Load {
    cycles: f64,
    rate: usize,
    mean: f64,
    size: f64,
    /// Amplitude of the second and third harmonic.
    more: [f64; 2],
    noise: f64,
    count: f64,
    /// Frequency over the one given.
    ratio: f64,
}

impl Default for Load {
    fn default() -> Self {
        Self {
            cycles: 10.0,
            rate: 200,
            mean: 0.1,
            size: 1.0,
            more: [0.3, 0.1],
            noise: 0.02,
            count: 0.0,
            ratio: 1.0,
        }
    }
}

impl Load {
    fn phase(&self) -> Vec<f64> {
        (0..(self.cycles * self.rate as f64) as usize).map(|k| k as f64 / self.rate as f64).collect()
    }

    fn at(&self, phase: f64) -> f64 {
        let p = TAU * self.ratio * phase;
        self.mean
            + self.size * (p.cos() + self.more[0] * (2.0 * p + 0.4).sin() + self.more[1] * (3.0 * p).cos())
    }

    fn samples(&self, seed: u64) -> Vec<f64> {
        let mut noise = Noise(seed);
        let one = |p: &f64| {
            let x = self.at(*p) + self.noise * 1.73 * noise.next();
            if self.count > 0.0 { (x / self.count).round() * self.count } else { x }
        };
        self.phase().iter().map(one).collect()
    }
}

type Data = (Vec<f64>, Vec<Vec<f64>>, Purpose);

fn loads(load: &Load) -> Data {
    let other = load.samples(2).into_iter().map(|x| 0.9 * x).collect();
    (load.phase(), vec![load.samples(1), other], Purpose::Loads)
}

fn changed(load: &Load, change: impl Fn(usize, f64) -> f64) -> Data {
    let mut data = loads(load);
    data.1[0].iter_mut().enumerate().for_each(|(k, x)| *x = change(k, *x));
    data
}

fn motion(load: &Load) -> Data {
    (load.phase(), vec![load.samples(3)], Purpose::Motion)
}

fn found(data: &Data) -> Vec<Finding> {
    let names = ["Fx", "Fz", "Ty"];
    let channels = data.1.iter().zip(names);
    let channels = channels.map(|(samples, name)| MeasuredChannel { name, unit: "N", samples }).collect();
    let series =
        Series { what: "pass1.csv", phase: &data.0, frequency_hz: Some(5.0), channels, purpose: data.2 };
    examined(&series, &RunLimits::default())
}

fn ids(found: &[Finding]) -> Vec<&'static str> {
    found.iter().map(|finding| finding.id).collect()
}

/// Data that look odd and are right.
fn right() -> Vec<(&'static str, Data)> {
    let usual = Load::default;
    let uneven = |data: Data| {
        let mut noise = Noise(9);
        let step = data.0[1];
        (data.0.iter().map(|p| p + 0.4 * step * noise.next()).collect(), data.1, data.2)
    };
    let exact = |load: Load| Load { noise: 0.0, ..load };
    let pulse = |k: usize, _: f64| {
        let p = (k as f64 / 200.0).fract();
        (-((p - 0.5) / 0.08).powi(2)).exp()
    };
    vec![
        ("usual", loads(&usual())),
        ("one_cycle", loads(&Load { cycles: 1.0, ..usual() })),
        // What the mount does beside the loads; the other channel repeats, so the file has the frequency given.
        (
            "swing_of_the_mount",
            changed(&Load { cycles: 3.0, ..usual() }, |k, x| x + 0.25 * (TAU * k as f64 / 110.0).sin()),
        ),
        ("two_cycles", loads(&Load { cycles: 2.0, ..usual() })),
        ("part_of_a_cycle_more", loads(&Load { cycles: 3.4, ..usual() })),
        ("many_cycles", loads(&Load { cycles: 400.0, rate: 50, ..usual() })),
        ("seven_khz", loads(&Load { cycles: 35.0, rate: 2000, ..usual() })),
        ("few_samples", loads(&Load { rate: 24, cycles: 20.0, ..usual() })),
        (
            "few_samples_of_many_cycles",
            loads(&Load { rate: 24, cycles: 200.0, more: [0.8, 0.6], noise: 0.002, ..usual() }),
        ),
        // Loads of strokes that are alike, at 7.4 samples a cycle.
        ("twice_in_a_cycle_of_few_samples", {
            let phase: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.1348).collect();
            let of = |wave: fn(f64) -> f64| phase.iter().map(|p| wave(TAU * p)).collect::<Vec<_>>();
            let samples = vec![of(|p| 0.1 + 0.5 * p.sin()), of(|p| 1.0 + 0.3 * (2.0 * p).cos())];
            (phase.clone(), samples, Purpose::Loads)
        }),
        ("exact", loads(&exact(usual()))),
        // A rate that is no multiple of the frequency: the digits come again after three cycles.
        ("exact_digits_of_three_cycles", {
            let phase: Vec<f64> = (0..5000).map(|k| f64::from(k) * 3e-3).collect();
            let digits = |p: &f64| (exact(usual()).at(*p) * 1e6).round() * 1e-6;
            let samples: Vec<f64> = phase.iter().map(digits).collect();
            (phase, vec![samples.clone(), samples.iter().map(|x| 0.9 * x).collect()], Purpose::Loads)
        }),
        (
            "knock_in_every_cycle",
            changed(&usual(), |k, x| if (60..63).contains(&(k % 200)) { x + 4.0 } else { x }),
        ),
        ("exact_and_alike", loads(&exact(Load { rate: 40, more: [0.0, 0.0], ..usual() }))),
        ("strong_harmonics", loads(&Load { more: [2.0, 1.5], ..usual() })),
        ("second_harmonic_alone", loads(&Load { more: [30.0, 0.0], size: 0.1, ..usual() })),
        ("strong_mean", loads(&Load { mean: 50.0, size: 0.05, noise: 0.01, ..usual() })),
        ("noise_as_large", loads(&Load { noise: 1.0, cycles: 40.0, ..usual() })),
        ("noise_three_times", loads(&Load { noise: 3.0, cycles: 100.0, ..usual() })),
        ("nano17_counts", loads(&Load { count: 1.0 / 320.0, size: 0.1, noise: 0.001, ..usual() })),
        ("coarse_counts", loads(&Load { count: 0.1, noise: 0.0, ..usual() })),
        ("coarse_counts_with_noise", loads(&Load { count: 0.1, noise: 0.05, ..usual() })),
        ("milli_newtons", loads(&Load { size: 800.0, mean: 30.0, noise: 10.0, ..usual() })),
        ("micro_newton_metres", loads(&Load { size: 2e-6, mean: 1e-6, noise: 1e-7, ..usual() })),
        ("uneven_time", uneven(loads(&usual()))),
        ("uneven_time_few", uneven(loads(&Load { rate: 40, ..usual() }))),
        ("zero_by_symmetry", changed(&usual(), |_, _| 0.0)),
        ("constant_beside_a_load", changed(&usual(), |_, _| 0.25)),
        ("noise_beside_a_load", changed(&usual(), |k, _| 0.01 * Noise(k as u64 * 77_777).next())),
        ("one_count_beside_a_load", changed(&usual(), |k, _| ((k / 7) % 2) as f64 / 320.0)),
        ("small_drift", changed(&usual(), |k, x| x + 0.2 * k as f64 / 2000.0)),
        ("small_bow", changed(&usual(), |k, x| x + 0.2 * (k as f64 / 2000.0).powi(2))),
        ("lifted_to_zero", changed(&exact(usual()), |_, x| x + 0.925)),
        ("one_sign", changed(&usual(), |k, _| (TAU * k as f64 / 200.0).sin().powi(2))),
        ("two_pulses", changed(&exact(usual()), move |k, x| pulse(2 * k, x))),
        ("pulses", changed(&exact(usual()), pulse)),
        (
            "pulses_with_noise",
            changed(&usual(), move |k, x| pulse(k, x) + 0.01 * Noise(k as u64 * 31).next()),
        ),
        ("amplitude_that_breathes", changed(&usual(), |k, x| x * (1.0 + 0.1 * (k as f64 / 700.0).sin()))),
        ("jitter_of_phase", changed(&usual(), |k, x| x + 0.05 * (k as f64 / 150.0).sin())),
        ("some_samples_lost", {
            let (phase, channels, purpose) = loads(&usual());
            let kept = |of: &Vec<f64>| -> Vec<f64> {
                of.iter().enumerate().filter(|(k, _)| !(600..640).contains(k)).map(|(_, x)| *x).collect()
            };
            (kept(&phase), channels.iter().map(kept).collect(), purpose)
        }),
        ("motion", motion(&exact(Load { cycles: 1.0, size: 30.0, ..usual() }))),
        ("motion_of_twenty_samples", motion(&exact(Load { cycles: 1.0, rate: 20, size: 30.0, ..usual() }))),
        ("motion_of_several_cycles", motion(&exact(Load { size: 30.0, ..usual() }))),
        ("motion_rounded", motion(&Load { size: 30.0, noise: 0.0, count: 0.001, cycles: 1.0, ..usual() })),
        ("motion_held", (usual().phase(), vec![vec![4.0; 2000]], Purpose::Motion)),
        ("motion_with_little_noise", motion(&Load { size: 30.0, noise: 0.002, rate: 100, ..usual() })),
        // What a cell and its amplifier do now and then: less than 1 % of the range in the mean.
        ("a_spike", changed(&usual(), |k, x| if k == 777 { x + 15.0 } else { x })),
        (
            "a_spike_in_noise",
            changed(&Load { noise: 0.3, ..usual() }, |k, x| if k == 99 { x - 9.0 } else { x }),
        ),
        // Impacts that repeat, and one at another phase each time.
        ("impacts", changed(&usual(), |k, x| if k % 200 < 3 { x + 5.0 } else { x })),
        ("phase_of_the_crank", changed(&usual(), |k, _| (k as f64 / 200.0).fract())),
        ("held_values", changed(&exact(usual()), |k, _| usual().at((k / 40 * 40) as f64 / 200.0))),
        ("a_dead_band", changed(&usual(), |_, x| if x.abs() < 0.03 { 0.0 } else { x })),
        ("noise_of_differences", {
            let mut noise = Noise(3);
            let white: Vec<f64> = (0..2001).map(|_| noise.next()).collect();
            changed(&exact(usual()), move |k, x| x + white[k + 1] - white[k])
        }),
        (
            "starts_in_the_file",
            changed(&Load { cycles: 40.0, ..usual() }, |k, x| x * (k as f64 / 600.0).min(1.0)),
        ),
        (
            "motion_of_six_rows",
            motion(&exact(Load { cycles: 1.0, rate: 6, more: [0.0; 2], size: 30.0, ..usual() })),
        ),
        (
            "motion_of_rounded_rows",
            motion(&Load { size: 30.0, count: 0.1, noise: 0.0, cycles: 1.0, rate: 40, ..usual() }),
        ),
        ("motion_of_pulses", {
            let pulse = |k: i32| 30.0 * (0.5 + 0.5 * (TAU * f64::from(k) / 96.0).cos()).powi(8);
            (
                (0..96).map(|k| f64::from(k) / 96.0).collect(),
                vec![(0..96).map(pulse).collect()],
                Purpose::Motion,
            )
        }),
        ("half_a_cycle", loads(&Load { cycles: 0.5, ..usual() })),
        // Flat ends that are no ends of a range: a slack line, which is quiet as well, and a stroke of constant speed.
        ("slack_and_quiet", {
            changed(&exact(Load { cycles: 20.0, ..usual() }), |k, _| {
                let pull = (TAU * k as f64 / 200.0).sin().max(0.0);
                pull * (1.0 + 0.05 * Noise(k as u64 * 31).next()) + 0.003 * Noise(k as u64 * 57).next()
            })
        }),
        (
            "flat_top",
            changed(&Load { cycles: 20.0, ..usual() }, |k, _| {
                3.0 + (5.0 * (TAU * k as f64 / 200.0).sin()).tanh() + 0.02 * Noise(k as u64 * 31).next()
            }),
        ),
        ("unsteady_crank", {
            let load = exact(Load { cycles: 20.0, ..usual() });
            changed(&load.clone(), move |k, _| {
                let late = 0.01 * Noise(k as u64 * 31).next();
                load.at(k as f64 / 200.0 + late) + 0.003 * Noise(k as u64 * 57).next()
            })
        }),
        ("swings_a_little", changed(&usual(), |k, x| x * (1.0 + 0.3 * (k as f64 / 200.0).sin()))),
        ("weak_strokes_between", changed(&usual(), |k, x| if k / 200 % 2 == 0 { x } else { 0.7 * x })),
        ("on_and_off", changed(&usual(), |k, _| f64::from(u8::from(k % 200 < 60)))),
        ("eight_counts", changed(&exact(usual()), |_, x| (x / 0.3).round() * 0.3)),
    ]
}

/// Data that are wrong, and what is to be found.
fn wrong() -> Vec<(&'static str, &'static str, Data)> {
    let usual = Load::default;
    let lost = |every: usize| {
        let (phase, channels, purpose) = loads(&usual());
        let kept = move |of: &Vec<f64>| -> Vec<f64> {
            of.iter().enumerate().filter(|(k, _)| k % every >= every / 4).map(|(_, x)| *x).collect()
        };
        (kept(&phase), channels.iter().map(kept).collect::<Vec<_>>(), purpose)
    };
    let all = |data: Data, change: &dyn Fn(f64) -> f64| {
        let channels = data.1.iter().map(|x| x.iter().map(|x| change(*x)).collect()).collect();
        (data.0, channels, data.2)
    };
    let noise = |cycles: f64, rate: usize| loads(&Load { size: 0.0, cycles, rate, ..usual() });
    let back = |data: Data| {
        let mut phase = data.0;
        phase.swap(500, 501);
        (phase, data.1, data.2)
    };
    vec![
        ("constant", "data.dead", all(loads(&usual()), &|_| 0.3)),
        ("zero", "data.dead", all(loads(&usual()), &|_| 0.0)),
        ("tiny", "data.tiny", all(loads(&usual()), &|x| 1e-300 * x)),
        ("small", "data.tiny", all(loads(&usual()), &|x| 1e-11 * x)),
        ("huge", "data.huge", all(loads(&usual()), &|x| 1e12 * x)),
        ("not_a_number", "data.not_finite", changed(&usual(), |k, x| if k == 7 { f64::NAN } else { x })),
        ("infinite", "data.not_finite", changed(&usual(), |k, x| if k > 1990 { f64::INFINITY } else { x })),
        ("stuck", "data.stuck", changed(&usual(), |k, x| if (400..700).contains(&k) { 0.5 } else { x })),
        ("stuck_to_the_end", "data.stuck", changed(&usual(), |k, x| if k > 1500 { 0.5 } else { x })),
        (
            "stuck_with_a_count",
            "data.stuck",
            changed(&Load { count: 0.01, ..usual() }, |k, x| {
                if (400..700).contains(&k) { 0.5 + 0.01 * (k / 3 % 2) as f64 } else { x }
            }),
        ),
        ("clipped_high", "data.clipped", changed(&usual(), |_, x| x.min(0.8))),
        ("clipped_low", "data.clipped", changed(&usual(), |_, x| x.max(-0.7))),
        ("clipped_both", "data.clipped", changed(&usual(), |_, x| x.clamp(-0.6, 0.6))),
        ("clipped_counts", "data.clipped", changed(&Load { count: 0.01, ..usual() }, |_, x| x.min(0.8))),
        ("rectified", "data.rectified", changed(&usual(), |_, x| x.abs())),
        ("rectified_and_turned", "data.rectified", changed(&usual(), |_, x| -x.abs())),
        ("rectified_of_few_samples", "data.rectified", {
            changed(&Load { rate: 48, cycles: 20.0, noise: 0.01, ..usual() }, |_, x| x.abs())
        }),
        ("rectified_with_noise", "data.rectified", {
            changed(&Load { noise: 0.03, ..usual() }, |_, x| x.abs())
        }),
        ("drift", "data.drift", changed(&usual(), |k, x| x + 1.5 * k as f64 / 2000.0)),
        ("drift_down", "data.drift", changed(&usual(), |k, x| x - 1.2 * k as f64 / 2000.0)),
        ("bow", "data.drift", changed(&usual(), |k, x| x + 3.0 * (k as f64 / 1000.0 - 1.0).powi(2))),
        (
            "bow_of_three_cycles",
            "data.drift",
            changed(&Load { cycles: 3.0, ..usual() }, |k, x| x + 2.0 * (k as f64 / 300.0 - 1.0).powi(2)),
        ),
        ("noise", "data.noise", noise(10.0, 200)),
        ("noise_of_seven_khz", "data.noise", noise(35.0, 2000)),
        ("noise_of_few_cycles", "data.noise", noise(2.0, 100)),
        ("noise_of_many", "data.noise", noise(300.0, 40)),
        ("faster", "data.frequency", loads(&Load { ratio: 1.04, ..usual() })),
        ("slower", "data.frequency", loads(&Load { ratio: 0.93, ..usual() })),
        ("half_as_fast", "data.frequency", loads(&Load { ratio: 0.5, ..usual() })),
        ("a_bit_faster", "data.frequency", loads(&Load { ratio: 1.015, cycles: 40.0, ..usual() })),
        ("faster_of_two_cycles", "data.frequency", loads(&Load { ratio: 1.2, cycles: 2.5, ..usual() })),
        (
            "never_repeats",
            "data.not_periodic",
            changed(&usual(), |k, x| x * (k as f64 / 90.0 + (k as f64 / 300.0).powi(2)).sin()),
        ),
        ("fades", "data.not_periodic", changed(&usual(), |k, x| x * (-(k as f64) / 120.0).exp())),
        ("swings", "data.not_periodic", changed(&usual(), |k, x| x * (1.0 + 0.7 * (k as f64 / 300.0).sin()))),
        ("fails", "data.not_periodic", changed(&usual(), |k, x| x * (1.0 - k as f64 / 2100.0))),
        ("clipped_at_times", "data.clipped", {
            changed(&usual(), |k, x| if k / 200 % 3 == 0 { x.min(0.3) } else { x })
        }),
        ("three_values", "data.coarse", {
            let (phase, channels, purpose) = loads(&usual());
            (phase, channels.iter().map(|x| x.iter().map(|x| x.round()).collect()).collect(), purpose)
        }),
        ("zeros_between", "data.outliers", changed(&usual(), |k, x| if k % 23 == 5 { 0.0 } else { x })),
        (
            "blanked",
            "data.stuck",
            changed(&usual(), |k, x| if (20..60).contains(&(k % 200)) { -2.0 } else { x }),
        ),
        ("motion_with_zeros", "data.outliers", {
            let (phase, mut channels, purpose) =
                motion(&Load { noise: 0.0, ratio: 1.0001, size: 30.0, ..usual() });
            channels[0].iter_mut().step_by(23).for_each(|x| *x = 0.0);
            (phase, channels, purpose)
        }),
        ("motion_that_freezes", "data.stuck", {
            let (phase, mut channels, purpose) = motion(&Load { noise: 0.0, size: 30.0, ..usual() });
            for begin in [200, 600, 1400] {
                let held = channels[0][begin];
                channels[0][begin..begin + 100].fill(held);
            }
            (phase, channels, purpose)
        }),
        ("less_than_two_samples_in_a_cycle", "data.few_samples", {
            let (phase, channels, purpose) = motion(&Load { size: 30.0, ..usual() });
            let kept = |of: &[f64]| of.iter().copied().step_by(107).collect::<Vec<f64>>();
            (kept(&phase), vec![kept(&channels[0])], purpose)
        }),
        ("a_quarter_lost", "data.lost", lost(40)),
        ("bursts_lost", "data.lost", lost(400)),
        ("time_back", "data.time", back(loads(&usual()))),
        ("time_still", "data.time", {
            let (p, c, u) = loads(&usual());
            (vec![0.25; p.len()], c, u)
        }),
        ("time_not_a_number", "data.time", {
            let (mut p, c, u) = loads(&usual());
            p[3] = f64::NAN;
            (p, c, u)
        }),
        ("two_samples_in_a_cycle", "data.few_samples", loads(&Load { rate: 2, cycles: 60.0, ..usual() })),
        (
            "rough_motion",
            "data.rough",
            motion(&Load { size: 30.0, noise: 0.3, rate: 100, cycles: 1.0, ..usual() }),
        ),
        (
            "rough_motion_of_several",
            "data.rough",
            motion(&Load { size: 30.0, noise: 0.15, rate: 140, ..usual() }),
        ),
        (
            "code_of_a_fault",
            "data.outliers",
            changed(&usual(), |k, x| if k % 37 == 5 { 99_999.0 } else { x }),
        ),
        ("no_data", "data.outliers", changed(&usual(), |k, x| if k % 47 < 2 { -999.0 } else { x })),
        ("one_huge_sample", "data.outliers", changed(&usual(), |k, x| if k == 777 { 1e6 } else { x })),
        (
            "drop_outs",
            "data.outliers",
            changed(&Load { mean: 2.0, ..usual() }, |k, x| if k % 17 == 3 { 0.0 } else { x }),
        ),
        (
            "spikes_in_one_cycle",
            "data.outliers",
            changed(&Load { cycles: 1.0, ..usual() }, |k, x| if k % 60 == 7 { x + 5.0 } else { x }),
        ),
        ("wraps_around", "data.wrapped", changed(&usual(), |_, x| (x + 0.8).rem_euclid(1.6) - 0.8)),
        (
            "every_second_reversed",
            "data.alternates",
            changed(&usual(), |k, x| if k % 2 == 0 { x } else { -x }),
        ),
        ("one_column_for_two", "data.equal", {
            let (phase, channels, purpose) = loads(&usual());
            (phase, vec![channels[0].clone(), channels[0].clone()], purpose)
        }),
        ("a_gap_and_another_frequency", "data.frequency", {
            let (phase, channels, purpose) = loads(&Load { ratio: 1.04, ..usual() });
            let kept = |of: &Vec<f64>| -> Vec<f64> {
                of.iter().enumerate().filter(|(k, _)| !(600..620).contains(k)).map(|(_, x)| *x).collect()
            };
            (kept(&phase), channels.iter().map(kept).collect(), purpose)
        }),
        ("slips_by_a_quarter", "data.", {
            let (phase, channels, purpose) = loads(&Load { cycles: 20.0, ..usual() });
            (phase.iter().map(|p| if *p > 9.0 { p + 0.25 } else { *p }).collect(), channels, purpose)
        }),
        ("ends_do_not_meet", "data.ends", {
            let mut data = motion(&Load { size: 30.0, noise: 0.0, cycles: 1.0, ..usual() });
            data.1[0].iter_mut().enumerate().for_each(|(k, x)| *x += 0.01 * k as f64);
            data
        }),
        (
            "half_of_the_motion",
            "data.few_samples",
            motion(&Load { size: 30.0, noise: 0.0, cycles: 0.5, ..usual() }),
        ),
        (
            "motion_of_three_rows",
            "data.few_samples",
            motion(&Load { size: 30.0, noise: 0.0, cycles: 1.0, rate: 3, ..usual() }),
        ),
        ("cut_off_before_noise", "data.clipped", {
            let load = Load { cycles: 20.0, noise: 0.03, ..usual() };
            changed(&load, |k, x| x.min(0.8) + 0.006 * Noise(k as u64 * 31).next())
        }),
        ("both_ends_cut_off", "data.clipped", {
            let load = Load { cycles: 40.0, rate: 60, noise: 0.03, ..usual() };
            changed(&load, |k, x| x.clamp(-0.6, 0.7) + 0.006 * Noise(k as u64 * 31).next())
        }),
        ("two_values", "data.coarse", changed(&usual(), |_, x| x.signum())),
        (
            "four_values",
            "data.coarse",
            changed(&Load { noise: 0.0, ..usual() }, |_, x| (x / 0.7).round() * 0.7),
        ),
        ("a_loose_plug", "data.lost", {
            let (phase, channels, purpose) = loads(&Load { mean: 0.5, ..usual() });
            let still = |of: &Vec<f64>| -> Vec<f64> {
                of.iter().enumerate().map(|(k, x)| if k % 170 < 30 { 0.0 } else { *x }).collect()
            };
            (phase, channels.iter().map(still).collect(), purpose)
        }),
        (
            "swings",
            "data.not_periodic",
            changed(&Load { cycles: 40.0, ..usual() }, |k, x| x * (1.0 + 0.6 * (k as f64 / 400.0).sin())),
        ),
        (
            "motion_of_another_frequency",
            "data.frequency",
            motion(&Load { size: 30.0, noise: 0.0, ratio: 1.04, ..usual() }),
        ),
    ]
}

#[test]
fn right_data_that_look_odd_pass() {
    let all = right();
    let judged: Vec<String> = all
        .iter()
        .map(|(name, data)| (name, found(data)))
        .filter(|(_, found)| !found.is_empty())
        .map(|(name, found)| format!("{name}: {:?}", found.iter().map(Finding::words).collect::<Vec<_>>()))
        .collect();
    assert!(all.len() >= 30 && judged.is_empty(), "of {}: {judged:#?}", all.len());
}

#[test]
fn one_finding_names_all_channels_of_another_frequency_and_a_channel_without_numbers_is_named() {
    let (phase, channels, purpose) = loads(&Load { ratio: 1.03, cycles: 30.0, ..Load::default() });
    let all = found(&(phase, vec![channels[0].clone(), channels[1].clone(), channels[0].clone()], purpose));
    assert_eq!(ids(&all).iter().filter(|id| **id == "data.frequency").count(), 1);
    assert!(all[0].words().starts_with("Fx, Fz, Ty of pass1.csv: repeats at 5.15"), "{}", all[0].words());
    let samples = [1.0, f64::NAN, f64::NAN, 2.0, f64::INFINITY];
    let channel = MeasuredChannel { name: "Fz", unit: "N", samples: &samples };
    let told = not_finite("cell.csv", &channel, 1).unwrap();
    assert!(told.size == 2.0 && told.channel == "Fz" && told.serious, "{told:?}");
    assert_eq!(not_finite("cell.csv", &channel, 3), None);
}

#[test]
fn a_quiet_top_of_a_wing_that_stalls_is_at_most_noted_and_a_clipped_one_is_serious() {
    let stroke = |k: usize| (TAU * k as f64 / 200.0).sin();
    let mut noise = Noise(5);
    let white: Vec<f64> = (0..24_000).map(|_| 1.73 * noise.next()).collect();
    let load = Load { cycles: 60.0, ..Load::default() };
    let stalls = changed(&load, |k, _| {
        let noise = if stroke(k).abs() > 0.75 { 0.012 } else { 0.06 };
        2.0 * (4.0 * stroke(k)).tanh() + noise * white[k]
    });
    let told = found(&stalls);
    assert!(told.iter().all(|finding| !finding.serious), "{told:?}");
    for low in [-1.5, -9.0] {
        let clipped = changed(&load, |k, _| {
            (2.0 * stroke(k) + 0.06 * white[k]).clamp(low, 1.5) + 0.012 * white[12_000 + k]
        });
        let told = found(&clipped);
        assert!(told.iter().any(|finding| finding.id == "data.clipped" && finding.serious), "{told:?}");
    }
}

#[test]
fn noise_that_grows_with_the_load_cuts_nothing_off() {
    let load = Load { cycles: 60.0, ..Load::default() };
    let top = |k: usize| 0.5 + 0.5 * (TAU * k as f64 / 200.0).sin();
    // Quiet where the load is least, and flat there.
    for (quiet, refused) in [(0.01, false), (0.06, true)] {
        let mut noise = Noise(8);
        let white: Vec<f64> = (0..24_000).map(|_| 1.73 * noise.next()).collect();
        let grows = changed(&load, |k, _| {
            let loud = quiet + (0.06 - quiet) * top(k);
            let x = (2.0 * top(k) - 0.7 + loud * white[k]).max(if refused { -0.55 } else { -9.0 });
            x + 0.006 * white[12_000 + k]
        });
        let told = found(&grows);
        assert_eq!(told.iter().any(|finding| finding.id == "data.clipped"), refused, "{told:?}");
    }
}

#[test]
fn a_load_in_whole_units_is_refused_beside_one_that_is_no_finer() {
    let at = |size: f64, k: usize| size * (TAU * k as f64 / 200.0).sin();
    let phase: Vec<f64> = (0..2000).map(|k| f64::from(k) / 200.0).collect();
    let whole = |size: f64| (0..2000).map(|k| (0.5 + at(size, k)).round()).collect::<Vec<f64>>();
    let told = |size: f64| {
        let (fx, fz) = (whole(0.4), whole(size));
        let channels = [("Fx", &fx), ("Fz", &fz)];
        let channels = channels.map(|(name, samples)| MeasuredChannel { name, unit: "N", samples }).into();
        let series = Series {
            what: "taken.csv",
            phase: &phase,
            frequency_hz: None,
            channels,
            purpose: Purpose::Loads,
        };
        let found = of_few_counts(&series, &RunLimits::default());
        found
            .iter()
            .filter(|finding| finding.channel == "Fx")
            .map(|finding| finding.serious)
            .collect::<Vec<_>>()
    };
    assert_eq!(told(2.0), [true]);
    assert_eq!(told(6.0), [false]);
}

#[test]
fn a_channel_reversed_in_one_of_three_passes_is_named_by_its_file() {
    let load = Load::default();
    let pass = |sign: f64, lag: usize| cycle(&load, lag).iter().map(|x| sign * x).collect::<Vec<f64>>();
    let passes = [("a.csv", pass(1.0, 0)), ("b.csv", pass(1.1, 3)), ("c.csv", pass(-1.0, 0))];
    let told = reversed_among("Ty", &passes, &RunLimits::default());
    assert!(told.len() == 1 && told[0].serious && told[0].about.contains("c.csv"), "{told:?}");
    assert!(reversed_among("Ty", &passes[..2], &RunLimits::default()).is_empty());
    assert_eq!(reversed_among("Ty", &passes[1..], &RunLimits::default()).len(), 2);
}

#[test]
fn wrong_data_are_found_by_name() {
    let all = wrong();
    let missed: Vec<String> = all
        .iter()
        .map(|(name, id, data)| (name, id, found(data)))
        .filter(|(_, id, found)| !found.iter().any(|finding| finding.id.starts_with(**id)))
        .map(|(name, id, found)| format!("{name}: {:?} for {id}", ids(&found)))
        .collect();
    assert!(all.len() >= 30 && missed.is_empty(), "of {}: {missed:#?}", all.len());
}

/// Of a load, a size for each cycle from 0 on; its noise stays, as that of a cell does.
fn strokes(load: &Load, size: impl Fn(usize) -> f64) -> Data {
    let of = |seed: u64, power: i32| {
        let mut noise = Noise(seed);
        let one = |p: &f64| load.at(*p) * size(*p as usize).powi(power) + load.noise * 1.73 * noise.next();
        load.phase().iter().map(one).collect::<Vec<f64>>()
    };
    (load.phase(), vec![of(1, 1), of(2, 2)], Purpose::Loads)
}

#[test]
fn strokes_of_several_sizes_are_noted_and_a_gain_that_changes_is_refused() {
    let load = Load { cycles: 40.0, ..Load::default() };
    let bounding = |k: usize| f64::from(u8::from(k % 10 < 7));
    let sweep = |k: usize| 0.4 + 0.2 * (k / 10) as f64;
    let start = |k: usize| f64::from(u8::from(k > 7));
    for size in [&bounding as &dyn Fn(usize) -> f64, &sweep, &start] {
        let told = found(&strokes(&load, size));
        assert!(!told.is_empty() && told.iter().all(|finding| !finding.serious), "{told:?}");
        assert!(told.iter().all(|of| of.id == "data.not_periodic" || of.id == "data.drift"), "{told:?}");
        // A gain changes the noise as well, and one channel fails alone.
        let mut gain = loads(&load);
        let times = |x: &mut Vec<f64>| x.iter_mut().enumerate().for_each(|(k, x)| *x *= 0.05 + size(k / 200));
        times(&mut gain.1[0]);
        let alone = found(&gain);
        times(&mut gain.1[1]);
        for told in [alone, found(&gain)] {
            assert!(told.iter().any(|of| of.id == "data.not_periodic" && of.serious), "{told:?}");
        }
    }
}

/// Whether a finding of that name refuses the data; none where there is none of that name.
fn refuses(data: &Data, id: &str) -> Option<bool> {
    let own = found(data).into_iter().filter(|finding| finding.id == id);
    own.map(|finding| finding.serious && finding.limit.status.is_some()).reduce(|a, b| a || b)
}

#[test]
fn what_is_right_to_average_is_no_datum_of_a_steady_case() {
    let load = Load { cycles: 40.0, ..Load::default() };
    let bounding = strokes(&load, |k| f64::from(u8::from(k % 10 < 7)));
    let knocks = changed(&load, |k, x| if (100..102).contains(&(k % 200)) { x + 2.2 } else { x });
    for (data, id) in [(bounding, "data.not_periodic"), (knocks, "data.wrapped")] {
        assert_eq!(refuses(&data, id), Some(false), "{id}");
        assert_eq!(refuses(&(data.0, data.1, Purpose::Datum), id), Some(true), "{id}");
    }
    assert!(found(&(load.phase(), vec![load.samples(1)], Purpose::Datum)).is_empty());
}

#[test]
fn turns_of_two_sources_are_found_in_a_part_of_a_file_and_of_any_length() {
    let load = Load { cycles: 40.0, ..Load::default() };
    let turns =
        |m: usize, to: usize| changed(&load, |k, x| if k < to && k / m % 2 == 1 { 0.5 * x } else { x });
    for data in [turns(12, 8000), turns(3, 2800), turns(37, 8000)] {
        assert_eq!(refuses(&data, "data.alternates"), Some(true), "{:?}", found(&data));
    }
    // A chopper adds the same to any load.
    let ripple = changed(&load, |k, x| x + if k / 11 % 2 == 1 { 0.6 } else { 0.0 });
    assert_eq!(refuses(&ripple, "data.alternates"), Some(false), "{:?}", found(&ripple));
    // What rings after a knock keeps step with the cycle.
    let rings = changed(&load, |k, x| {
        let after = (k % 200) as f64 - 60.0;
        if after < 0.0 { x } else { x + 2.0 * (-after / 30.0).exp() * (TAU * after / 10.0).cos() }
    });
    assert_ne!(refuses(&rings, "data.alternates"), Some(true), "{:?}", found(&rings));
}

#[test]
fn counts_that_wrap_around_for_a_moment_are_told_from_a_knock() {
    let load = Load { cycles: 40.0, noise: 0.01, ..Load::default() };
    let clean = Load { noise: 0.0, ..load.clone() }.samples(1);
    let (low, high) = clean.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    let range = high - low;
    for depth in [0.06, 0.12] {
        let [from, width] = [low - 0.05 * range, (1.05 - depth) * range];
        let wraps = changed(&load, |_, x| (x - from).rem_euclid(width) + from);
        assert_eq!(refuses(&wraps, "data.wrapped"), Some(true), "{:?}", found(&wraps));
    }
    let least = clean[..200].iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |of| of.0);
    let knock = changed(&load, |k, x| if (k + 202 - least) % 200 < 5 { x + range } else { x });
    assert!(found(&knock).iter().all(|of| !of.serious), "{:?}", found(&knock));
}

#[test]
fn magnitudes_rows_out_of_order_and_backwards_are_refused() {
    let load = Load { cycles: 40.0, mean: 0.35, ..Load::default() };
    let magnitudes = changed(&load, |_, x| x.abs());
    assert_eq!(refuses(&magnitudes, "data.rectified"), Some(true), "{:?}", found(&magnitudes));

    let mut shuffled = loads(&load);
    let (mut noise, count) = (Noise(3), shuffled.1[0].len());
    (1..count).rev().for_each(|k| shuffled.1[0].swap(k, (0.5 * (noise.next() + 1.0) * k as f64) as usize));
    assert_eq!(refuses(&shuffled, "data.noise"), Some(true), "{:?}", found(&shuffled));
    // A channel without a load has the noise of the others.
    let mut idle = loads(&load);
    idle.1.push((0..count).map(|_| 0.3 * noise.next()).collect());
    idle.1[0].iter_mut().for_each(|x| *x += 0.3 * noise.next());
    assert_eq!(refuses(&idle, "data.noise"), None, "{:?}", found(&idle));

    let mut backwards = loads(&load);
    backwards.1.iter_mut().for_each(|x| x[2000..4000].reverse());
    assert_eq!(refuses(&backwards, "data.backwards"), Some(true), "{:?}", found(&backwards));
}

#[test]
fn copies_are_found_in_the_channel_of_fewer_counts_too() {
    let load = Load { cycles: 40.0, count: 0.01, ..Load::default() };
    let mut data = loads(&load);
    data.1[1] = Load { count: 0.0, ..load.clone() }.samples(2);
    data.1[0].copy_within(1000..3000, 5111);
    assert_eq!(refuses(&data, "data.copied"), Some(true), "{:?}", found(&data));
}

#[test]
fn a_temperature_beside_loads_does_not_rest_with_them() {
    let load = Load { cycles: 40.0, noise: 0.0, count: 0.01, ..Load::default() };
    let rests = |k: usize, x: f64| if (2000..2400).contains(&k) { 0.1 } else { x };
    let of = |seed: u64| load.samples(seed).into_iter().enumerate().map(|(k, x)| rests(k, x)).collect();
    let samples: [Vec<f64>; 3] = [of(1), of(2), load.phase().iter().map(|p| 20.0 + 0.1 * p).collect()];
    let units = [("Fx", "mN"), ("Fz", "kgf"), ("temp", "degC")];
    let channels =
        units.iter().zip(&samples).map(|((name, unit), samples)| MeasuredChannel { name, unit, samples });
    let phase = load.phase();
    let series = Series {
        what: "a",
        phase: &phase,
        frequency_hz: None,
        channels: channels.collect(),
        purpose: Purpose::Loads,
    };
    let told = examined(&series, &RunLimits::default());
    let stuck: Vec<&Finding> = told.iter().filter(|of| of.id == "data.stuck").collect();
    assert!(!stuck.is_empty() && stuck.iter().all(|of| !of.serious), "{told:?}");
}

#[test]
fn bouts_with_rests_keep_the_frequency_of_their_strokes() {
    let load = Load { cycles: 60.0, more: [0.3, 0.1], ..Load::default() };
    for (on, off) in [(7, 3), (5, 5), (8, 2)] {
        let (phase, channels, _) = strokes(&load, |k| f64::from(u8::from(k % (on + off) < on)));
        let time: Vec<f64> = phase.iter().map(|p| p / 5.0).collect();
        let told = line(&time, &channels).frequency.unwrap_or(f64::NAN);
        assert!((told - 5.0).abs() < 0.01, "{on} of {}: {told} Hz", on + off);
    }
    // A clap in each cycle of a load that has two peaks is no bout.
    let mut noise = Noise(5);
    let samples: Vec<f64> = (0..8000)
        .map(|k| {
            let p = f64::from(k) / 200.0;
            let clap = if p.fract() < 0.03 { 2.0 } else { 0.0 };
            (2.0 * TAU * p).cos() + 0.1 * (TAU * p).sin() - clap + 0.02 * noise.next()
        })
        .collect();
    let time: Vec<f64> = (0..8000).map(|k| f64::from(k) * 1e-3).collect();
    let told = line(&time, &[samples]).frequency.unwrap_or(f64::NAN);
    assert!((told - 5.0).abs() < 0.01, "{told} Hz");
}

#[test]
fn dense_spikes_a_code_in_each_cycle_and_a_gain_without_noise_are_no_knock_and_no_stroke() {
    let load = Load { cycles: 60.0, ..Load::default() };
    let mut noise = Noise(3);
    let at: Vec<bool> = (0..12_000).map(|_| noise.next().abs() < 0.04).collect();
    let spikes = changed(&load, |k, x| if at[k] { x + 4.0 * (k as f64 * 0.7).sin() } else { x });
    let code = changed(&load, |k, x| if k % 200 == 77 { -9.99 } else { x });
    for data in [&spikes, &code] {
        assert!(found(data).iter().any(|of| of.id == "data.outliers" && of.serious), "{:?}", found(data));
    }
    let exact = Load { noise: 0.0, count: 0.01, cycles: 40.0, ..Load::default() };
    let mut sag = loads(&exact);
    let halved = |x: &mut Vec<f64>| x.iter_mut().skip(4000).for_each(|x| *x *= 0.5);
    sag.1.iter_mut().for_each(halved);
    assert!(found(&sag).iter().any(|of| of.serious), "{:?}", found(&sag));
    // A chopper adds the same ripple all the time.
    let chopped = changed(&load, |k, x| if k / 3 % 2 == 0 { x + 0.05 } else { x - 0.05 });
    assert!(found(&chopped).iter().all(|of| !of.serious), "{:?}", found(&chopped));
}

#[test]
fn a_knock_at_an_extreme_is_noted_and_counts_that_wrap_around_are_refused() {
    let load = Load { more: [0.0, 0.0], ..Load::default() };
    for width in [1, 3, 6] {
        let knock = |k: usize, x: f64| if (100..100 + width).contains(&(k % 200)) { x + 2.2 } else { x };
        let told = found(&changed(&load, knock));
        assert!(ids(&told).contains(&"data.wrapped") && told.iter().all(|of| !of.serious), "{told:?}");
    }
    let wraps = changed(&load, |_, x| (x + 0.8).rem_euclid(1.6) - 0.8);
    assert!(found(&wraps).iter().any(|of| of.id == "data.wrapped" && of.serious));
    // A knock of another height, wherever it stands, comes with the cycle.
    let knock = changed(&load, |k, x| if [37, 120].contains(&(k % 200)) { x - 3.0 } else { x });
    assert!(found(&knock).iter().all(|of| !of.serious), "{:?}", found(&knock));
}

#[test]
fn copies_are_found_wherever_they_lie_and_of_few_counts() {
    let copied = |load: &Load, from: usize, to: usize, count: usize| {
        let mut data = loads(load);
        data.1.iter_mut().for_each(|x| x.copy_within(from..from + count, to));
        data
    };
    let load = Load { cycles: 40.0, ..Load::default() };
    let serious = |data: &Data| found(data).iter().any(|of| of.id == "data.copied" && of.serious);
    for (from, to) in [(0, 2000), (130, 5010), (2777, 4800), (4000, 6000)] {
        assert!(serious(&copied(&load, from, to, 1000)), "{from} to {to}");
    }
    for count in [0.05, 0.2] {
        let coarse = Load { count, ..load.clone() };
        assert!(serious(&copied(&coarse, 400, 4123, 2400)), "counts of {count}");
        assert!(!ids(&found(&loads(&coarse))).contains(&"data.copied"), "counts of {count}");
    }
    let exact = Load { noise: 0.0, count: 0.05, ..load.clone() };
    assert!(!ids(&found(&loads(&exact))).contains(&"data.copied"));
    // Samples that are missing put a load without noise out of step with itself.
    let exact = Load { noise: 0.0, count: 1e-4, cycles: 14.0, rate: 2000, ..load };
    let mut data = loads(&exact);
    for lost in [23_001, 9_400, 3_017] {
        data.0.remove(lost);
        data.1.iter_mut().for_each(|x| {
            x.remove(lost);
        });
    }
    assert!(!ids(&found(&data)).contains(&"data.copied"), "{:?}", found(&data));
}

#[test]
fn two_sources_by_turns_and_a_code_within_the_range_are_found_and_a_line_is_not_one() {
    let load = Load { cycles: 20.0, ..Load::default() };
    for turn in 3..=8 {
        let told = found(&changed(&load, |k, x| if k / turn % 2 == 0 { x } else { 0.6 * x + 0.1 }));
        assert!(told.iter().any(|of| of.id == "data.alternates" && of.serious), "{turn}: {told:?}");
        let line = |k: usize, x: f64| x + 0.1 * (TAU * (k as f64 + 0.3) / (2 * turn) as f64).sin();
        let told = found(&changed(&load, line));
        assert!(told.iter().all(|of| !of.serious), "{turn}: {told:?}");
    }
    let mut noise = Noise(77);
    let at: Vec<bool> = (0..4000).map(|_| noise.next().abs() < 0.013).collect();
    for count in [0.0, 0.05] {
        let told = found(&changed(&Load { count, ..load.clone() }, |k, x| if at[k] { 0.3 } else { x }));
        assert!(told.iter().any(|of| of.id == "data.outliers" && of.serious), "{count}: {told:?}");
    }
}

#[test]
fn a_motion_in_steps_and_one_that_runs_away_are_told() {
    let load = Load { size: 35.0, noise: 0.0, more: [0.1, 0.0], rate: 100, ..Load::default() };
    let steps = motion(&Load { count: 15.0, ..load.clone() });
    assert!(ids(&found(&steps)).contains(&"data.coarse"), "{:?}", found(&steps));
    for fine in [0.1, 1.0] {
        let told = found(&motion(&Load { count: fine, ..load.clone() }));
        assert!(!ids(&told).contains(&"data.coarse"), "{fine}: {told:?}");
    }
    for (ratio, is) in [(1.003, true), (0.997, true), (1.0005, false)] {
        let told = found(&motion(&Load { ratio, ..load.clone() }));
        assert_eq!(ids(&told).contains(&"data.runs_away"), is, "{ratio}: {told:?}");
        assert!(told.iter().all(|of| !of.serious), "{ratio}: {told:?}");
    }
}

#[test]
fn loads_that_run_away_from_the_clock_by_more_than_the_tolerance_of_a_shift_are_refused() {
    // Drifts of 5.4, 54 and 86 deg in 30 cycles.
    for (ratio, refused) in [(1.0005, false), (1.005, true), (0.992, true)] {
        let (phase, channels, _) = loads(&Load { ratio, cycles: 30.0, ..Load::default() });
        for (purpose, refused) in [(Purpose::Datum, refused), (Purpose::Loads, false)] {
            let told = found(&(phase.clone(), channels.clone(), purpose));
            let serious: Vec<_> = told.iter().filter(|of| of.serious).map(|of| of.id).collect();
            assert_eq!(serious.contains(&"data.runs_away"), refused, "{ratio}: {told:?}");
        }
    }
}

#[test]
fn a_limit_lies_between_what_passes_and_what_does_not() {
    let drift = |size: f64| changed(&Load::default(), move |k, x| x + size * k as f64 / 2000.0);
    let stuck =
        |n: usize| changed(&Load::default(), move |k, x| if (400..400 + n).contains(&k) { 0.5 } else { x });
    let ratio = |ratio: f64| loads(&Load { ratio, cycles: 60.0, ..Load::default() });
    let lost = |n: usize| {
        let (phase, channels, purpose) = loads(&Load::default());
        let kept = move |of: &Vec<f64>| -> Vec<f64> {
            of.iter().enumerate().filter(|(k, _)| !(600..600 + n).contains(k)).map(|(_, x)| *x).collect()
        };
        (kept(&phase), channels.iter().map(kept).collect::<Vec<_>>(), purpose)
    };
    let spikes = |size: f64| changed(&Load::default(), move |k, x| if k % 100 == 7 { x + size } else { x });
    let apart = |by: f64| {
        let mut data = motion(&Load { size: 30.0, noise: 0.0, cycles: 1.0, rate: 100, ..Load::default() });
        data.1[0].iter_mut().enumerate().for_each(|(k, x)| *x += by * k as f64 / 100.0);
        data
    };
    let rough = |noise: f64| motion(&Load { size: 30.0, noise, rate: 100, cycles: 1.0, ..Load::default() });
    for (id, below, above) in [
        ("data.drift", drift(0.35), drift(0.6)),
        ("data.stuck", stuck(110), stuck(130)),
        ("data.frequency", ratio(1.009), ratio(1.011)),
        ("data.lost", lost(95), lost(110)),
        ("data.rough", rough(0.02), rough(0.06)),
        ("data.outliers", spikes(1.8), spikes(3.0)),
        ("data.ends", apart(0.3), apart(3.0)),
    ] {
        assert!(!ids(&found(&below)).contains(&id), "{id}: {:?}", found(&below));
        assert!(ids(&found(&above)).contains(&id), "{id}: {:?}", found(&above));
    }
}

#[test]
fn a_frequency_is_estimated_with_its_error() {
    for (ratio, cycles, noise) in [(1.04, 10.0, 0.1), (0.8, 4.0, 0.3), (1.0, 50.0, 1.0), (0.5, 20.0, 0.02)] {
        let load = Load { ratio, cycles, noise, ..Load::default() };
        let of = estimate(&load.phase(), &load.samples(5)).unwrap();
        assert!((of.ratio - ratio).abs() < 5.0 * of.error + 2e-3 / cycles, "{ratio}: {of:?}");
        assert!(of.error < 0.01 && of.explained > 0.3, "{of:?}");
    }
    assert_eq!(estimate(&[0.0, 0.5], &[1.0, 2.0]), None);
}

/// A cycle of 360 phases, later by `lag` deg.
fn cycle(load: &Load, lag: usize) -> Vec<f64> {
    (0..360).map(|k| load.at((k + 360 - lag) as f64 / 360.0)).collect()
}

fn beside(measured: &[Vec<f64>; 3]) -> Vec<Finding> {
    let names = ["Fx", "Fz", "Ty"];
    let own = [
        Load::default(),
        Load { size: 0.15, more: [6.0, 0.0], ..Load::default() },
        Load { size: 0.01, more: [-0.5, 0.3], ..Load::default() },
    ];
    let computed = own.map(|load| cycle(&load, 0));
    let pairs: Vec<CyclePair> = (0..3)
        .map(|i| CyclePair {
            name: names[i],
            unit: if i == 2 { "N m" } else { "N" },
            measured: &measured[i],
            computed: &computed[i],
        })
        .collect();
    compared("pass1.csv", &pairs, &RunLimits::default())
}

#[test]
fn what_is_computed_judges_sign_order_gain_and_phase() {
    let own = [
        Load::default(),
        Load { size: 0.15, more: [6.0, 0.0], ..Load::default() },
        Load { size: 0.01, more: [-0.5, 0.3], ..Load::default() },
    ];
    let at = |lag: usize| own.clone().map(|load| cycle(&load, lag));
    let times = |i: usize, by: f64| {
        let mut all = at(0);
        all[i].iter_mut().for_each(|x| *x *= by);
        all
    };
    let [fx, fz, ty] = at(0);
    assert!(beside(&at(0)).is_empty() && beside(&at(4)).is_empty() && beside(&times(0, 1.08)).is_empty());
    for (id, measured) in [
        ("data.reversed", times(0, -1.0)),
        ("data.reversed", times(2, -0.7)),
        ("data.scaled", times(1, 1.15)),
        ("data.scaled", times(0, 0.85)),
        ("data.scaled", times(2, 1e3)),
        ("data.dead", times(2, 0.001)),
        ("data.dead", [fx.clone(), vec![0.1; 360], ty.clone()]),
        ("data.shift", at(9)),
        ("data.shift", at(352)),
        ("data.swapped", [fx.clone(), fx.clone(), ty.clone()]),
        ("data.swapped", [fz, fx.clone(), ty.clone()]),
    ] {
        assert!(ids(&beside(&measured)).contains(&id), "{id}: {:?}", beside(&measured));
    }
    let mix = |i: usize, j: usize, part: f64| {
        let mut all = at(0);
        let other = all[j].clone();
        all[i].iter_mut().zip(other).for_each(|(x, y)| *x += part * y);
        all
    };
    let bent = |by: f64| {
        let mut all = at(0);
        all[0].iter_mut().for_each(|x| *x = if *x < 0.0 { by * *x } else { *x });
        all
    };
    let mut late = at(0);
    late[0] = cycle(&own[0], 90);
    for (id, right, wrong) in [
        ("data.mixed", mix(1, 0, 0.03), mix(1, 0, 0.5)),
        ("data.mixed", mix(0, 1, 0.03), mix(0, 1, -0.6)),
        ("data.bent", bent(0.95), bent(0.4)),
        ("data.lags", at(9), late),
        (
            "data.scaled",
            times(1, 1.05),
            [fx.clone(), fx.iter().map(|x| 100.0 * x * x * x).collect(), ty.clone()],
        ),
    ] {
        assert!(!ids(&beside(&right)).contains(&id), "{id}: {:?}", beside(&right));
        assert!(ids(&beside(&wrong)).contains(&id), "{id}: {:?}", beside(&wrong));
    }
    // The largest but one of its unit is noise, or a harmonic that is not computed, where the others fit.
    let mut noise = Noise(8);
    let white: Vec<f64> = (0..360).map(|_| 0.3 * noise.next()).collect();
    for other in [white, (0..360).map(|k| (TAU * 5.0 * f64::from(k) / 360.0).sin()).collect()] {
        let found = beside(&[fx.clone(), other, ty.clone()]);
        assert!(
            found.iter().any(|f| f.id == "data.unlike" && !f.serious && f.about.starts_with("Fz")),
            "{found:?}"
        );
    }
    assert!(beside(&times(2, 1e3)).iter().any(|finding| finding.serious));
    assert!(beside(&times(1, 1.15)).iter().all(|finding| !finding.serious));
    let mut noise = Noise(4);
    let other = at(0).map(|x| x.iter().map(|_| noise.next()).collect::<Vec<f64>>());
    assert!(ids(&beside(&other)).contains(&"data.unrelated"), "{:?}", beside(&other));
}

#[test]
fn a_file_that_runs_backwards_is_told_beside_what_is_computed() {
    let own = [
        Load { more: [0.5, 0.3], ..Load::default() },
        Load { size: 0.15, more: [6.0, 0.0], ..Load::default() },
        Load { size: 0.01, more: [-0.5, 0.3], ..Load::default() },
    ];
    let at = |lag: usize, back: bool| {
        own.clone().map(|load| {
            let mut of = cycle(&load, lag);
            if back {
                of.reverse();
            }
            of
        })
    };
    let told = |of: &[Vec<f64>; 3]| beside(of).iter().any(|of| of.id == "data.backwards" && of.serious);
    assert!(told(&at(0, true)) && told(&at(100, true)), "{:?}", beside(&at(0, true)));
    assert!(!told(&at(0, false)) && !told(&at(100, false)), "{:?}", beside(&at(100, false)));
}

#[test]
fn a_serious_finding_is_a_status_and_a_warning_that_a_limit_takes_back() {
    let data = changed(&Load::default(), |k, x| x + 0.9 * k as f64 / 2000.0);
    let limits = RunLimits::default();
    let mut judge = Judge::new(&limits);
    let finding = found(&data).remove(0).mended_by(Some("process.steps.drift".into()));
    finding.clone().put(&mut judge);
    let verdict = judge.verdict();
    assert_eq!(verdict.status, Status::SuspectData);
    assert_eq!(verdict.warnings[0].key.as_deref(), Some("process.steps.drift"));
    assert!(verdict.reason.unwrap().contains("limits.data.drift_fraction"));
    let mut judge = Judge::new(&limits);
    finding.noted().put(&mut judge);
    assert_eq!(judge.verdict().status, Status::Ok);
    let wider = RunLimits::default().with("data.drift_fraction", 1.0).unwrap();
    let channels = vec![MeasuredChannel { name: "Fx", unit: "N", samples: &data.1[0] }];
    let series = Series { what: "a", phase: &data.0, frequency_hz: None, channels, purpose: Purpose::Loads };
    assert!(examined(&series, &wider).is_empty());
}

/// Six channels at `rate` Hz for `seconds`, of a wing at `frequency` Hz with noise, one of them idle.
fn six(
    frequency: f64,
    rate: f64,
    seconds: f64,
    noise: f64,
    amplitudes: [[f64; 3]; 6],
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut random = Noise(11);
    let time: Vec<f64> = (0..(seconds * rate) as usize).map(|k| k as f64 / rate).collect();
    let channel = |amplitudes: &[f64; 3]| {
        let at = |t: &f64| {
            let harmonic =
                |(n, a): (usize, &f64)| a * (TAU * (n + 1) as f64 * frequency * t + 0.3 * n as f64).cos();
            let load: f64 = amplitudes.iter().enumerate().map(harmonic).sum();
            0.2 + load + noise * random.next()
        };
        time.iter().map(at).collect()
    };
    let channels = amplitudes.iter().map(channel).collect();
    (time, channels)
}

fn line(time: &[f64], channels: &[Vec<f64>]) -> SpectralLine {
    let all: Vec<MeasuredChannel> =
        channels.iter().map(|samples| MeasuredChannel { name: "F", unit: "N", samples }).collect();
    find_frequency(time, &all, RunLimits::default().of(&limits::data::LINE).0)
}

#[test]
fn the_frequency_is_found_without_one_given_and_its_error_is_that_of_the_noise() {
    let usual = [[1.0, 0.3, 0.1], [0.0; 3], [2.0, 0.1, 0.0], [0.0, 0.4, 0.0], [0.1, 0.0, 0.0], [0.0; 3]];
    let mut beyond = 0;
    for (k, frequency) in [3.4973, 5.0, 5.2, 17.31, 0.913, 24.6].into_iter().enumerate() {
        for noise in [0.0, 0.2, 1.0] {
            let (time, mut channels) = six(frequency, 1000.0, 10.0 + k as f64, noise, usual);
            // A dead channel has no say.
            channels[5].fill(0.0);
            let line = line(&time, &channels);
            let told = line.frequency.unwrap_or(f64::NAN);
            assert!((told - frequency).abs() < 1e-3, "{frequency} Hz, noise {noise}: {line:?}");
            beyond += usize::from((told - frequency).abs() > 3.0 * line.error.max(1e-7));
        }
    }
    assert!(beyond <= 1, "{beyond} of 18 lie beyond three standard errors");
}

#[test]
fn a_strongest_harmonic_is_told_from_the_frequency() {
    for (amplitudes, frequency) in [
        ([[0.05, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.7, 0.1], [0.0; 3], [0.0; 3], [0.0; 3]], 4.1),
        ([[0.1, 0.0, 1.0], [0.0, 0.2, 1.0], [0.0, 0.0, 0.4], [0.0; 3], [0.0; 3], [0.0; 3]], 4.1),
        ([[0.0, 1.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.7, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]], 8.2),
    ] {
        let (time, channels) = six(4.1, 1000.0, 12.0, 0.1, amplitudes);
        let line = line(&time, &channels);
        assert!((line.frequency.unwrap_or(f64::NAN) - frequency).abs() < 1e-3, "{line:?}");
    }
}

#[test]
fn lines_of_another_machine_and_of_held_values_make_no_subharmonic() {
    let time: Vec<f64> = (0..10_000).map(|k| f64::from(k) * 1e-3).collect();
    let mut noise = Noise(21);
    let mut of =
        |at: &dyn Fn(f64) -> f64| -> Vec<f64> { time.iter().map(|t| at(*t) + 0.02 * noise.next()).collect() };
    let load = |t: f64| (TAU * 5.2 * t).cos() + 0.4 * (TAU * 10.4 * t).sin();
    let two = of(&|t| load(t) + 0.8 * (TAU * 7.3 * t).cos());
    let held = of(&|t| load((t * 25.0).floor() / 25.0));
    for channel in [two, held] {
        let line = line(&time, &[channel]);
        assert!((line.frequency.unwrap_or(f64::NAN) - 5.2).abs() < 0.02, "{line:?}");
    }
}

#[test]
fn noise_drift_and_rest_have_no_line() {
    let limit = limits::data::LINE.value;
    let mut largest = 0.0_f64;
    for seed in 0..200 {
        let mut noise = Noise(seed);
        let time: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        let channels: Vec<Vec<f64>> = (0..6).map(|_| time.iter().map(|_| noise.next()).collect()).collect();
        let line = line(&time, &channels);
        largest = largest.max(line.over_noise);
        assert_eq!(line.frequency, None, "{line:?}");
    }
    assert!(largest < limit, "{largest}");
    let time: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
    let mut walk = Noise(5);
    let mut at = 0.0;
    let walked: Vec<f64> = time
        .iter()
        .map(|_| {
            at += walk.next();
            at
        })
        .collect();
    let warming: Vec<f64> = time.iter().map(|t| 1.0 - (-t / 2.0).exp()).collect();
    for (what, channel) in [("walk", walked), ("warming", warming), ("rest", vec![0.3; 4000])] {
        let line = line(&time, &[channel]);
        assert_eq!(line.frequency, None, "{what}: {line:?}");
    }
    assert_eq!(line(&[], &[]).frequency, None);
}

/// A load of few counts whose gaps were bridged is flat at its ends, but not cut off.
#[test]
fn loads_are_told_as_cut_off_where_they_were_recorded() {
    let count = 1.0 / 320.0;
    let noise = |k: usize| 0.3 * count * ((k as f64 * 12.9898).sin() * 43_758.545_3).fract();
    let load = |k: usize| 0.025 * (TAU * k as f64 / 2000.0).sin() - 0.2 + noise(k);
    let counts = |x: f64| (x / count).round() * count;
    let quantised: Vec<f64> = (0..20_000).map(|k| counts(load(k))).collect();
    let mut bridged = quantised.clone();
    (25..19_999).step_by(50).for_each(|k| bridged[k] = 0.5 * (quantised[k - 1] + quantised[k + 1]));
    let clipped: Vec<f64> = (0..20_000).map(|k| counts(load(k)).min(counts(-0.19))).collect();
    let told = |samples: &[f64]| {
        let phase: Vec<f64> = (0..samples.len()).map(|k| k as f64 / 2000.0).collect();
        let channels = vec![MeasuredChannel { name: "Fy", unit: "N", samples }];
        let series =
            Series { what: "file", phase: &phase, frequency_hz: None, channels, purpose: Purpose::Loads };
        cut_off(&series, &RunLimits::default()).iter().map(|finding| finding.id).collect::<Vec<_>>()
    };
    assert!(told(&quantised).is_empty() && told(&bridged).is_empty());
    assert_eq!(told(&clipped), ["data.clipped"]);
}

#[test]
fn the_mean_that_is_furthest_from_the_model_is_told() {
    let wave = |mean: f64, size: f64| -> Vec<f64> {
        (0..64).map(|k| mean + size * (TAU * f64::from(k) / 64.0).sin()).collect()
    };
    let [fy, fz, off] = [wave(0.05, 0.01), wave(0.2, 0.5), wave(0.1, 0.01)];
    let of = |measured: &[f64]| {
        let pair = |name, measured, computed| CyclePair { name, unit: "N", measured, computed };
        mean_apart("run", &[pair("Fy", measured, &fy), pair("Fz", &fz, &fz)]).unwrap()
    };
    let limits = RunLimits::default();
    assert!(!of(&fy).breaks(&limits));
    let told = of(&off);
    // Of the larger range of the unit a twentieth counts at least.
    assert!(told.breaks(&limits) && told.channel == "Fy" && (told.size - 1.0).abs() < 1e-6, "{told:?}");
    assert!(told.text.contains("the fixture's mass"));
}
