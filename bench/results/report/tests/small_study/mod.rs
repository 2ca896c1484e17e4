//! A small study: one recording with two instances, of which the first has an estimate by `trial`, and one recording that
//! cannot be read.

use std::path::PathBuf;

use analysis::Analysis;
use attempts::AttemptAccount;
use population::law_check::LawCheck;
use population::skin::{
    LeftOut, Parameters, PersonParameter, PersonSkin, Ranged, Skin, StudyParameter, TrialParameter,
};
use protocols::Direction;
use published_statistics::cluster_test::Clustered;
use published_statistics::{Level, MethodStatistic, Statistic, StatisticRow, Statistics};
use recording::manifest::assumed_errors::AssumedErrors;
use recording::study::TrialBlock;
use report::Results;
use report::recording_results::{
    AveragedModel, Estimate, Instance, InstanceIntervals, Methods, Recording, RejectedRow, Std,
    Trial, TrialEstimate, TrialIntervals,
};
use study::exclusions::{AllOrOne, Excluded, Exclusion, RecordingSelection};

pub const HOSTILE: &str =
    "<script>alert('x')</script><img src=http://evil.test/a onerror=\"b\">&\u{202e}\u{1b}[2J";

/// Parts of the results.
pub struct SmallStudy {
    analysed: Analysis,
    pub recordings: Vec<Recording>,
    pub skin: Skin,
    pub law_check: Vec<LawCheck>,
    pub statistics: Statistics,
    pub account: AttemptAccount,
    pub selection: RecordingSelection,
}

impl SmallStudy {
    pub fn new(participant: &str) -> Self {
        Self {
            analysed: no_recordings(),
            recordings: vec![recording(participant), unreadable_recording()],
            skin: skin(participant),
            law_check: Vec::new(),
            statistics: statistics(),
            account: AttemptAccount {
                accepted: 1,
                analysed: 1,
                not_accepted: 0,
                excluded: 1,
                left_out: Vec::new(),
                empty_sessions: Vec::new(),
                unread_logs: Vec::new(),
            },
            selection: RecordingSelection {
                excluded: vec![excluded()],
                ..RecordingSelection::default()
            },
        }
    }

    pub fn results(&self) -> Results<'_> {
        let mut results = Results::new(&self.analysed, &self.skin, &self.account, &self.selection);
        results.law_check = self.law_check.clone();
        results.statistics = self.statistics.clone();
        results
    }

    /// Returns the results file.
    pub fn file(&self) -> String {
        file(&self.results())
    }

    /// Returns the fit of all instances of the first recording.
    pub fn trial_mut(&mut self) -> &mut Trial {
        self.recordings[0].trial.as_mut().unwrap()
    }
}

