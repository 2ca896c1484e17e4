//! Fingertips have the published moments and correlation, and given values are kept.

use mock_world::fingertip::Fingertip;
use mock_world::scenario::Scenario;

fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut out = vec![0.0; values.len()];
    for (rank, &i) in order.iter().enumerate() {
        out[i] = rank as f64;
    }
    out
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let cov: f64 = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum();
    let va: f64 = a.iter().map(|x| (x - ma).powi(2)).sum();
    let vb: f64 = b.iter().map(|y| (y - mb).powi(2)).sum();
    cov / (va * vb).sqrt()
}

#[test]
fn the_population_has_the_published_moments_and_correlation() {
    let people: Vec<Fingertip> = (0..4000)
        .map(|seed| Fingertip::draw(&Scenario::default(), seed))
        .collect();
    let mean = |f: fn(&Fingertip) -> f64| people.iter().map(f).sum::<f64>() / 4000.0;
    assert!((mean(|p| p.sigma_t_m) - 1.7e-6).abs() < 0.03e-6);
    assert!((mean(|p| p.z_t_n_s_per_m[1]) - 3.16).abs() < 0.05);
    // Truncation at 0.05 N·s/m raises the mean of 0.47 ± 0.28 to 0.51.
    assert!((mean(|p| p.z_t_n_s_per_m[0]) - 0.51).abs() < 0.02);
    assert!(
        people
            .iter()
            .all(|p| p.z_t_n_s_per_m[0] >= 0.05 && p.sigma_t_m > 0.0)
    );
    let im: Vec<f64> = people.iter().map(|p| p.z_t_n_s_per_m[1]).collect();
    let mu0: Vec<f64> = people.iter().map(|p| p.mu0).collect();
    let spearman = correlation(&ranks(&im), &ranks(&mu0));
    assert!((spearman + 0.58).abs() < 0.04, "{spearman}");
}

#[test]
fn pinned_values_hold_and_leave_the_others_as_they_were() {
    let free = Fingertip::draw(&Scenario::default(), 3);
    let mut scenario = Scenario::default();
    scenario.participant.z_t_n_s_per_m = Some([0.5, 3.0]);
    let fingertip = Fingertip::draw(&scenario, 3);
    assert_eq!(fingertip.z_t_n_s_per_m, [0.5, 3.0]);
    assert_eq!(
        (fingertip.sigma_t_m, fingertip.mu0),
        (free.sigma_t_m, free.mu0)
    );
}
