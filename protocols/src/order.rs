//! Orders of conditions: fixed, randomised, counterbalanced.

use crate::protocol::Order;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Returns the indices of the conditions in `blocks` blocks, each with every condition once.
///
/// `participant` selects the row of a counterbalanced design; `stream` gives participants with the same seed different
/// randomised orders.
pub(crate) fn conditions(
    order: Order,
    conditions: usize,
    blocks: u32,
    participant: u32,
    seed: u64,
    stream: u64,
) -> Vec<usize> {
    match order {
        Order::Fixed => (0..blocks).flat_map(|_| 0..conditions).collect(),
        Order::Randomised => {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream);
            (0..blocks)
                .flat_map(|_| {
                    let mut block: Vec<usize> = (0..conditions).collect();
                    block.shuffle(&mut rng);
                    block
                })
                .collect()
        }
        Order::Counterbalanced => {
            let rows = williams(conditions);
            (0..blocks)
                .flat_map(|block| {
                    let row = (participant as usize + block as usize) % rows.len();
                    rows[row].clone()
                })
                .collect()
        }
    }
}

/// Returns a Williams design: over its rows each condition stands in each place equally often and follows each
/// other condition equally often. `n` rows for even `n`, 2`n` (the rows and their mirror images) for odd.
///
/// E. J. Williams, Experimental designs balanced for the estimation of residual effects of treatments,
/// Aust. J. Sci. Res. A 2, 1949.
fn williams(n: usize) -> Vec<Vec<usize>> {
    // 0, 1, n−1, 2, n−2, …: successive differences are all different modulo n.
    let first: Vec<usize> = (0..n)
        .map(|place| {
            if place % 2 == 1 {
                place.div_ceil(2)
            } else {
                (n - place / 2) % n
            }
        })
        .collect();
    let rows = (0..n).map(|shift| first.iter().map(|c| (c + shift) % n).collect::<Vec<_>>());
    if n.is_multiple_of(2) {
        return rows.collect();
    }
    rows.flat_map(|row| {
        let mirror = row.iter().rev().copied().collect();
        [row, mirror]
    })
    .collect()
}

/// Returns the FNV-1a hash of the participant's identifier: a stream number that is the same in every version.
pub(crate) fn stream(participant: &str) -> u64 {
    participant
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::HashMap;

    #[test]
    fn williams_of_four_is_the_published_square() {
        assert_eq!(
            williams(4),
            [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]
        );
    }

    proptest! {
        #[test]
        fn williams_balances_places_and_successions(n in 2usize..12) {
            let rows = williams(n);
            let mut places = HashMap::new();
            let mut successions = HashMap::new();
            for row in &rows {
                for (place, condition) in row.iter().enumerate() {
                    *places.entry((place, *condition)).or_insert(0) += 1;
                }
                for pair in row.windows(2) {
                    *successions.entry((pair[0], pair[1])).or_insert(0) += 1;
                }
            }
            prop_assert_eq!(places.len(), n * n);
            prop_assert_eq!(successions.len(), n * (n - 1));
            let per_cell = rows.len() / n;
            prop_assert!(places.values().chain(successions.values()).all(|&k| k == per_cell));
        }

        #[test]
        fn every_order_holds_each_condition_once_a_block(
            n in 2usize..10, blocks in 1u32..8, participant in 0u32..50, seed: u64,
        ) {
            for order in [Order::Fixed, Order::Randomised, Order::Counterbalanced] {
                let schedule = conditions(order, n, blocks, participant, seed, stream("sub-01"));
                prop_assert_eq!(schedule.len(), n * blocks as usize);
                for block in schedule.chunks(n) {
                    let mut indices = block.to_vec();
                    indices.sort_unstable();
                    prop_assert_eq!(indices, (0..n).collect::<Vec<_>>());
                }
            }
        }
    }

    #[test]
    fn a_seed_reproduces_an_order_and_participants_differ() {
        let order_of = |seed, id| conditions(Order::Randomised, 8, 4, 0, seed, stream(id));
        assert_eq!(order_of(1, "sub-01"), order_of(1, "sub-01"));
        assert_ne!(order_of(1, "sub-01"), order_of(2, "sub-01"));
        assert_ne!(order_of(1, "sub-01"), order_of(1, "sub-02"));
    }

    #[test]
    fn an_order_stays_the_same_between_versions() {
        // Written by this code; a change would break resuming sessions begun with an earlier version.
        assert_eq!(
            conditions(Order::Randomised, 5, 2, 0, 2021, stream("sub-01")),
            [4, 3, 1, 2, 0, 4, 1, 3, 0, 2]
        );
    }
}
