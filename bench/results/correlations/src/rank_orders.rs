//! p-values of Spearman's coefficient from the orders of the ranks, all of which are equally likely if there is no correlation.
//!
//! Ranks have ties at their mean rank.

/// Returns |Σxy − n x̄ȳ| of ranks, in proportion to |ρ| over all orders, which have the same means and variances. It is exact:
/// a quarter of an integer.
fn departure(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    (x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() - n * (0.5 * (n + 1.0)).powi(2)).abs()
}

/// Returns the fraction of all orders of `y` with a correlation to `x` at least as far from zero as the observed one: the
/// exact two-sided p-value of Spearman's coefficient, also with ties (Kendall and Gibbons 1990, section 4).
#[must_use]
pub fn p_of_all_orders(x: &[f64], y: &[f64]) -> f64 {
    let observed_departure = departure(x, y);
    let (mut extreme_orders, mut orders) = (0_u32, 0_u32);
    let mut order = y.to_vec();
    let mut count = |order: &[f64]| {
        orders += 1;
        extreme_orders += u32::from(departure(x, order) >= observed_departure);
    };
    // Heap's algorithm (1963).
    count(&order);
    let mut swap_counts = vec![0; order.len()];
    let mut i = 0;
    while i < order.len() {
        if swap_counts[i] < i {
            let j = if i % 2 == 0 { 0 } else { swap_counts[i] };
            order.swap(j, i);
            count(&order);
            swap_counts[i] += 1;
            i = 0;
        } else {
            swap_counts[i] = 0;
            i += 1;
        }
    }
    f64::from(extreme_orders) / f64::from(orders)
}

/// Returns the fraction of all orders of `y` that are perfect, rising or falling, and at least as far from zero correlation to
/// `x` as the observed one: no p-value is below it. Without ties it is 2/n!.
#[must_use]
pub fn p_of_perfect_orders(x: &[f64], y: &[f64]) -> f64 {
    let (mut rising_x, mut y) = (x.to_vec(), y.to_vec());
    let observed_departure = departure(&rising_x, &y);
    rising_x.sort_by(f64::total_cmp);
    let mut perfect_orders = 0.0;
    for compare in [f64::total_cmp, |a: &f64, b: &f64| b.total_cmp(a)] {
        y.sort_by(compare);
        if departure(&rising_x, &y) >= observed_departure {
            // All exchanges of equal x and of equal y lead to it, those of equal pairs by both: Πa! Πb!/Πc! of n! orders.
            let pairs: Vec<_> = rising_x.iter().zip(&y).collect();
            let ln_orders = ln_exchanges(&rising_x) + ln_exchanges(&y) - ln_exchanges(&pairs);
            perfect_orders += (ln_orders - ln_factorial(y.len())).exp();
        }
    }
    perfect_orders
}

/// Returns the logarithm of the number of exchanges of equal values, which are next to each other.
fn ln_exchanges<T: PartialEq>(values: &[T]) -> f64 {
    let ties = values.chunk_by(PartialEq::eq);
    ties.map(|tie| ln_factorial(tie.len())).sum()
}

fn ln_factorial(n: usize) -> f64 {
    (2..=n).map(|k| (k as f64).ln()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perfect_orders_are_counted_as_by_trying_all() {
        // Ranks with ties at their mean rank.
        let untied = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let pairs = [1.5, 1.5, 3.5, 3.5, 5.5, 5.5];
        for (x, y, p) in [
            (untied, untied, 2.0 / 720.0),
            (pairs, untied, 16.0 / 720.0),
            (pairs, [2.0, 2.0, 2.0, 4.5, 4.5, 6.0], 96.0 / 720.0),
            (
                [2.0, 2.0, 2.0, 5.0, 5.0, 5.0],
                [4.5, 4.5, 4.5, 4.5, 1.5, 1.5],
                0.4,
            ),
            (
                [3.0, 3.0, 3.0, 3.0, 3.0, 6.0],
                [3.0, 3.0, 3.0, 3.0, 3.0, 6.0],
                1.0 / 6.0,
            ),
        ] {
            for found in [p_of_all_orders(&x, &y), p_of_perfect_orders(&x, &y)] {
                assert!((found / p - 1.0).abs() < 1e-9, "{x:?} {y:?}: {found}");
            }
        }
    }
}
