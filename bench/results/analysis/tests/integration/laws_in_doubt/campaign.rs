//! Worlds of each cause, analysed by every method: one of each in every test run, as many as `FRICTION_BENCH_LAWS` says in a
//! campaign (`./dev campaign laws`). `FRICTION_BENCH_LAW` selects causes by name, separated by commas.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]
#![expect(
    clippy::print_stdout,
    reason = "docs/accuracy.md has the numbers from here"
)]

use analysis::Settings;
use analysis::method::Method;
use analysis::recording_analysis::analyse_with_series;
use rayon::prelude::*;
use reference_worlds::campaign;
use reference_worlds::independent::{compile, record};
use reference_worlds::truth::{Truth, World};

use super::causes::{
    CAUSES, NamedWorld, PUBLISHED, SEVERAL, published_worlds, worlds_of, worlds_of_several,
};
use super::table::Row;
use crate::verdict::{Outcome, Quantity, Verdict};

/// Variable with the number of worlds of each cause in a campaign.
const COUNT: &str = "FRICTION_BENCH_LAWS";
/// Variable with the names of the causes of a run.
const ONLY: &str = "FRICTION_BENCH_LAW";

/// Causes by which laws or the plate are others and the sensors as stated: the estimate of μ0 remains right.
const SOUND_SENSORS: [&str; 12] = [
    "wide-finger",
    "fingertip",
    "fingertip-known-wavelength",
    "trapped-air",
    "film-loss",
    "cycle-average",
    "relative-motion",
    "plate-softens",
    "pressure",
    "pressure-known",
    "second-mode",
    PUBLISHED,
];

/// Returns the worlds of the selected causes.
fn worlds(count: u64) -> Vec<NamedWorld> {
    let causes = CAUSES.iter().flat_map(|cause| worlds_of(cause, count));
    let mut worlds: Vec<NamedWorld> = causes.collect();
    worlds.extend(worlds_of_several(count));
    worlds.extend(published_worlds(2 * count));
    if let Ok(names) = std::env::var(ONLY) {
        let names: Vec<&str> = names.split(',').collect();
        for name in &names {
            let is_known = [SEVERAL, PUBLISHED].contains(name)
                || CAUSES.iter().any(|cause| cause.name == *name);
            assert!(is_known, "{ONLY}: no cause is called \"{name}\"");
        }
        worlds.retain(|world| names.contains(&world.cause));
    }
    worlds
}

/// Returns the verdict of each method on a world.
fn verdicts(world: &NamedWorld) -> Vec<Verdict> {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), &world.world);
    let (analysis, series) = analyse_with_series(folder.path(), &Settings::default());
    let findings = analysis.findings.unwrap();
    if findings.instances.is_empty() {
        let reasons = findings.rejected.iter().map(|stretch| &stretch.reason);
        let reasons: Vec<&String> = reasons.collect();
        println!("{}: no instance: {reasons:?}", arguments(&world.changed));
    }
    let truth = Truth::read(folder.path());
    let methods = Method::ALL.iter();
    methods
        .map(|method| Verdict::new(*method, (&findings, &series), &truth, &world.world))
        .collect()
}

/// Returns parameters as arguments of the program.
fn arguments(world: &World) -> String {
    let arguments = world.iter().map(|(name, value)| format!("{name}={value}"));
    arguments.collect::<Vec<_>>().join(" ")
}

/// Prints a world with its verdicts, and all of its parameters if an estimate of `trial` is wrong in silence.
fn print(world: &NamedWorld, verdicts: &[Verdict]) {
    println!("{}: {}", world.cause, arguments(&world.changed));
    for verdict in verdicts {
        println!("    {verdict}");
        if verdict.method == Method::Trial && matches!(verdict.outcome, Outcome::WrongInSilence(_))
        {
            println!("    {}", arguments(&world.world));
        }
    }
}

/// Reports the rows; in a campaign, also writes them with all columns to a file beside its results, with a name that ends in
/// `.laws.tsv`.
fn report(count: usize, rows: &[Row<'_>]) {
    for row in rows {
        campaign::report("a world of other laws", count, &row.to_string());
    }
    let Some(path) = campaign::results_path() else {
        return;
    };
    let mut table = Row::tsv_header();
    for row in rows {
        table.push('\n');
        table.push_str(&row.tsv());
    }
    table.push('\n');
    std::fs::write(path.with_added_extension("laws.tsv"), table).unwrap();
}

#[test]
fn a_world_of_other_laws_is_right_covered_or_flagged() {
    compile();
    let count = campaign::repeats(COUNT, 1);
    let results: Vec<(NamedWorld, Vec<Verdict>)> = worlds(count as u64)
        .into_par_iter()
        .map(|world| {
            let verdicts = verdicts(&world);
            (world, verdicts)
        })
        .collect();
    for (world, verdicts) in &results {
        print(world, verdicts);
    }
    let mut rows = Vec::new();
    for (index, method) in Method::ALL.iter().enumerate() {
        let causes = CAUSES.iter().map(|cause| cause.name);
        for cause in causes.chain([SEVERAL, PUBLISHED]) {
            let of_cause = results.iter().filter(|(world, _)| world.cause == cause);
            let verdicts: Vec<&Verdict> = of_cause.map(|(_, verdicts)| &verdicts[index]).collect();
            if !verdicts.is_empty() {
                rows.push(Row::new(cause, *method, verdicts));
            }
        }
    }
    report(count, &rows);
    assert!(!rows.is_empty());
    let trial = rows.iter().filter(|row| row.method() == Method::Trial);
    let mut silent = Vec::new();
    for row in trial {
        if row.cause() == PUBLISHED {
            row.assert_within_laws();
        }
        let texts = row.wrong_in_silence();
        silent.extend(texts.map(|v| format!("{}: {v}", row.cause())));
        if SOUND_SENSORS.contains(&row.cause()) {
            let texts = row.wrong_in(Quantity::Mu0);
            silent.extend(texts.map(|v| format!("mu0, {}: {v}", row.cause())));
        }
    }
    assert!(silent.is_empty(), "{silent:#?}");
}
