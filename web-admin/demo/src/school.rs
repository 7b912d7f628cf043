//! The people of the demonstration school, and how each of them learns. The stories are chosen so
//! that every page has something to show: a quick learner, one who is stuck, one who stopped
//! coming, and one who relapses.

use law::operator::Skill;

/// Name of the school.
pub const SCHOOL: &str = "Demonstration School of Medicine";
/// Name of the administrator.
pub const ADMINISTRATOR: &str = "Ingrid Halvorsen";

/// A cohort with its instructor.
#[derive(Clone, Copy, Debug)]
pub struct DemoCohort {
    /// Name.
    pub name: &'static str,
    /// Name of its instructor.
    pub instructor: &'static str,
}

/// The cohorts.
pub const COHORTS: [DemoCohort; 2] = [
    DemoCohort { name: "Year 4, group A", instructor: "Miriam Osei" },
    DemoCohort { name: "Year 4, group B", instructor: "Tomás Ferreira" },
];

/// Instructors without a cohort. Together with the cohorts' instructors they are the experts of the
/// reference corridor, and they rate attempts.
pub const EXPERTS: [&str; 3] = ["Yusuf Demir", "Clara Bennett", "Priya Raman"];

/// The cohort of the year before, last by name. The instructor of the first cohort taught it, too.
pub const COHORT_BEFORE: &str = "Year 4, the year before";

/// Attendance and learning curve of a trainee.
#[derive(Clone, Copy, Debug)]
pub struct Learner {
    /// Name.
    pub name: &'static str,
    /// Index into [`COHORTS`].
    pub cohort: usize,
    /// Skill at the first attempt: 0 is the novice preset, 1 the expert.
    pub start: f64,
    /// Fraction of the remaining distance to expert skill gained per attempt.
    pub gain: f64,
    /// Weekdays with an attempt; 0 is Monday.
    pub days: &'static [u8],
    /// Number of weeks at the end of the demonstration without attempts.
    pub absent_weeks: u32,
    /// Number of weeks at the end of the demonstration with the skill of the first day.
    pub slump_weeks: u32,
}

const fn steady_hand(name: &'static str, cohort: usize, start: f64, gain: f64) -> Learner {
    Learner { name, cohort, start, gain, days: &[0, 2, 4], absent_weeks: 0, slump_weeks: 0 }
}

/// The trainees.
pub const LEARNERS: [Learner; 14] = [
    steady_hand("Ada Okafor", 0, 0.20, 0.10),
    Learner { days: &[0, 3], ..steady_hand("Bruno Keller", 0, 0.00, 0.06) },
    steady_hand("Chidi Mbeki", 0, 0.30, 0.08),
    Learner { days: &[1, 3], absent_weeks: 3, ..steady_hand("Daria Novak", 0, 0.05, 0.06) },
    Learner { days: &[1, 4], ..steady_hand("Emil Sørensen", 0, 0.00, 0.003) },
    steady_hand("Fatima Haddad", 0, 0.10, 0.07),
    Learner { days: &[0, 2], ..steady_hand("George Whitlock", 0, 0.00, 0.05) },
    // Attends often enough to master the whole course in six weeks, and gets a certificate.
    Learner { days: &[0, 2, 3, 4], ..steady_hand("Hana Suzuki", 1, 0.40, 0.15) },
    Learner { days: &[0, 1, 3], slump_weeks: 2, ..steady_hand("Ivan Petrov", 1, 0.10, 0.10) },
    Learner { days: &[2, 4], ..steady_hand("Julia Lindqvist", 1, 0.05, 0.06) },
    steady_hand("Kofi Asante", 1, 0.15, 0.09),
    Learner { days: &[1], ..steady_hand("Leila Rahimi", 1, 0.30, 0.10) },
    Learner { days: &[0, 3], ..steady_hand("Mateo Vargas", 1, 0.00, 0.03) },
    Learner { days: &[], ..steady_hand("Nina Castellano", 1, 0.30, 0.10) },
];

/// The trainees of [`COHORT_BEFORE`], who have left the school.
pub const LEARNERS_BEFORE: [Learner; 5] = [
    Learner { days: &[1, 3], ..steady_hand("Olivia Marchetti", 0, 0.15, 0.08) },
    Learner { days: &[2], ..steady_hand("Pavel Dvorak", 0, 0.05, 0.05) },
    Learner { days: &[0], ..steady_hand("Quentin Moreau", 0, 0.20, 0.08) },
    Learner { days: &[4], ..steady_hand("Rosa Almeida", 0, 0.10, 0.06) },
    Learner { days: &[3], ..steady_hand("Samir Rahman", 0, 0.00, 0.04) },
];

impl Learner {
    /// Returns the skill at the n-th attempt, from 0, with `weeks_left` before the end: an
    /// exponential learning curve from `start`, or a slump.
    #[must_use]
    pub fn skill(&self, n: u32, weeks_left: u32) -> Skill {
        let learned = if weeks_left < self.slump_weeks { 0 } else { n };
        let remaining = (1.0 - self.start) * libm::pow(1.0 - self.gain, f64::from(learned));
        Skill::novice().towards(&Skill::expert(), 1.0 - remaining)
    }

    /// Whether the person practises so often that they master the whole course, always with an instructor.
    #[must_use]
    pub const fn is_certified(&self) -> bool {
        self.days.len() > 3
    }

    /// Whether an attempt falls on a day, `weeks_left` before the end.
    #[must_use]
    pub fn comes(&self, weekday: u8, weeks_left: u32) -> bool {
        weeks_left >= self.absent_weeks && self.days.contains(&weekday)
    }
}

/// Returns the email address of a person.
#[must_use]
pub fn email_of(name: &str) -> String {
    let plain = name.to_lowercase().replace(' ', ".");
    let ascii = plain.chars().map(|c| match c {
        'á' => 'a',
        'ø' => 'o',
        other => other,
    });
    format!("{}@demo.example", ascii.collect::<String>())
}

#[cfg(test)]
mod tests {
    //! Every address must be plain ASCII and unique, and practice must improve skill.

    use super::*;

    #[test]
    fn every_address_is_plain_and_unique() {
        let instructors = COHORTS.iter().map(|cohort| cohort.instructor);
        let names = LEARNERS
            .iter()
            .chain(&LEARNERS_BEFORE)
            .map(|learner| learner.name)
            .chain(instructors)
            .chain(EXPERTS)
            .chain([ADMINISTRATOR]);
        let mut addresses: Vec<_> = names.map(email_of).collect();
        assert!(addresses.iter().all(|address| address.is_ascii()), "{addresses:?}");
        addresses.sort();
        addresses.dedup();
        let learners = LEARNERS.len() + LEARNERS_BEFORE.len();
        assert_eq!(addresses.len(), learners + COHORTS.len() + EXPERTS.len() + 1);
    }

    #[test]
    fn practice_steadies_the_hand() {
        for learner in LEARNERS {
            let (first, later) = (learner.skill(0, 9), learner.skill(20, 9));
            assert!(later.tremor_m < first.tremor_m && later.angle_sd_rad < first.angle_sd_rad, "{}", learner.name);
        }
    }
}
