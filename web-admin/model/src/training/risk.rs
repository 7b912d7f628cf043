//! People at risk: the school's rules, and the reasons why a trainee may need help.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use crate::Moment;
use crate::ids::PersonId;

/// Number of attempts in each of the two runs whose mean scores are compared.
pub const RUN: usize = 3;
/// Attempts and due dates further back are not considered, in days: twelve weeks.
pub const CONSIDERED_DAYS: i64 = 84;

/// A rule by which a trainee is at risk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "snake_case"))]
pub enum RiskRule {
    /// No attempt, a number of days before the due date.
    NotBegun,
    /// A number of failures in a row at an exercise.
    Failing,
    /// The mean of the latest [`RUN`] scores is a number of points below that of the [`RUN`] before.
    Falling,
    /// No practice for a number of weeks, in a course that is not passed.
    Inactive,
}

impl RiskRule {
    /// All rules, in the order of the page.
    pub const ALL: [Self; 4] = [Self::NotBegun, Self::Failing, Self::Falling, Self::Inactive];

    /// Returns the name used in forms and the database.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotBegun => "not_begun",
            Self::Failing => "failing",
            Self::Falling => "falling",
            Self::Inactive => "inactive",
        }
    }

    /// Returns the numbers permitted.
    #[must_use]
    pub const fn limits(self) -> RangeInclusive<u32> {
        match self {
            Self::NotBegun => 0..=60,
            Self::Failing => 2..=20,
            Self::Falling => 1..=100,
            Self::Inactive => 1..=11,
        }
    }

    /// Returns the setting of a school that has not changed it.
    #[must_use]
    pub const fn usual(self) -> RuleSetting {
        let (number, weight) = match self {
            Self::NotBegun => (7, 3),
            Self::Failing => (3, 2),
            Self::Falling => (10, 2),
            Self::Inactive => (2, 1),
        };
        RuleSetting { rule: self, applies: true, number, weight }
    }
}

/// Weights that a rule may have.
pub const WEIGHTS: RangeInclusive<u32> = 1..=9;

/// A rule as a school has set it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct RuleSetting {
    /// The rule.
    pub rule: RiskRule,
    /// Whether it applies.
    pub applies: bool,
    /// Its number of days, failures, points or weeks.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "i64"))]
    pub number: u32,
    /// What it adds to the rank of a person.
    #[cfg_attr(feature = "sqlx", sqlx(try_from = "i64"))]
    pub weight: u32,
}

/// The rules of a school.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RiskRules([RuleSetting; 4]);

impl RiskRules {
    /// Completes the stored settings by the usual ones.
    #[must_use]
    pub fn of(stored: &[RuleSetting]) -> Self {
        let setting = |rule: RiskRule| stored.iter().copied().find(|of| of.rule == rule).unwrap_or(rule.usual());
        Self(RiskRule::ALL.map(setting))
    }

    /// Returns the settings, in the order of [`RiskRule::ALL`].
    #[must_use]
    pub const fn settings(&self) -> &[RuleSetting; 4] {
        &self.0
    }

    /// Returns the number of a rule if it applies.
    #[must_use]
    pub fn number(&self, rule: RiskRule) -> Option<u32> {
        self.0.iter().find(|of| of.rule == rule && of.applies).map(|of| of.number)
    }

    fn weight(&self, rule: RiskRule) -> u32 {
        self.0.iter().find(|of| of.rule == rule).map_or(0, |of| of.weight)
    }
}

/// A reason why a trainee may need help, with its figures.
#[derive(Clone, Debug, PartialEq)]
pub enum Concern {
    /// No attempt at an assignment.
    NotBegun {
        /// Title of the exercise or course.
        title: String,
        /// When it is due, with the trainee's extension.
        due_at: Moment,
    },
    /// Failures in a row.
    Failing {
        /// Id of the exercise.
        exercise: String,
        /// Its title.
        title: String,
        /// Number of failures.
        fails: u32,
        /// Last score, 0–100.
        last_score: f64,
    },
    /// Falling scores.
    Falling {
        /// Id of the exercise.
        exercise: String,
        /// Its title.
        title: String,
        /// Mean of the earlier run, 0–100.
        from: f64,
        /// Mean of the latest run, 0–100.
        to: f64,
    },
    /// No practice.
    Inactive {
        /// Whole days since the last attempt.
        days: i64,
    },
}

