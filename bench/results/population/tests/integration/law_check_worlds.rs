//! The check between conditions on worlds of other laws (the independent simulation of `analysis`): which setting shows which
//! law. Two laws in every test run; all of docs/handbook/src/law-checks.md with as many recordings of each condition as
//! `FRICTION_BENCH_LAW_CHECKS` says (`./dev campaign law-checks`).

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]
#![expect(
    clippy::print_stdout,
    reason = "docs/handbook/src/law-checks.md has the numbers from here"
)]

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use analysis::{Analysis, Settings, analyse};
use population::law_check::{LawCheck, Setting, law_checks};
use rayon::prelude::*;
use reference_worlds::{campaign, independent};

/// Variable with the number of recordings of each condition in a campaign.
const COUNT: &str = "FRICTION_BENCH_LAW_CHECKS";
/// Number of recordings of each condition in every test run.
const RECORDINGS: u64 = 2;

/// Parameters of a world, by their names in world.c.
type World = &'static [(&'static str, f64)];

/// Laws by name.
const LAWS: [(&str, World); 14] = [
    ("published laws", &[]),
    ("force zero 40 mN", &[("normal_zero_n", 0.04)]),
    (
        "finger 8 mm wide across a mode of 22 mm",
        &[("wavelength_across_m", 22e-3), ("finger_width_m", 8e-3)],
    ),
    ("trapped air, 2 %", &[("trapped_air", 0.02)]),
    ("loss of the film 0.5 instead of 0.3", &[("film_loss", 0.2)]),
    ("film without loss", &[("film_loss", -0.3)]),
    ("Eq. 15 averaged over the cycle", &[("cycle_average", 1.0)]),
    (
        "film driven by the relative motion, 10 %",
        &[("relative_motion", 0.1)],
    ),
    (
        "plate softens by 1 ppm/µm²",
        &[("softening_ppm_per_um2", 1.0)],
    ),
    ("pressure 850 hPa", &[("ambient_pa", 85e3)]),
    (
        "crosstalk normal to lateral, 3 %",
        &[("normal_to_lateral", 0.03)],
    ),
    (
        "crosstalk lateral to normal, 3 %",
        &[("lateral_to_normal", 0.03)],
    ),
    ("forces 1 ms late", &[("forces_late_s", 1e-3)]),
    (
        "second mode 2 kHz above",
        &[("second_mode_hz", 37e3), ("second_mode_at_finger", 0.3)],
    ),
];

/// Drive level, V, modulation and resonance, Hz.
type Condition = (f64, f64, f64);

const DRIVES: [Condition; 2] = [(12.0, 6.0, 35e3), (24.0, 6.0, 35e3)];
const ALL: [Condition; 5] = [
    (12.0, 3.0, 35e3),
    (12.0, 6.0, 35e3),
    (24.0, 3.0, 35e3),
    (24.0, 6.0, 35e3),
    (24.0, 6.0, 28e3),
];

/// Records a finger under a law and a condition, as of a participant.
fn record(folder: &Path, law: World, (drive_v, modulation_hz, resonance_hz): Condition, seed: u64) {
    let mut parameters = vec![
        ("seed", seed as f64),
        ("drive_v", drive_v),
        ("modulation_hz", modulation_hz),
        ("resonance_hz", resonance_hz),
        // The skin is the same mass at each carrier.
        ("im_z_t", 3.16 * (resonance_hz + 10.0) / 35_010.0),
        ("after_s", 1.0),
    ];
    // A second mode keeps its distance from the carrier.
    parameters.extend(law.iter().map(|&(name, value)| match name {
        "second_mode_hz" => (name, value + resonance_hz - 35e3),
        _ => (name, value),
    }));
    std::fs::create_dir(folder).unwrap();
    independent::record(folder, &parameters);
    let mut manifest = std::fs::File::options()
        .append(true)
        .open(folder.join("recording.toml"))
        .unwrap();
    manifest
        .write_all(b"\n[participant]\nid = \"sub-01\"\nsession = 1\n")
        .unwrap();
}

/// Check of a finger recorded under a law, and the errors of its estimates.
struct Checked {
    /// `None` if fewer than two conditions have trials that the model fits.
    check: Option<LawCheck>,
    /// Mean over the recordings that the model fits of σ_t and S, relative to the truth − 1, and of Re Z_t − truth, N·s/m.
    errors: [f64; 3],
    /// Number of recordings that the model does not fit, and of all.
    not_fitted: (usize, usize),
}

const TRUTH: (f64, f64, f64) = (1.7e-6, 300e-6, 0.47);

