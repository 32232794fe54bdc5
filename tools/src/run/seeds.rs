//! `--seeds A..B`.

use std::str::FromStr;

/// More runs than anyone waits for are a slip of the finger.
const SEEDS_MAX: u64 = 10_000;

/// A range of seeds, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seeds {
    first: u64,
    last: u64,
}

impl Seeds {
    /// The seeds, in order.
    #[must_use = "an iterator does nothing by itself"]
    pub fn iter(self) -> impl Iterator<Item = u64> {
        self.first..=self.last
    }
}

impl From<(u64, u64)> for Seeds {
    fn from((first, last): (u64, u64)) -> Self {
        Self { first, last }
    }
}

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (first, last) = text.split_once("..").ok_or("write the first and the last seed, as in 1..20")?;
        let number = |text: &str| {
            text.parse::<u64>().map_err(|_| format!("{text:?} is no seed: use 0 to {}", u64::MAX))
        };
        let (first, last) = (number(first)?, number(last)?);
        if first > last {
            return Err(format!("the first seed, {first}, is above the last, {last}"));
        }
        if last - first >= SEEDS_MAX {
            return Err(format!("that is more than {SEEDS_MAX} runs: divide the range"));
        }
        Ok(Self { first, last })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_are_included_and_slips_are_explained() {
        let seeds: Seeds = "3..5".parse().unwrap();
        assert_eq!(seeds.iter().collect::<Vec<_>>(), [3, 4, 5]);
        for (slip, says) in [
            ("7", "as in"),
            ("5..3", "above"),
            ("a..b", "no seed"),
            ("0..10000", "10000 runs"),
            ("-1..2", "no seed"),
        ] {
            let error = slip.parse::<Seeds>().unwrap_err();
            assert!(error.contains(says), "{slip}: {error}");
        }
        assert!(format!("0..{}", SEEDS_MAX - 1).parse::<Seeds>().is_ok());
    }
}
