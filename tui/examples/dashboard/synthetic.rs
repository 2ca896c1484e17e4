//! A synthetic session as a stream of events, always the same: for the example and for the tests of the screen.

use std::f64::consts::TAU;

use participant_texts::Instruction;
use tui::ScreenView;
use tui::action::AttemptName;
use tui::event::{
    BenchFacts, BenchLine, CalibrationFact, ComplexImpedance, ContactCurves, Crop, CropStretch,
    Event, FitView, LineStates, Live, LogLevel, LostDevices, NoEstimate, Outlook, PartFact,
    PeriodTrace, PhaseKind, PhaseView, SafetyView, SessionHeader, SystemHealth, TrialVerdict,
    ValueAndStd,
};

const PLATE_M: f64 = 0.105;
const SPEED_M_PER_S: f64 = 0.05;
const TRIALS: u32 = 4;
const LIVE_HZ: f64 = 100.0;

/// Returns the events of the session with their times in s, in order.
pub fn session() -> Vec<(f64, Event)> {
    let mut script = Script {
        now_s: 0.0,
        events: Vec::new(),
    };
    script.say(Event::Session(SessionHeader {
        replayed: false,
        participant: Some("sub-01".to_owned()),
        protocol: Some("huloux2021".to_owned()),
        study: Some("studies/pilot".to_owned()),
        calibration_label: Some("calibrated 2026-03-02".to_owned()),
        uncalibrated: false,
        simulated: true,
        plate_length_m: PLATE_M,
        kept_m: Some((0.0225, 0.0825)),
    }));
    script.say(Event::ForceBand {
        min_n: 0.5,
        max_n: 0.8,
    });
    script.say(Event::Bench(facts()));
    script.health(0);
    script.safety(SafetyView::Armed, None);
    script.log(LogLevel::Info, "carrier 35.000 kHz, Q 251");
    script.baseline();
    script.trial(1, 1, true, 0.66);
    script.trial(1, 1, false, 0.64);
    script.trial(2, 1, false, 0.93);
    script.trial(2, 2, false, 0.71);
    script.say(Event::Phase(PhaseView {
        countdown: Some(30),
        ..phase(PhaseKind::Rest, 2, 2, false)
    }));
    script.run(2.0, Finger::Away, 0.0);
    script.events
}

/// Returns the events of a trip by a force above its limit.
#[allow(dead_code, reason = "the tests use it, the example does not")]
pub fn trip() -> Vec<Event> {
    vec![
        Event::Safety {
            state: SafetyView::Tripped,
            reason: Some("normal force 5.3 N over the limit of 5.0 N".to_owned()),
        },
        Event::Phase(phase(PhaseKind::Paused, 2, 1, false)),
        Event::Log {
            level: LogLevel::Error,
            text: "drive stopped: normal force 5.3 N over the limit of 5.0 N".to_owned(),
        },
    ]
}

/// Returns the events that end the session.
pub fn finish() -> Vec<Event> {
    vec![
        Event::Safety {
            state: SafetyView::Disarmed,
            reason: None,
        },
        Event::Phase(PhaseView::new(PhaseKind::Finished)),
        Event::Finished {
            summary: vec![
                "4 of 4 trials accepted, 1 repeated".to_owned(),
                "mean normal force 0.68 N, 31 instances".to_owned(),
                "no samples lost".to_owned(),
                "recorded in studies/pilot/sub-01".to_owned(),
            ],
        },
    ]
}

#[derive(Clone, Copy)]
enum Finger {
    Away,
    Still,
    Moving,
}

struct Script {
    now_s: f64,
    events: Vec<(f64, Event)>,
}

fn phase(kind: PhaseKind, trial: u32, attempt: u32, practice: bool) -> PhaseView {
    PhaseView {
        trial,
        trials: if practice { 1 } else { TRIALS },
        attempt,
        practice,
        explorations: 2,
        ..PhaseView::new(kind)
    }
}

