//! Exams at one station: the time limit of a sitting.

use crate::Moment;

/// Longest time limit, in min.
pub const LONGEST_LIMIT_MIN: u32 = 120;

/// Reads a time limit, in min.
///
/// # Errors
/// If it is not a whole number from 1 to [`LONGEST_LIMIT_MIN`].
pub fn read_limit_min(typed: &str) -> Result<u32, String> {
    let number = typed.trim().parse().ok().filter(|minutes| (1..=LONGEST_LIMIT_MIN).contains(minutes));
    number.ok_or_else(|| {
        tr!("time limit: “{typed}”; allowed: 1 to {most} minutes", typed = typed.trim(), most = LONGEST_LIMIT_MIN)
    })
}

/// Stage of a sitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SittingStage {
    /// Within the time limit.
    Running,
    /// The time limit is over, and the form is not finished.
    Overdue,
    /// Finished within the time limit.
    Finished,
    /// Finished after the time limit.
    FinishedLate,
}

/// Times of a sitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SittingTimes {
    /// Begin.
    pub begun_at: Moment,
    /// When the examiner finished the form.
    pub finished_at: Option<Moment>,
    /// Time limit, in min.
    pub limit_min: u32,
}

impl SittingTimes {
    /// Returns the end of the time limit.
    #[must_use]
    pub fn ends_at(&self) -> Moment {
        self.begun_at.plus_s(i64::from(self.limit_min) * 60)
    }

    /// Returns the stage at a moment.
    #[must_use]
    pub fn stage(&self, now: Moment) -> SittingStage {
        match self.finished_at {
            None if now <= self.ends_at() => SittingStage::Running,
            None => SittingStage::Overdue,
            Some(at) if at <= self.ends_at() => SittingStage::Finished,
            Some(_) => SittingStage::FinishedLate,
        }
    }

    /// Returns the time left, in s; 0 once the limit is over.
    #[must_use]
    pub fn left_s(&self, now: Moment) -> f64 {
        self.ends_at().duration_since(now).as_secs_f64()
    }

    /// Returns by how much the limit is exceeded, in s: at the finish, or so far.
    #[must_use]
    pub fn late_s(&self, now: Moment) -> f64 {
        self.finished_at.unwrap_or(now).duration_since(self.ends_at()).as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    //! The last moment of the limit must count as within it, and a limit must be readable.

    use super::*;

    #[test]
    fn sitting_is_late_after_the_last_moment_of_its_limit() {
        let at = |s: i64| Moment::from_micros(0).plus_s(s);
        let running = SittingTimes { begun_at: at(0), finished_at: None, limit_min: 2 };
        assert_eq!([running.stage(at(120)), running.stage(at(121))], [SittingStage::Running, SittingStage::Overdue]);
        assert!((running.left_s(at(90)) - 30.0).abs() < 1e-9 && running.left_s(at(121)).abs() < 1e-9);
        let finished = |s| SittingTimes { finished_at: Some(at(s)), ..running };
        assert_eq!(finished(120).stage(at(500)), SittingStage::Finished);
        assert_eq!(finished(150).stage(at(500)), SittingStage::FinishedLate);
        assert!((finished(150).late_s(at(500)) - 30.0).abs() < 1e-9);
    }

    #[test]
    fn limit_is_a_number_of_minutes() {
        assert_eq!([read_limit_min(" 1 "), read_limit_min("120")], [Ok(1), Ok(120)]);
        for refused in ["0", "121", "-1", "1.5", "", "ten"] {
            assert!(read_limit_min(refused).is_err(), "{refused}");
        }
    }
}
