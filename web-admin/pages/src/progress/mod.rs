//! Progress: one exercise of one trainee, a cohort, a school.

mod cohort;
mod learning;
mod metrics;
#[cfg(test)]
mod samples;
mod school;

pub use cohort::{CohortProgressPage, CourseHeat, Hardness, HeatCell, HeatRow, Worry, heat_cell};
pub use learning::{Comparison, CurveFacts, CurveRow, HabitRow, HabitsView, LearningPage, Said};
pub use metrics::{MetricRow, MetricsPage, ScoredRow};
pub use school::{MonthRow, SchoolProgressPage, YearRow};