impl Script {
    fn say(&mut self, event: Event) {
        self.events.push((self.now_s, event));
    }

    fn log(&mut self, level: LogLevel, text: &str) {
        self.say(Event::Log {
            level,
            text: text.to_owned(),
        });
    }

    fn safety(&mut self, state: SafetyView, reason: Option<&str>) {
        self.say(Event::Safety {
            state,
            reason: reason.map(str::to_owned),
        });
    }

    fn health(&mut self, lost_frames: u64) {
        self.say(Event::Health(SystemHealth {
            xruns_in: u64::from(lost_frames > 0),
            xruns_out: 0,
            ring_fill: 0.04,
            clock_drift_ppm: Some(12.3),
            clock_residual_s: None,
            clock_off: false,
            recorder_lag_s: 0.21,
            frames: (self.now_s * 192_000.0) as u64,
            lost_frames,
            force_rate_hz: Some(9_998.0),
            speed: 1.0,
            disk_free_bytes: Some(412_000_000_000),
            disk_sessions: Some(29),
            force_faults: 0,
            encoder_skipped: 0,
            cores: Some(0.34),
            lines: LineStates {
                estop_open: Some(false),
                heartbeat_beats: None,
                button_pressed: Some(false),
                ..LineStates::default()
            },
            lost: LostDevices::default(),
        }));
    }

    fn baseline(&mut self) {
        self.safety(SafetyView::Driving, None);
        self.say(Event::Phase(PhaseView::new(PhaseKind::Baseline)));
        self.tell(Instruction::LiftFinger, (0, 0), None, None);
        self.run(2.0, Finger::Away, 0.0);
        self.log(LogLevel::Info, "unloaded plate 7.02 − 0.03i N·s/m");
    }

    fn trial(&mut self, trial: u32, attempt: u32, practice: bool, force_n: f64) {
        let phase_event = |kind, exploration, countdown| {
            Event::Phase(PhaseView {
                exploration,
                countdown,
                ..phase(kind, trial, attempt, practice)
            })
        };
        let name = AttemptName {
            trial,
            practice,
            attempt,
        };
        let place = (trial, if practice { 1 } else { TRIALS });
        let remaining = if practice {
            TRIALS + 1
        } else {
            TRIALS + 1 - trial
        };
        self.say(Event::Outlook(Outlook {
            left_s: f64::from(remaining) * 25.0,
            trials_left: remaining,
            repetitions_of_trial: 3 - attempt,
            repetitions_in_session: 9,
            next: Some("the countdown".to_owned()),
            then: Some("exploration 1 of 2, left to right".to_owned()),
        }));
        self.say(phase_event(PhaseKind::Ready, 0, None));
        self.tell(Instruction::PlaceFinger, place, None, None);
        self.run(1.5, Finger::Away, 0.0);
        for exploration in 1..=2 {
            for count in (1..=3).rev() {
                self.say(phase_event(PhaseKind::Countdown, exploration, Some(count)));
                self.tell(Instruction::GetReady, place, Some(count), None);
                self.run(0.7, Finger::Still, force_n);
            }
            self.say(phase_event(PhaseKind::Exploration, exploration, None));
            self.tell(Instruction::FollowSlider, place, None, None);
            let began_s = self.now_s;
            self.run(PLATE_M / SPEED_M_PER_S, Finger::Moving, force_n);
            let crop = crop(name, (exploration, began_s), force_n);
            self.say(Event::Crop(crop));
            self.say(phase_event(PhaseKind::Feedback, exploration, None));
            self.tell(Instruction::Feedback, place, None, Some(force_n));
            self.run(1.5, Finger::Away, 0.0);
        }
        let accepted = force_n <= 0.8;
        self.say(Event::Verdict(TrialVerdict {
            trial,
            practice,
            attempt,
            accepted,
            interrupted: false,
            reasons: if accepted {
                Vec::new()
            } else {
                vec![format!("normal force {force_n:.2} N, above 0.8 N")]
            },
            brief: if accepted {
                Vec::new()
            } else {
                vec![vec![
                    format!("force {force_n:.2} N"),
                    "band 0.50–0.80".to_owned(),
                ]]
            },
            instances: if accepted { 7 } else { 3 },
            mean_normal_n: Some(force_n),
            normal_n: vec![Some(force_n), Some(force_n)],
            settled: None,
            condition: None,
        }));
        self.say(Event::Fit(fit(name, force_n)));
        if !accepted {
            self.log(LogLevel::Warning, "1 input xrun, 1 024 frames lost");
            self.health(1024);
        }
    }