/// Returns the file with these results.
pub fn file(results: &Results<'_>) -> String {
    let mut text = Vec::new();
    results.write_json(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

fn no_recordings() -> Analysis {
    Analysis::default()
}

fn recording(participant: &str) -> Recording {
    Recording {
        path: "/home/somebody/study/a".to_owned(),
        participant: Some(participant.to_owned()),
        carrier_hz: Some(35_000.0),
        z_p_n_s_per_m: Methods {
            paper: Some([7.0, 0.0]),
            dynamic: Some([7.0, -0.1]),
        },
        instances: vec![instance(1.9, Some(trial_estimate())), instance(2.1, None)],
        trial: Some(trial()),
        rejected: vec![RejectedRow {
            start_s: 1.4,
            end_s: 1.48,
            direction: Direction::LeftToRight,
            reason: HOSTILE.to_owned(),
            kind: HOSTILE.to_owned(),
        }],
        warnings: vec![HOSTILE.to_owned()],
        ..unreadable_recording()
    }
}

fn unreadable_recording() -> Recording {
    Recording {
        path: "/home/somebody/study/b".to_owned(),
        participant: None,
        uncalibrated: false,
        provenance: None,
        carrier_hz: None,
        plate_profile: false,
        plate_across: None,
        standard_errors: None,
        assumed_errors: AssumedErrors::default(),
        room: None,
        force_zero: Vec::new(),
        force_clock: None,
        pickup_undone: None,
        z_p_n_s_per_m: Methods {
            paper: None,
            dynamic: None,
        },
        explorations: Vec::new(),
        instances: Vec::new(),
        trial: None,
        model_check: Vec::new(),
        rejected: Vec::new(),
        warnings: vec!["cannot be read: recording.toml".to_owned()],
    }
}

fn instance(start_s: f64, trial: Option<TrialEstimate>) -> Instance {
    Instance {
        start_s,
        end_s: start_s + 0.06,
        direction: Direction::LeftToRight,
        normal_n: 0.64,
        delta_z_m_n_s_per_m: 1.0,
        delta_mu: 0.7,
        methods: Methods {
            paper: estimate(),
            dynamic: estimate(),
        },
        trial,
    }
}

fn estimate() -> Estimate {
    Estimate {
        sigma_t_m: Some(1.9e-6),
        sigma_t_null_because: None,
        z_t_n_s_per_m: [0.47, -3.1],
        tau_s: Some(0.0012),
        plate_offset_n_s_per_m: None,
        resonance_shift_hz: Some(-1.25),
        mu0: 0.8,
        r2_impedance: 0.9,
        rms_mu: f64::NAN,
        spearman_mu: None,
        delta_z_m_n_s_per_m: 1.0,
        delta_re_z_m_n_s_per_m: 1.0,
        delta_abs_im_z_m_n_s_per_m: 1.0,
        delta_gap_m: 1e-6,
        delta_reaction_force_n: 0.1,
        delta_squeeze_n: 0.1,
        delta_mu: 0.7,
        rigid_z_t_n_s_per_m: [0.4, -3.0],
        averaged: AveragedModel {
            sigma_t_m: Some(1.9e-6),
            sigma_t_null_because: None,
            r2_impedance: 0.9,
        },
        verdict: "tau held at its bound 0 s; unbounded it would be -1e-3 s".to_owned(),
        model_misfit: false,
        misfit: Vec::new(),
        at_rest: None,
        std: Std {
            sigma_t_m: Some(1e-8),
            z_t_n_s_per_m: [0.01, 0.02],
            tau_s: None,
            resonance_shift_hz: None,
            mu0: 0.001,
        },
        sensitivity: None,
    }
}

fn trial_estimate() -> TrialEstimate {
    TrialEstimate {
        estimate: estimate(),
        interval95: Some(InstanceIntervals {
            sigma_t_m: Some([1.8e-6, 2.0e-6]),
            z_t_re_n_s_per_m: [0.45, 0.49],
            z_t_im_n_s_per_m: [-3.2, -3.0],
            mu0: [0.79, 0.81],
            resonance_shift_hz: Some([-1.5, f64::NAN]),
        }),
        interval95_within_laws: Some(InstanceIntervals {
            sigma_t_m: Some([1.86e-6, 1.94e-6]),
            z_t_re_n_s_per_m: [0.46, 0.48],
            z_t_im_n_s_per_m: [-3.15, -3.05],
            mu0: [0.795, 0.805],
            resonance_shift_hz: None,
        }),
    }
}

fn trial() -> Trial {
    Trial {
        contact_area_m2: 2.2e-4,
        q0_rad_per_m: 2.2e4,
        loss_factor: 0.42,
        tau_s: 8e-4,
        area_force_exponent: 0.3,
        film_mean_s: 1e-4,
        lag_gap_exponent: 0.25,
        friction_floor: None,
        lateral_lag_s: None,
        interval95: Some(TrialIntervals {
            contact_area_m2: [2.1e-4, 2.3e-4],
            q0_rad_per_m: [2.1e4, 2.3e4],
            loss_factor: [0.4, 0.44],
            tau_s: [7e-4, 9e-4],
            area_force_exponent: [0.2, 0.4],
            film_mean_s: (),
            lag_gap_exponent: [0.2, 0.3],
            friction_floor: None,
            lateral_lag_s: None,
        }),
        interval95_within_laws: Some(TrialIntervals {
            contact_area_m2: [2.16e-4, 2.24e-4],
            q0_rad_per_m: [2.15e4, 2.25e4],
            loss_factor: [0.41, 0.43],
            tau_s: [7.5e-4, 8.5e-4],
            area_force_exponent: [0.25, 0.35],
            film_mean_s: (),
            lag_gap_exponent: [0.22, 0.28],
            friction_floor: None,
            lateral_lag_s: None,
        }),
        n_instances: 2,
        verdict: "converged".to_owned(),
        model_misfit: false,
        misfit: Vec::new(),
        misfit_within_laws: Vec::new(),
    }
}

fn skin(participant: &str) -> Skin {
    let raw = Ranged {
        value: 2.2e-4,
        interval95: [2.1e-4, 2.3e-4],
        interval95_within_laws: Some([2.17e-4, 2.23e-4]),
    };
    let shrunken = Some(Ranged {
        value: 2.25e-4,
        interval95: [2.15e-4, 2.35e-4],
        interval95_within_laws: None,
    });
    let unknown = StudyParameter {
        mean: None,
        n_participants: 0,
        between_participants_ln_std: None,
        between_participants_ln_std_interval95: None,
        between_participants_ln_std_interval95_within_laws: None,
        between_trials_ln_std: None,
        shared_error_part: 0.0,
    };
    let area = StudyParameter {
        mean: Some(Ranged {
            value: 2.3e-4,
            interval95: [2.0e-4, 2.6e-4],
            interval95_within_laws: Some([2.2e-4, 2.4e-4]),
        }),
        n_participants: 4,
        between_participants_ln_std: Some(0.12),
        between_participants_ln_std_interval95: Some([0.05, 0.4]),
        between_participants_ln_std_interval95_within_laws: Some([0.06, 0.3]),
        between_trials_ln_std: Some(0.04),
        shared_error_part: 0.3,
    };
    let unshrunken = |value: f64| TrialParameter {
        raw: Ranged {
            value,
            interval95: [0.9 * value, 1.1 * value],
            interval95_within_laws: None,
        },
        shrunken: None,
    };
    let mut skin = Skin::from_analysis(&no_recordings());
    skin.study = Parameters {
        contact_area_m2: area,
        q0_rad_per_m: unknown,
        loss_factor: unknown,
        tau_s: unknown,
    };
    skin.participants = vec![PersonSkin {
        participant: participant.to_owned(),
        parameters: Parameters {
            contact_area_m2: Some(PersonParameter {
                mean: raw,
                n_trials: 1,
                between_trials_ln_std: None,
                shrunken,
            }),
            ..Parameters::default()
        },
        trials: vec![population::skin::RecordingSkin {
            path: PathBuf::from("/home/somebody/study/a"),
            parameters: Parameters {
                contact_area_m2: TrialParameter { raw, shrunken },
                q0_rad_per_m: unshrunken(2.2e4),
                loss_factor: unshrunken(0.42),
                tau_s: unshrunken(8e-4),
            },
        }],
        n_left_out: 2,
    }];
    skin.left_out = vec![LeftOut {
        path: PathBuf::from("/home/somebody/study/c"),
        participant: None,
        because: HOSTILE.to_owned(),
    }];
    skin
}

fn excluded() -> Excluded {
    Excluded {
        study: PathBuf::from("/home/somebody/study"),
        exclusion: Exclusion {
            participant: "sub-07".parse().unwrap(),
            session: AllOrOne::All,
            trial: AllOrOne::One(study::exclusions::SessionTrial {
                block: TrialBlock::Main,
                number: 3,
            }),
            reason: HOSTILE.to_owned(),
            by: HOSTILE.to_owned(),
            date: None,
        },
        recordings: vec![PathBuf::from("/home/somebody/study/c")],
    }
}

fn statistics() -> Statistics {
    let main = Statistic {
        value: Some(1.9e-6),
        std: Some(1e-7),
        p: Some(0.0001),
        clustered: Some(Clustered { p: None, people: 3 }),
        n: 2,
        over: Level::Instances,
    };
    let level = Statistic {
        value: None,
        std: None,
        p: None,
        clustered: None,
        n: 1,
        over: Level::Trials,
    };
    let row = |name, meaning, published| {
        let by_method = MethodStatistic {
            main,
            also: vec![level],
        };
        StatisticRow {
            name,
            meaning,
            published,
            paper: by_method.clone(),
            dynamic: by_method.clone(),
            trial: by_method,
        }
    };
    Statistics {
        rows: vec![
            row("zeta", "sigma_t, m", "(1.7 ± 0.4)e-6"),
            row("alpha", "second of mu0", "0.1"),
        ],
    }
}