impl Concern {
    /// Returns the rule that applies.
    #[must_use]
    pub const fn rule(&self) -> RiskRule {
        match self {
            Self::NotBegun { .. } => RiskRule::NotBegun,
            Self::Failing { .. } => RiskRule::Failing,
            Self::Falling { .. } => RiskRule::Falling,
            Self::Inactive { .. } => RiskRule::Inactive,
        }
    }

    /// Returns the id of the exercise concerned, if there is one.
    #[must_use]
    pub fn exercise(&self) -> Option<&str> {
        match self {
            Self::Failing { exercise, .. } | Self::Falling { exercise, .. } => Some(exercise),
            Self::NotBegun { .. } | Self::Inactive { .. } => None,
        }
    }

    /// How pressing it is among those of the same rule, the least first.
    fn order(&self) -> f64 {
        match self {
            Self::NotBegun { due_at, .. } => due_at.micros() as f64,
            Self::Failing { fails, .. } => -f64::from(*fails),
            Self::Falling { from, to, .. } => to - from,
            Self::Inactive { days } => -(*days as f64),
        }
    }
}

/// A concern about a trainee.
#[derive(Clone, Debug, PartialEq)]
pub struct TraineeConcern {
    /// The trainee.
    pub trainee: TraineeAddress,
    /// The concern.
    pub concern: Concern,
}

/// A trainee, and whether mail reaches them.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct TraineeAddress {
    /// Id.
    pub id: PersonId,
    /// Name.
    pub name: String,
    /// Whether an email address is known.
    pub has_address: bool,
}

/// A trainee at risk.
#[derive(Clone, Debug, PartialEq)]
pub struct PersonAtRisk {
    /// The trainee.
    pub trainee: TraineeAddress,
    /// Why, the most pressing first; never empty.
    pub concerns: Vec<Concern>,
    /// Sum of the weights of the rules that apply, each counted once.
    pub weight: u32,
}

/// Gathers the concerns by trainee and ranks these: by the weight of the rules that apply, then by
/// the number of concerns, then by name.
#[must_use]
pub fn rank_people(rules: &RiskRules, found: Vec<TraineeConcern>) -> Vec<PersonAtRisk> {
    let mut people: BTreeMap<PersonId, PersonAtRisk> = BTreeMap::new();
    for TraineeConcern { trainee, concern } in found {
        let person = people.entry(trainee.id);
        let person = person.or_insert_with(|| PersonAtRisk { trainee, concerns: Vec::new(), weight: 0 });
        if !person.concerns.iter().any(|known| known.rule() == concern.rule()) {
            person.weight += rules.weight(concern.rule());
        }
        person.concerns.push(concern);
    }
    let mut ranked: Vec<PersonAtRisk> = people.into_values().collect();
    for person in &mut ranked {
        let key = |concern: &Concern| (std::cmp::Reverse(rules.weight(concern.rule())), concern.rule());
        person.concerns.sort_by(|a, b| key(a).cmp(&key(b)).then(a.order().total_cmp(&b.order())));
    }
    let key = |of: &PersonAtRisk| std::cmp::Reverse((of.weight, of.concerns.len()));
    ranked.sort_by(|a, b| key(a).cmp(&key(b)).then_with(|| a.trainee.name.cmp(&b.trainee.name)));
    ranked
}

/// Latest scores of a trainee at an exercise, in summary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PracticeSigns {
    /// Last score, 0–100.
    pub last_score: f64,
    /// Number of passes.
    pub passes: u32,
    /// Number of failures since the last pass.
    pub fails: u32,
    /// Mean of the latest [`RUN`] scores, and by how many points it is below that of the [`RUN`]
    /// before; `None` for fewer attempts.
    pub fall: Option<(f64, f64)>,
}