    fn tell(
        &mut self,
        instruction: Instruction,
        (trial, trials): (u32, u32),
        countdown: Option<u32>,
        mean_force_n: Option<f64>,
    ) {
        self.say(Event::Participant(ScreenView {
            instruction,
            slider_m: Some(0.0),
            plate_m: PLATE_M,
            start_m: 0.005,
            end_m: 0.1,
            countdown,
            mean_force_n,
            force_band_n: Some((0.5, 0.8)),
            trial,
            trials,
            ..ScreenView::default()
        }));
    }

    fn run(&mut self, duration_s: f64, finger: Finger, force_n: f64) {
        let steps = (duration_s * LIVE_HZ).round() as u32;
        let from_s = self.now_s;
        for step in 0..steps {
            let since_s = f64::from(step) / LIVE_HZ;
            self.now_s = from_s + since_s;
            let slider_m = match finger {
                Finger::Moving => since_s * SPEED_M_PER_S,
                _ => 0.0,
            };
            if matches!(finger, Finger::Moving) && step % 4 == 0 {
                self.slide(slider_m);
            }
            self.say(Event::Live(live(self.now_s, slider_m, finger, force_n)));
            if step % 25 == 0 {
                self.say(Event::Period(period(self.now_s, finger, force_n)));
            }
        }
        self.now_s = from_s + duration_s;
        self.health(0);
    }

    fn slide(&mut self, slider_m: f64) {
        let last = self.events.iter().rev().find_map(|(_, event)| match event {
            Event::Participant(view) => Some(view.clone()),
            _ => None,
        });
        if let Some(view) = last {
            self.say(Event::Participant(ScreenView {
                slider_m: Some(slider_m),
                ..view
            }));
        }
    }
}

fn amplitude_m(t_s: f64) -> f64 {
    1.6e-6 * (1.0 + 0.95 * (TAU * 6.0 * t_s).sin())
}

