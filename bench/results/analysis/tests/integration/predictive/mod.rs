//! Predictive test of `paper`: the published averages as the truth of a world, and a search for the truths with which `paper`
//! gives the published averages (docs/predictive-test.md). Every test run records the worlds that a search has found; a
//! campaign (`./dev campaign predictive`) searches, from as many truths as `FRICTION_BENCH_PREDICTIVE` says.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]
#![expect(
    clippy::print_stdout,
    reason = "docs/predictive-test.md has the numbers from here"
)]

mod search;
mod slow_model;
mod truth;

use std::sync::Mutex;

use num_complex::Complex64;
use rayon::prelude::*;
use reference_worlds::campaign;
use reference_worlds::independent::compile;

use truth::{PARTS, Part, Printed, Truth};

/// Variable with the number of truths from which the searches of a campaign start.
const COUNT: &str = "FRICTION_BENCH_PREDICTIVE";
/// Distance from the published averages within which an estimate counts as equal to them.
const EQUAL: f64 = 0.05;
/// Number of the best truths from which a simplex descends, and its evaluations.
const DESCENTS: usize = 4;
const EVALUATIONS: usize = 300;

/// Parts that a search varies, by their places in [`PARTS`]; the others are as published.
const SCOPES: [&[usize]; 6] = [
    &[0, 1, 2],
    &[0, 1, 2, 3],
    &[0, 1, 2, 4, 5, 6],
    &[0, 1, 2, 3, 4, 5, 6],
    &[0, 1, 2, 7],
    &[0, 1, 2, 3, 4, 5, 6, 7],
];

/// Truths whose estimates the search has computed, with their distances from the published averages.
struct Searched {
    truths: Vec<(Truth, f64)>,
}

impl Searched {
    /// Searches a scope on the slow model.
    fn new(scope: &[usize], count: u64) -> Self {
        let parts: Vec<Part> = scope.iter().map(|&part| PARTS[part]).collect();
        let tried = Mutex::new(Vec::new());
        let distance = |places: &[f64]| {
            let mut truth = Truth::PUBLISHED;
            for (part, &place) in parts.iter().zip(places) {
                part.set(&mut truth, place);
            }
            // Farther than every estimate of the ranges.
            let distance = slow_model::printed(&truth).map_or(5.0, |printed| printed.distance());
            tried.lock().unwrap().push((truth, distance));
            distance
        };
        let starts = (1..=count).into_par_iter().map(|index| {
            let places = search::halton(index, parts.len());
            let distance = distance(&places);
            (places, distance)
        });
        let mut starts: Vec<search::Valued> = starts.collect();
        starts.sort_by(|a, b| a.1.total_cmp(&b.1));
        starts.truncate(DESCENTS);
        let published = parts.iter().map(|part| part.place(&Truth::PUBLISHED));
        starts.push((published.collect(), f64::NAN));
        starts.par_iter().for_each(|(start, _)| {
            search::descend(start, EVALUATIONS, distance);
        });
        let mut truths = tried.into_inner().unwrap();
        truths.sort_by(|a, b| a.1.total_cmp(&b.1));
        Self { truths }
    }

    /// Returns the truths with estimates equal to the published averages.
    fn found(&self) -> &[(Truth, f64)] {
        &self.truths[..self.truths.partition_point(|truth| truth.1 < EQUAL)]
    }

    /// Returns the found truth that is closest to the published one, by the places of its parts in their ranges.
    fn closest(&self) -> Option<&Truth> {
        let places_apart = |truth: &Truth| -> f64 {
            let parts = PARTS.iter();
            parts
                .map(|part| (part.place(truth) - part.place(&Truth::PUBLISHED)).powi(2))
                .sum()
        };
        let found = self.found().iter().map(|(truth, _)| truth);
        found.min_by(|a, b| places_apart(a).total_cmp(&places_apart(b)))
    }

    /// Returns the smallest and largest values of a part among the found truths.
    fn range(&self, part: &Part) -> [f64; 2] {
        let values = self.found().iter().map(|(truth, _)| {
            let mut truth = *truth;
            *(part.of)(&mut truth)
        });
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    }
}

/// Truths that the campaign has found, with other parts varied each time.
const FOUND: [Truth; 3] = [
    // A short lag, a large and soft contact.
    Truth {
        sigma_t_m: 1.254e-6,
        z_t: Complex64::new(1.322, 11.61),
        contact_area_m2: 450e-6,
        loss_factor: 0.201,
        q0_rad_per_m: 0.51e4,
        tau_s: 0.04e-3,
        ..Truth::PUBLISHED
    },
    // Half the amplitude.
    Truth {
        sigma_t_m: 1.402e-6,
        z_t: Complex64::new(0.1, 11.99),
        drive_v: 10.8,
        ..Truth::PUBLISHED
    },
    // The closest to the published truth.
    Truth {
        sigma_t_m: 1.549e-6,
        z_t: Complex64::new(0.658, 6.436),
        contact_area_m2: 450e-6,
        loss_factor: 0.227,
        q0_rad_per_m: 1.25e4,
        tau_s: 0.936e-3,
        drive_v: 14.3,
    },
];

/// Records a truth and returns the estimates of `paper`, which the slow model gives too.
fn recorded(truth: &Truth) -> Printed {
    let (slow, recorded) = (
        slow_model::printed(truth).unwrap(),
        truth.recorded().unwrap(),
    );
    println!("{truth}\n    slow:  {slow}\n    world: {recorded}");
    let apart = slow.distance_from(recorded.sigma_t_m, recorded.z_t);
    assert!(apart < 0.03, "{truth}: {slow}; {recorded}: {apart}");
    recorded
}

#[test]
fn the_published_averages_as_truth_are_not_what_paper_gives() {
    compile();
    let printed = recorded(&Truth::PUBLISHED);
    assert!((2.7e-6..3.0e-6).contains(&printed.sigma_t_m), "{printed}");
    assert!((-0.2..0.0).contains(&printed.z_t.re), "{printed}");
    assert!((1.1..1.5).contains(&printed.z_t.im), "{printed}");
    assert!(printed.distance() > 0.5);
}

#[test]
fn some_truths_give_the_published_averages() {
    compile();
    FOUND.par_iter().for_each(|truth| {
        let printed = recorded(truth);
        assert!(printed.distance() < EQUAL, "{truth}: {printed}");
    });
}

#[test]
fn a_search_for_truths_with_the_published_averages() {
    let Some(count) = campaign::size(COUNT, 1) else {
        return;
    };
    compile();
    for scope in SCOPES {
        let searched = Searched::new(scope, count as u64);
        let names: Vec<&str> = scope.iter().map(|&part| PARTS[part].name).collect();
        let recorded = |truth: &Truth| match truth.recorded() {
            None => format!("{truth}; recorded: no estimate"),
            Some(printed) => {
                format!(
                    "{truth}; recorded: {printed}, distance {:.3}",
                    printed.distance()
                )
            }
        };
        let (best, distance) = &searched.truths[0];
        let mut text = format!(
            "varied {}: {} truths, {} within {EQUAL}; nearest {distance:.3}, {}",
            names.join(", "),
            searched.truths.len(),
            searched.found().len(),
            recorded(best),
        );
        if let Some(truth) = searched.closest() {
            text += &format!("; closest to the published truth {}", recorded(truth));
        }
        for &part in scope {
            if !searched.found().is_empty() {
                let [low, high] = searched.range(&PARTS[part]);
                text += &format!("; {} {low:.3e} to {high:.3e}", PARTS[part].name);
            }
        }
        campaign::report("published averages by paper", count, &text);
    }
}
