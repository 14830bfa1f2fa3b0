//! Chips that the public data allow: each number with an interval is drawn from it.
//!
//! A number is uniform over its interval, whole where it counts something, or log-uniform where
//! that spans decades ([`Interval::is_logarithmic`](crate::isa::Interval::is_logarithmic)). It is a
//! hash of the seed, the number's name and the chip, so that no other number and no other chip can
//! change it. The numbers are drawn independently: what the data say of several at once is left
//! out, which allows more chips than it should, not fewer.

use super::named::Named;
use crate::{
    elementary,
    isa::{Device, FigureError},
    rng::Hash,
};

/// What is drawn: a number of the chip, or its mismatch.
const NUMBER: u64 = 1;
const MISMATCH: u64 = 2;

/// One chip of those that the public data allow.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    /// Its number, from 0.
    pub chip: u64,
    /// The seed of its mismatch and of its noise.
    pub seed: u64,
    /// Its numbers.
    pub values: Vec<(Named, f64)>,
}

impl Drawn {
    /// The chip of this number.
    pub fn new(seed: u64, chip: u64, device: &Device) -> Self {
        let value = |named: Named| {
            let interval = named.interval(device)?;
            let name = named.name();
            let drawn = Hash::new(seed).with(NUMBER);
            let drawn = { name.bytes() }.fold(drawn, |hash, byte| hash.with(u64::from(byte)));
            let at = drawn.with(chip).uniform();
            let [low, high] = interval.ends();
            let value = if interval.is_logarithmic() {
                let (low, high) = (elementary::ln(low), elementary::ln(high));
                elementary::exp(low + at * (high - low))
            } else {
                low + at * (high - low)
            };
            let value = match named {
                Named::Figure(figure) if figure.range().numbers().1 => value.round(),
                _ => value,
            };
            Some((named, value.clamp(low, high)))
        };
        let all = Named::with_interval(device);
        Self {
            chip,
            seed: Hash::new(seed).with(MISMATCH).with(chip).bits(),
            values: all.into_iter().filter_map(value).collect(),
        }
    }

    /// The value of a number: the one that was drawn, else that of the chip's data.
    pub fn value(&self, named: Named, device: &Device) -> f64 {
        let drawn = self.values.iter().find(|(known, _)| *known == named);
        drawn.map_or_else(|| named.value(device), |(_, value)| *value)
    }

    /// The chip with the numbers on which its events depend.
    ///
    /// # Errors
    /// When a number makes no sense beside the others.
    pub fn device(&self, device: &Device) -> Result<Device, FigureError> {
        let mut own = device.clone();
        for (named, value) in &self.values {
            if let Named::Figure(figure) = named
                && named.is_of_events()
            {
                own = own.what_if(*figure, *value)?;
            }
        }
        Ok(own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::Figure;

    #[test]
    fn numbers_fill_their_intervals_and_belong_to_their_chip() {
        let device = Device::scamp5();
        let noise = Named::Figure(Figure::StoreNoise);
        let [low, high] = noise.ends(&device);
        let drawn: Vec<f64> = (0..200)
            .map(|chip| Drawn::new(3, chip, &device).value(noise, &device))
            .collect();
        assert!(drawn.iter().all(|value| (low..=high).contains(value)));
        let mean = drawn.iter().sum::<f64>() / 200.0;
        assert!((mean / (0.5 * (low + high)) - 1.0).abs() < 0.15, "{mean}");
        assert!(drawn.iter().any(|v| *v < low + 0.1 * (high - low)));
        assert!(drawn.iter().any(|v| *v > high - 0.1 * (high - low)));
        let [one, same, other] = [(3, 5), (3, 5), (3, 6)].map(|(s, c)| Drawn::new(s, c, &device));
        assert_eq!(one, same);
        assert_ne!((one.seed, one.values[0].1), (other.seed, other.values[0].1));
    }

    #[test]
    fn a_number_that_was_set_is_not_drawn() {
        let device = Device::scamp5().what_if(Figure::StoreNoise, 0.07).unwrap();
        for chip in 0..4 {
            let own = Drawn::new(0, chip, &device).device(&device).unwrap();
            assert_eq!(own.value(Figure::StoreNoise).to_bits(), 0.07_f64.to_bits());
            assert!(own.value(Figure::Headroom) <= 40.0);
        }
    }
}
