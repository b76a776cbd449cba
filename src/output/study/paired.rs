//! Numbers that keep their repeats: differences and ratios of cells timed in the same rounds are computed round by
//! round, so that a drift of the machine's speed, common to all of them, cancels.

use super::interval::Interval;

/// A number with its interval and, where it is a time on the device, its value in each round.
#[derive(Clone, Debug, PartialEq)]
pub struct Repeated {
    /// Median and confidence interval.
    pub interval: Interval,
    rounds: Option<Rounds>,
}

#[derive(Clone, Debug, PartialEq)]
struct Rounds {
    block: Block,
    values: Vec<f64>,
}

/// Cells that were timed in turn, in the same rounds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Id of the experiment.
    pub experiment: String,
    /// Key of the truth, which identifies scene and image size.
    pub reference: String,
    /// Index of the block's first cell.
    pub first: usize,
}

impl Repeated {
    /// A number from its value in each round of a block; an error where there are too few rounds.
    pub fn of_rounds(block: Block, values: Vec<f64>) -> Result<Self, String> {
        Ok(Self {
            interval: Interval::of_repeats(&values)?,
            rounds: Some(Rounds { block, values }),
        })
    }

    /// Difference: round by round, or by interval arithmetic where the two do not share rounds.
    pub fn minus(&self, other: &Self) -> Result<Self, String> {
        match self.together(other) {
            Some(pairs) => pairs.map(|a, b| a - b),
            None => Ok(self.interval.minus(other.interval).into()),
        }
    }

    /// Quotient: round by round, or by interval arithmetic where the two do not share rounds. An error where the
    /// divisor may be 0.
    pub fn over(&self, other: &Self) -> Result<Self, String> {
        match self.together(other) {
            Some(pairs) if pairs.b.iter().all(|b| *b > 0.0) => pairs.map(|a, b| a / b),
            _ => Ok(self.interval.over(other.interval)?.into()),
        }
    }

    /// Confidence interval of the median with the probability `confidence`, or [`Self::interval`] without rounds.
    pub fn range_at(&self, confidence: f64) -> Result<Interval, String> {
        match &self.rounds {
            Some(rounds) => Interval::of_repeats_at(&rounds.values, confidence),
            None => Ok(self.interval),
        }
    }

    fn together<'a>(&'a self, other: &'a Self) -> Option<Pairs<'a>> {
        let (a, b) = (self.rounds.as_ref()?, other.rounds.as_ref()?);
        let same = a.block == b.block && a.values.len() == b.values.len();
        same.then_some(Pairs {
            block: &a.block,
            a: &a.values,
            b: &b.values,
        })
    }
}

impl From<Interval> for Repeated {
    fn from(interval: Interval) -> Self {
        Self {
            interval,
            rounds: None,
        }
    }
}

/// Values of two numbers in the same rounds.
struct Pairs<'a> {
    block: &'a Block,
    a: &'a [f64],
    b: &'a [f64],
}

impl Pairs<'_> {
    fn map(&self, f: impl Fn(f64, f64) -> f64) -> Result<Repeated, String> {
        let values = self.a.iter().zip(self.b).map(|(a, b)| f(*a, *b)).collect();
        Repeated::of_rounds(self.block.clone(), values)
    }
}

/// Removes the drift common to all numbers: scales each round so that its sum is the mean of all rounds' sums. Numbers
/// that were not measured in the same rounds are returned unchanged.
pub fn without_drift(numbers: Vec<Repeated>) -> Result<Vec<Repeated>, String> {
    let Some(first) = numbers.first().and_then(|n| n.rounds.as_ref()) else {
        return Ok(numbers);
    };
    let (block, rounds) = (first.block.clone(), first.values.len());
    let mut sums = vec![0.0; rounds];
    for number in &numbers {
        match &number.rounds {
            Some(own) if own.block == block && own.values.len() == rounds => {
                sums.iter_mut().zip(&own.values).for_each(|(s, v)| *s += v);
            }
            _ => return Ok(numbers),
        }
    }
    let mean = sums.iter().sum::<f64>() / rounds as f64;
    if sums.iter().any(|sum| *sum <= 0.0) {
        return Ok(numbers);
    }
    let scaled = |number: &Repeated| {
        let values = number.rounds.iter().flat_map(|own| &own.values);
        let values = values.zip(&sums).map(|(v, sum)| v * mean / sum).collect();
        Repeated::of_rounds(block.clone(), values)
    };
    numbers.iter().map(scaled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(first: usize, values: &[f64]) -> Repeated {
        let block = Block {
            experiment: "e".to_owned(),
            reference: "r".to_owned(),
            first,
        };
        Repeated::of_rounds(block, values.to_vec()).unwrap()
    }

    #[test]
    fn a_drift_drops_out_of_what_shares_its_rounds_and_of_nothing_else() {
        let drift = [10.0, 20.0, 40.0];
        let (a, b) = (times(0, &drift.map(|t| 3.0 * t)), times(0, &drift));
        let exact = |value| Interval {
            low: value,
            value,
            high: value,
        };
        assert_eq!(a.over(&b).unwrap().interval, exact(3.0));
        let growth = a.minus(&b).unwrap().over(&b).unwrap();
        assert_eq!(growth.interval, exact(2.0), "a difference keeps its rounds");
        let other = times(7, &drift);
        let apart = a.over(&other).unwrap().interval;
        assert_eq!((apart.low, apart.high), (0.75, 12.0));
        let single = Repeated::from(exact(10.0));
        assert_eq!(a.over(&single).unwrap().interval.high, 12.0);
    }

    #[test]
    fn numbers_of_the_same_rounds_lose_what_they_share() {
        let drift = [1.0, 2.0, 4.0];
        let shared = vec![times(0, &drift), times(0, &drift.map(|t| 3.0 * t))];
        let steady = without_drift(shared).unwrap();
        for (number, share) in steady.iter().zip([0.25, 0.75]) {
            let interval = number.interval;
            assert!((interval.high - interval.low).abs() < 1e-12);
            assert!((interval.value - share * 28.0 / 3.0).abs() < 1e-12);
        }
        let apart = vec![times(0, &drift), times(1, &drift)];
        assert_eq!(without_drift(apart.clone()).unwrap(), apart);
    }
}
