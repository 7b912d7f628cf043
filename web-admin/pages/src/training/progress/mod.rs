//! Progress of a trainee on one exercise, of a cohort, and of a school.

mod cohort;
mod learning;
mod metrics;
#[cfg(test)]
mod samples;
mod school;

pub use cohort::{CohortProgressPage, CourseHeat, Hardness, HeatCell, HeatRow, Worry, make_heat_cell};
pub use learning::{Comparison, CurveFacts, CurveFinding, CurveRow, HabitRow, HabitsView, LearningPage};
pub use metrics::{MetricSpreadRow, MetricsPage, ScoredRow, SpreadTheme};
pub use school::{MonthRow, SchoolProgressPage, YearRow};
