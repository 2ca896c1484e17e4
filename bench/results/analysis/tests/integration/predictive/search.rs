//! Search for the smallest value of a function in the unit cube: evenly spread points, then a simplex from the best of them.

use rayon::prelude::*;

/// Bases of Halton's sequence.
const PRIMES: [u64; 8] = [2, 3, 5, 7, 11, 13, 17, 19];
/// Edge of the first simplex.
const EDGE: f64 = 0.15;
/// Spread of the values in a simplex at which it ends.
const CONVERGED: f64 = 2e-4;

/// Point of the cube with its value.
pub type Valued = (Vec<f64>, f64);

/// Returns point `index` of Halton's sequence in `n` dimensions, up to eight.
pub fn halton(index: u64, n: usize) -> Vec<f64> {
    let coordinate = |base: u64| {
        let (mut index, mut place, mut sum) = (index, 1.0, 0.0);
        while index > 0 {
            place /= base as f64;
            sum += place * (index % base) as f64;
            index /= base;
        }
        sum
    };
    PRIMES[..n].iter().map(|base| coordinate(*base)).collect()
}

/// Returns the best point of a simplex from `start` after at most `most` evaluations, in addition to those of the first
/// simplex (Nelder and Mead 1965). Points outside the cube are moved to its surface.
pub fn descend(start: &[f64], most: usize, f: impl Fn(&[f64]) -> f64 + Sync) -> Valued {
    let valued = |point: Vec<f64>| {
        let point: Vec<f64> = point.iter().map(|x| x.clamp(0.0, 1.0)).collect();
        let value = f(&point);
        (point, value)
    };
    let corner = |axis: usize| {
        let mut point = start.to_vec();
        point[axis] += if start[axis] < 0.6 { EDGE } else { -EDGE };
        point
    };
    let corners = (0..=start.len())
        .into_par_iter()
        .map(|corner_of| match corner_of {
            0 => valued(start.to_vec()),
            axis => valued(corner(axis - 1)),
        });
    let mut simplex: Vec<Valued> = corners.collect();
    let mut evaluations = 0;
    loop {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, last) = (simplex[0].1, simplex.len() - 1);
        if evaluations >= most || simplex[last].1 - best < CONVERGED {
            return simplex.swap_remove(0);
        }
        let mean_of = |axis: usize| {
            simplex[..last]
                .iter()
                .map(|corner| corner.0[axis])
                .sum::<f64>()
                / last as f64
        };
        let centre: Vec<f64> = (0..start.len()).map(mean_of).collect();
        let worst = simplex[last].clone();
        // Centre plus a multiple of its distance from the worst corner.
        let on_line = |part: f64| {
            let coordinates = centre.iter().zip(&worst.0);
            valued(coordinates.map(|(c, w)| c + part * (c - w)).collect())
        };
        let reflected = on_line(1.0);
        evaluations += 1;
        let second_worst = simplex[last - 1].1;
        if reflected.1 < best {
            let expanded = on_line(2.0);
            evaluations += 1;
            simplex[last] = if expanded.1 < reflected.1 {
                expanded
            } else {
                reflected
            };
        } else if reflected.1 < second_worst {
            simplex[last] = reflected;
        } else {
            let contracted = on_line(if reflected.1 < worst.1 { 0.5 } else { -0.5 });
            evaluations += 1;
            if contracted.1 < reflected.1.min(worst.1) {
                simplex[last] = contracted;
            } else {
                let best_point = simplex[0].0.clone();
                for corner in &mut simplex[1..] {
                    let halfway = corner.0.iter().zip(&best_point).map(|(x, b)| (x + b) / 2.0);
                    *corner = valued(halfway.collect());
                    evaluations += 1;
                }
            }
        }
    }
}

#[test]
fn the_simplex_finds_the_minimum_of_a_valley() {
    let valley =
        |u: &[f64]| (1.0 - u[0]).powi(2) * 4.0 + 100.0 * (u[1] - u[0] * u[0] * 0.5).powi(2);
    let (point, value) = descend(&[0.2, 0.9], 400, valley);
    assert!(value < 1e-3, "{point:?} {value}");
    assert_eq!(halton(3, 2), [0.75, 1.0 / 9.0]);
}