fn live(t_s: f64, slider_m: f64, finger: Finger, force_n: f64) -> Live {
    let amplitude_m = amplitude_m(t_s);
    let load = if force_n > 0.0 { 1.0 } else { 0.0 };
    let press = force_n * (1.0 + 0.06 * (TAU * 0.7 * t_s).sin()) * load;
    let re = 7.0 + load * (1.2 + 3.4 * (-amplitude_m / 1.2e-6).exp());
    let im = load * (-0.8 - 1.9 * (-amplitude_m / 1.2e-6).exp());
    let bias = 1.1 * (TAU * 6.0 * t_s).cos() * 0.5e-6 / (amplitude_m + 0.2e-6);
    let visible = amplitude_m > 0.15e-6;
    let impedance = |re, im| {
        visible.then_some(ComplexImpedance {
            re_n_s_per_m: re,
            im_n_s_per_m: im,
        })
    };
    let mu = 0.25 + 0.6 * (-amplitude_m / 1.0e-6).exp();
    let is_moving = matches!(finger, Finger::Moving);
    let estimate = |value, std| (force_n > 0.0 && visible).then_some(ValueAndStd { value, std });
    Live {
        t_s,
        z_m_n_s_per_m: impedance(re, im),
        z_plain_n_s_per_m: impedance(re + bias, im + 0.2 * bias),
        amplitude_m: Some(amplitude_m),
        normal_n: Some(press),
        lateral_n: Some(if is_moving { press * mu } else { 0.0 }),
        position_m: Some(if is_moving {
            (slider_m - 0.004).max(0.0)
        } else {
            0.0
        }),
        velocity_m_per_s: Some(if is_moving { SPEED_M_PER_S } else { 0.0 }),
        slider_m: Some(slider_m),
        gap_m: estimate(8e-6 + 2.0 * amplitude_m, 6e-8),
        mu: estimate(mu, 0.02),
        sensed_normal_n: estimate(0.98 * press, 0.02),
        plate_drift_hz: visible.then_some(ValueAndStd {
            value: -1.3,
            std: 0.3,
        }),
        drive_v: Some(amplitude_m * 1.2e7),
        measured_mu: is_moving.then_some(mu * (1.0 + 0.05 * (TAU * 11.0 * t_s).sin())),
        z_m_std_n_s_per_m: visible.then_some(2e-9 / amplitude_m),
        z_p_n_s_per_m: Some(ComplexImpedance {
            re_n_s_per_m: 7.02,
            im_n_s_per_m: -0.03,
        }),
        masked: (!visible).then_some(tui::event::Masked::BelowNoise),
        no_estimate: (force_n <= 0.0).then_some(NoEstimate::NoFinger),
    }
}

fn period(t_s: f64, finger: Finger, force_n: f64) -> PeriodTrace {
    let points = (0..80).map(|i| live(t_s + f64::from(i) / 480.0, 0.0, finger, force_n));
    let points: Vec<Live> = points.collect();
    PeriodTrace {
        z_m_n_s_per_m: points.iter().map(|live| live.z_m_n_s_per_m).collect(),
        z_plain_n_s_per_m: points.iter().map(|live| live.z_plain_n_s_per_m).collect(),
        duration_s: 1.0 / 6.0,
    }
}

fn fit(attempt: AttemptName, force_n: f64) -> FitView {
    let amplitudes = || (0..40).map(|i| f64::from(i) * 0.08e-6);
    let mu_at = |amplitude_m: f64| 0.25 + 0.6 * (-amplitude_m / 1.0e-6).exp();
    FitView {
        trial: attempt.trial,
        practice: attempt.practice,
        attempt: attempt.attempt,
        sigma_t_m: Some(ValueAndStd {
            value: 1.72e-6,
            std: 0.04e-6,
        }),
        mu0: Some(ValueAndStd {
            value: 0.85,
            std: 0.02,
        }),
        drift_hz: Some(ValueAndStd {
            value: -1.3,
            std: 0.3,
        }),
        no_fit: None,
        details: vec![
            format!("{attempt}: σ_t 1.720 ± 0.040 µm, τ 0.8 ± 0.1 ms"),
            "  Z_t 8.10 ± 0.05 − (0.90 ± 0.05)i N·s/m".to_owned(),
            "  7 of 7 fits, μ0 0.85, self-sensed force off 1.2 %".to_owned(),
            "  S 296 ± 4 mm², q0 1.36 ± 0.02 /µm, η 0.42 ± 0.03".to_owned(),
            "  plate's resonance -1.3 ± 0.3 Hz".to_owned(),
        ],
        curves: Some(ContactCurves {
            normal_n: force_n,
            z_p_n_s_per_m: ComplexImpedance {
                re_n_s_per_m: 7.02,
                im_n_s_per_m: -0.03,
            },
            locus: amplitudes()
                .map(|a| ComplexImpedance {
                    re_n_s_per_m: 8.1 + 3.4 * (-a / 1.2e-6).exp(),
                    im_n_s_per_m: -0.9 - 1.9 * (-a / 1.2e-6).exp(),
                })
                .collect(),
            friction: amplitudes().map(|a| (a, mu_at(a))).collect(),
            measured: amplitudes()
                .step_by(3)
                .map(|a| (a, mu_at(a) * 1.03))
                .collect(),
        }),
    }
}

