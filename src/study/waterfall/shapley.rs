//! Shapley values: what each player of a game brings, the same whatever the order.
//!
//! A game gives every set S of n players a value v(S). A player's Shapley value is what it adds
//! to the set of those before it, the mean over all n! orders:
//!
//! ```text
//! φ_i = Σ_S |S|! (n - |S| - 1)! / n!  (v(S with i) - v(S)),   S without i
//! ```
//!
//! It is the only rule for which the values add up to v(all) - v(none) (efficiency), players
//! that do the same get the same (symmetry), one that changes nothing gets 0 (dummy), and the
//! values of a sum of games are the sums (Shapley 1953, doi:10.1515/9781400881970-018).

/// The Shapley value of each of `players` players, at most 20; the set of a game is a number
/// whose bit i says whether player i is in it.
///
/// # Panics
/// With more than 20 players.
#[must_use]
pub fn shapley(players: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
    assert!(players <= 20, "{players} players have too many sets");
    let values: Vec<f64> = (0..1 << players).map(value).collect();
    // Of a set of so many other players: s! (n - s - 1)! / n! = 1 / (n C(n - 1, s)).
    let mut weights = Vec::with_capacity(players);
    let mut sets = 1.0;
    for others in 0..players {
        weights.push(1.0 / (players as f64 * sets));
        sets *= (players - 1 - others) as f64 / (others + 1) as f64;
    }
    let added = |player: usize| {
        let own = 1 << player;
        (0..1_usize << players)
            .filter(|set| set & own == 0)
            .map(|set| weights[set.count_ones() as usize] * (values[set | own] - values[set]))
            .sum()
    };
    (0..players).map(added).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition: the mean over all orders.
    fn by_orders(players: usize, value: &dyn Fn(usize) -> f64) -> Vec<f64> {
        fn walk(
            left: &[usize],
            set: usize,
            value: &dyn Fn(usize) -> f64,
            sums: &mut [f64],
            orders: &mut u32,
        ) {
            if left.is_empty() {
                *orders += 1;
            }
            for (i, player) in left.iter().enumerate() {
                let mut rest = left.to_vec();
                rest.remove(i);
                let with = set | 1 << player;
                // Once for each order in which the rest may come.
                let times: usize = (1..=rest.len()).product();
                sums[*player] += times as f64 * (value(with) - value(set));
                walk(&rest, with, value, sums, orders);
            }
        }
        let all: Vec<usize> = (0..players).collect();
        let (mut sums, mut orders) = (vec![0.0; players], 0);
        walk(&all, 0, value, &mut sums, &mut orders);
        sums.iter().map(|sum| sum / f64::from(orders)).collect()
    }

    /// Values of all sets of up to 5 players, and how many players.
    fn games() -> impl Strategy<Value = (usize, Vec<f64>)> {
        (0..=5_usize).prop_flat_map(|n| (Just(n), prop::collection::vec(-9.0..9.0, 1 << n)))
    }

    proptest! {
        #[test]
        fn values_are_those_of_the_definition((players, game) in games()) {
            let found = shapley(players, |set| game[set]);
            let slow = by_orders(players, &|set| game[set]);
            prop_assert_eq!(found.len(), players);
            for (a, b) in found.iter().zip(&slow) {
                prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b);
            }
            // Efficiency.
            let whole = game[(1 << players) - 1] - game[0];
            prop_assert!((found.iter().sum::<f64>() - whole).abs() < 1e-9);
        }

        /// What nobody changes by being there is told apart from the others' game.
        #[test]
        fn a_player_that_changes_nothing_gets_nothing((players, game) in games()) {
            let others = (1 << players) - 1;
            let found = shapley(players + 1, |set| game[set & others]);
            prop_assert_eq!(found[players], 0.0);
            for (a, b) in found.iter().zip(shapley(players, |set| game[set])) {
                prop_assert!((a - b).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn an_additive_game_gives_each_its_own() {
        let own = [0.3, -0.1, 0.0, 0.25];
        let value = |set: usize| -> f64 {
            let there = own.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1);
            there.map(|(_, own)| own).sum()
        };
        for (found, own) in shapley(4, value).into_iter().zip(own) {
            assert!((found - own).abs() < 1e-12, "{found} {own}");
        }
    }

    #[test]
    fn what_only_some_do_together_is_shared_by_them_alike() {
        // Players 0 and 2 together make 6, player 1 makes 1, player 3 nothing.
        let value = |set: usize| 6.0 * f64::from(set & 0b101 == 0b101) + (set >> 1 & 1) as f64;
        let found = shapley(4, value);
        for (found, wanted) in found.into_iter().zip([3.0, 1.0, 3.0, 0.0]) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
        assert!(shapley(0, |_| 7.0).is_empty());
    }
}