/// Returns the errors of the estimates, and the number of recordings behind them.
fn errors(analysed: &Analysis) -> ([f64; 3], usize) {
    let mut errors = Vec::new();
    for recording in &analysed.recordings {
        let findings = recording.findings.as_ref().unwrap();
        let Some(shared) = &findings.trial else {
            continue;
        };
        if !shared.verdict.is_usable() || !shared.misfit.is_empty() {
            continue;
        }
        let instances = findings.instances.iter();
        let estimates: Vec<_> = instances
            .filter_map(|instance| instance.trial.as_ref())
            .collect();
        let n = estimates.len() as f64;
        let (sigma_t_m, area_m2, re_z_t) = TRUTH;
        let sigma = estimates
            .iter()
            .map(|estimate| estimate.sigma_t_m())
            .sum::<f64>()
            / n;
        let re = estimates
            .iter()
            .map(|estimate| estimate.z_t_n_s_per_m.re)
            .sum::<f64>()
            / n;
        errors.push([
            sigma / sigma_t_m - 1.0,
            shared.contact_area_m2.value / area_m2 - 1.0,
            re - re_z_t,
        ]);
    }
    let n = errors.len();
    let mean = |index: usize| errors.iter().map(|error| error[index]).sum::<f64>() / n as f64;
    ([0, 1, 2].map(mean), n)
}

/// Returns the check of a participant recorded under a law.
fn checked(law: World, conditions: &[Condition], recordings: u64) -> Checked {
    let study = tempfile::tempdir().unwrap();
    let trials = conditions
        .iter()
        .flat_map(|&condition| (1..=recordings).map(move |seed| (condition, seed)));
    let trials: Vec<(usize, (Condition, u64))> = trials.enumerate().collect();
    let folders: Vec<PathBuf> = trials
        .into_par_iter()
        .map(|(number, (condition, seed))| {
            let folder = study.path().join(format!("trial-{number}"));
            record(&folder, law, condition, seed);
            folder
        })
        .collect();
    let analysed = analyse(&folders, &Settings::default(), |_| ());
    let (errors, fitted) = errors(&analysed);
    Checked {
        check: law_checks(&analysed).pop(),
        errors,
        not_fitted: (folders.len() - fitted, folders.len()),
    }
}

/// Differences in words: relative ones in %, Re Z_t in N·s/m, Im Z_t/ω in mg.
fn describe(checked: &Checked) -> String {
    let Checked {
        check,
        errors: [sigma_t, area, re_z_t],
        not_fitted: (not_fitted, all),
    } = checked;
    let mut text = format!(
        "{not_fitted} of {all} not fitted; errors: sigma_t {:+.1}%, S {:+.1}%, Re Z_t {re_z_t:+.3}",
        100.0 * sigma_t,
        100.0 * area,
    );
    let comparisons = check.iter().flat_map(|check| &check.comparisons);
    for comparison in comparisons {
        write!(
            text,
            "; {:?} {:.1} and {:.1}:",
            comparison.setting, comparison.lower, comparison.upper
        )
        .unwrap();
        let units = [
            ("sigma_t", 100.0, "%"),
            ("S", 100.0, "%"),
            ("tau", 100.0, "%"),
            ("Re Z_t", 1.0, ""),
            ("Im Z_t/omega", 1e6, "mg"),
        ];
        let differences = comparison.differences.as_array();
        for ((name, scale, unit), difference) in units.into_iter().zip(differences) {
            match difference {
                None => write!(text, " {name} -").unwrap(),
                Some(difference) => write!(
                    text,
                    " {name} {:+.2} ± {:.2}{unit}{}",
                    scale * difference.value,
                    scale * difference.std,
                    if difference.agrees { "" } else { "!" }
                )
                .unwrap(),
            }
        }
    }
    text
}

/// Returns the differences of ln σ_t and ln τ between the two drive levels.
fn between_drives(law: World) -> [f64; 2] {
    let checked = checked(law, &DRIVES, RECORDINGS);
    println!("{}", describe(&checked));
    let check = checked.check.unwrap();
    assert_eq!(check.comparisons[0].setting, Setting::DriveV);
    let differences = check.comparisons[0].differences;
    [differences.ln_sigma_t, differences.ln_tau].map(|difference| difference.unwrap().value)
}

#[test]
fn two_drive_levels_show_a_plate_that_softens_and_agree_under_the_published_laws() {
    let [sigma_t, tau] = between_drives(LAWS[0].1);
    assert!(sigma_t.abs() < 0.03 && tau.abs() < 0.25, "{sigma_t} {tau}");
    let [_, tau] = between_drives(LAWS[8].1);
    assert!(tau > 0.35, "{tau}");
}

#[test]
fn each_check_under_each_law() {
    let Some(count) = campaign::size(COUNT, 2) else {
        return;
    };
    for (name, law) in LAWS {
        let text = format!("{name}: {}", describe(&checked(law, &ALL, count as u64)));
        campaign::report("law checks", count, &text);
    }
}