fn facts() -> BenchFacts {
    let calibration = |name: &str, days: f64, value: &str| CalibrationFact {
        name: name.to_owned(),
        date: Some("2026-03-02".to_owned()),
        age_days: Some(days),
        operator: "N. H.".to_owned(),
        value: value.to_owned(),
    };
    let part = |name: &str, words: &str, well| PartFact {
        name: name.to_owned(),
        words: words.to_owned(),
        well,
        line: match name {
            "e-stop" => Some(BenchLine::Estop),
            "heartbeat" => Some(BenchLine::Heartbeat),
            "button" => Some(BenchLine::Button),
            _ => None,
        },
    };
    BenchFacts {
        plate: "plate of 105 mm at 35000.0 Hz".to_owned(),
        calibrations: vec![
            calibration("pickup", 0.2, "(5.450 ± 0.011)e-6 m"),
            calibration("plate", 3.0, "35000.000 ± 0.012 Hz"),
            calibration("force", 45.0, "6 masses"),
            CalibrationFact {
                name: "channels".to_owned(),
                ..CalibrationFact::default()
            },
        ],
        parts: vec![
            part("e-stop", "wired", true),
            part("heartbeat", "waived by N. H.", false),
            part("button", "wired", true),
            part("encoder", "gpio", true),
            part("force", "serial line at 460800 baud", true),
        ],
        loosened: vec!["safety.silence_s = 0.1 (default 0.05)".to_owned()],
        unverified: vec![
            "the volts were never checked against an independent meter: run `friction-bench calibrate output --meter NAME`"
                .to_owned(),
        ],
    }
}

fn crop(attempt: AttemptName, (exploration, start_s): (u32, f64), force_n: f64) -> Crop {
    let duration_s = PLATE_M / SPEED_M_PER_S;
    let time_at = |i: u32| f64::from(i) * duration_s / 199.0;
    let stretches = (0..12u32).map(|i| {
        let start_s = f64::from(i + 1) / 6.0 - 0.03;
        let end_s = start_s + 0.06;
        let (kind, reason) = match i {
            0..=1 | 10..=11 => (
                Some("outside the plate's central part"),
                Some("outside the central 60 mm"),
            ),
            6 if force_n > 0.8 => (Some("lost samples"), Some("lost samples in 12 frames")),
            4 => (
                Some("speed outside the tolerance"),
                Some("speed 71 mm/s, outside 40 to 60 mm/s"),
            ),
            _ => (None, None),
        };
        CropStretch {
            start_s,
            end_s,
            accepted: reason.is_none(),
            reason: reason.map(str::to_owned),
            kind: kind.map(str::to_owned),
        }
    });
    let curve = |value: &dyn Fn(f64) -> f64| {
        (0..200)
            .map(|i| Some(value(time_at(i))))
            .collect::<Vec<_>>()
    };
    Crop {
        trial: attempt.trial,
        practice: attempt.practice,
        attempt: attempt.attempt,
        exploration,
        leftwards: exploration == 2,
        start_s,
        duration_s,
        amplitude_m: (0..200)
            .map(|i| {
                let (a, b) = (amplitude_m(time_at(i)), amplitude_m(time_at(i) + 0.005));
                Some((a.min(b), a.max(b)))
            })
            .collect(),
        normal_n: curve(&|t_s| force_n * (1.0 + 0.06 * (TAU * 0.7 * t_s).sin())),
        lateral_n: curve(&|t_s| 0.4 * force_n * (1.0 + 0.3 * (TAU * 6.0 * t_s).cos())),
        position_m: curve(&|t_s| t_s * SPEED_M_PER_S),
        speed_m_per_s: curve(&|t_s| SPEED_M_PER_S * (1.0 + 0.1 * (TAU * 2.0 * t_s).sin())),
        stretches: stretches.collect(),
    }
}