impl PracticeSigns {
    /// Computes the signs from the score of each attempt and whether it passed, in order of time;
    /// `None` without attempts.
    #[must_use]
    pub fn of(attempts: &[(f64, bool)]) -> Option<Self> {
        let (last_score, _) = *attempts.last()?;
        let mean = |run: &[(f64, bool)]| run.iter().map(|(score, _)| score).sum::<f64>() / RUN as f64;
        let split = attempts.len().checked_sub(RUN);
        let runs = split.zip(attempts.len().checked_sub(2 * RUN));
        Some(Self {
            last_score,
            passes: crate::count_u32(attempts.iter().filter(|(_, passed)| *passed).count()),
            fails: crate::count_u32(attempts.iter().rev().take_while(|(_, passed)| !passed).count()),
            fall: runs.map(|(split, begin)| {
                let last = mean(&attempts[split..]);
                (last, mean(&attempts[begin..split]) - last)
            }),
        })
    }
}

#[cfg(test)]
mod tests {
    //! Fails when a run is counted wrongly, and when a lesser concern is put first.

    use super::*;

    fn signs(scores: &[f64]) -> PracticeSigns {
        let attempts: Vec<_> = scores.iter().map(|score| (*score, *score >= 60.0)).collect();
        PracticeSigns::of(&attempts).unwrap()
    }

    #[test]
    fn failures_count_since_the_last_pass() {
        assert_eq!(PracticeSigns::of(&[]), None);
        let of = signs(&[20.0, 70.0, 30.0, 41.0]);
        assert_eq!((of.fails, of.passes, of.last_score, of.fall), (2, 1, 41.0, None));
        assert_eq!(signs(&[10.0, 70.0]).fails, 0);
    }

    #[test]
    fn a_fall_compares_the_two_latest_runs_of_three() {
        assert_eq!(signs(&[1.0, 90.0, 90.0, 90.0, 70.0, 75.0, 80.0]).fall, Some((75.0, 15.0)));
        assert_eq!(signs(&[90.0, 90.0, 70.0, 75.0, 80.0]).fall, None, "five attempts are too few");
    }

    #[test]
    fn people_are_ranked_by_weight_then_number_then_name() {
        let trainee = |n: u128, name: &str| TraineeAddress {
            id: PersonId::from_u128(n),
            name: name.to_owned(),
            has_address: true,
        };
        let inactive =
            |n, name: &str, days| TraineeConcern { trainee: trainee(n, name), concern: Concern::Inactive { days } };
        let failing = |n, name: &str, fails| TraineeConcern {
            trainee: trainee(n, name),
            concern: Concern::Failing { exercise: format!("e{fails}"), title: String::new(), fails, last_score: 1.0 },
        };
        let found = vec![
            inactive(1, "Ada", 20),
            inactive(2, "Ben", 20),
            failing(3, "Cem", 3),
            failing(4, "Dora", 3),
            failing(4, "Dora", 5),
            inactive(3, "Cem", 30),
        ];
        let ranked = rank_people(&RiskRules::of(&[]), found);
        let names: Vec<_> = ranked.iter().map(|of| (of.trainee.name.as_str(), of.weight)).collect();
        assert_eq!(names, [("Cem", 3), ("Dora", 2), ("Ada", 1), ("Ben", 1)], "a rule counts once");
        assert_eq!(ranked[1].concerns[0].exercise(), Some("e5"), "the longer row of failures first");
    }

    #[test]
    fn a_setting_of_the_school_replaces_the_usual_one() {
        let set = RuleSetting { rule: RiskRule::Failing, applies: false, number: 5, weight: 9 };
        let rules = RiskRules::of(&[set]);
        assert_eq!(rules.settings()[1], set);
        assert_eq!(rules.number(RiskRule::Failing), None);
        assert_eq!(rules.number(RiskRule::Inactive), Some(2));
    }
}
