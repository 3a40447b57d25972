//! Random bytes for a target until its time is over, with figures.

use arbitrary::Unstructured;
use proptest::collection::vec;
use proptest::prelude::any;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::cell::Cell;
use std::fmt;
use std::time::{Duration, Instant};

/// Inputs between two looks at the clock.
const BATCH: u32 = 200;
/// Most random bytes of one input.
const CHOICES: usize = 160;

/// What a target was given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CampaignFigures {
    /// Inputs that it was tried with.
    pub inputs: u64,
    /// Those of them that it took; the others were refused.
    pub taken: u64,
    /// Largest number of bytes allocated at one time for each byte of an input.
    pub worst_ratio: f64,
}

impl fmt::Display for CampaignFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            inputs,
            taken,
            worst_ratio,
        } = self;
        write!(
            f,
            "{inputs} inputs, {taken} taken, at most {worst_ratio:.1} bytes for a byte"
        )
    }
}

/// What became of one input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tried {
    /// Whether it was taken.
    pub taken: bool,
    /// Bytes allocated at one time for each byte of it.
    pub ratio: f64,
}

/// Seconds that a target has: those of the variable `PHEX_FUZZ_SECONDS`, else one.
fn time() -> Duration {
    let typed = std::env::var("PHEX_FUZZ_SECONDS")
        .ok()
        .and_then(|t| t.parse().ok());
    Duration::from_secs_f64(typed.unwrap_or(1.0))
}

/// Tries a target with random bytes until its time is over; an input that fails is made smaller
/// before it is shown. Seeds of the variable `PHEX_FUZZ_SEED`, 0 without it.
///
/// # Panics
/// If the target panics, or finds something wrong.
pub fn campaign(target: impl Fn(&mut Unstructured) -> Result<Tried, String>) -> CampaignFigures {
    let typed = std::env::var("PHEX_FUZZ_SEED")
        .ok()
        .and_then(|t| t.parse().ok());
    let (first, end) = (typed.unwrap_or(0u64), Instant::now() + time());
    let figures = Cell::new(CampaignFigures::default());
    let one = |random: Vec<u8>| {
        let tried = target(&mut Unstructured::new(&random)).map_err(TestCaseError::fail)?;
        figures.set(figures.get().with(tried));
        Ok(())
    };
    let mut round = 0;
    while round == 0 || Instant::now() < end {
        let outcome = runner(first, round).run(&vec(any::<u8>(), 0..CHOICES), one);
        if let Err(error) = outcome {
            panic!("seed {first}, round {round}: {error}");
        }
        round += 1;
    }
    figures.get()
}

fn runner(first: u64, round: u64) -> TestRunner {
    let mut seed = [0; 32];
    seed[..8].copy_from_slice(&first.to_le_bytes());
    seed[8..16].copy_from_slice(&round.to_le_bytes());
    let config = Config {
        cases: BATCH,
        failure_persistence: None,
        ..Config::default()
    };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &seed))
}

impl CampaignFigures {
    fn with(self, tried: Tried) -> Self {
        Self {
            inputs: self.inputs + 1,
            taken: self.taken + u64::from(tried.taken),
            worst_ratio: self.worst_ratio.max(tried.ratio),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_counted() {
        let figures = campaign(|u| {
            Ok(Tried {
                taken: u.arbitrary().unwrap_or(false),
                ratio: 2.0,
            })
        });
        assert!(
            figures.inputs >= u64::from(BATCH)
                && figures.taken > 0
                && figures.taken < figures.inputs
        );
        assert_eq!(figures.worst_ratio, 2.0);
    }

    #[test]
    #[should_panic(expected = "too many")]
    fn what_a_target_finds_is_told() {
        campaign(|u| match u.len() > 40 {
            true => Err("too many".to_owned()),
            false => Ok(Tried::default()),
        });
    }
}
