//! Plans of the tissues that drafts name. A tissue decides its plan, and a field takes its time to compute, so whoever looks at a draft
//! again is told the plan that is known.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use mechanics::tissue::follow::{Field, FieldPlan, FollowError, TissueSpec};

/// Most plans that are kept.
const MOST: usize = 64;

/// Plans by the tissue in words, which hold every number to the last bit.
#[derive(Debug, Default)]
pub struct Plans(Mutex<BTreeMap<String, FieldPlan>>);

impl Plans {
    /// The plan of a tissue. Blocks where it is not known.
    ///
    /// # Errors
    /// When the tissue makes no sense or no model can be had.
    pub fn of(&self, tissue: &TissueSpec) -> Result<FieldPlan, FollowError> {
        let key = format!("{tissue:?}");
        if let Some(known) = self.known().get(&key) {
            return Ok(known.clone());
        }
        let plan = Field::new(tissue)?.plan().clone();
        let mut known = self.known();
        if known.len() >= MOST {
            known.clear();
        }
        known.insert(key, plan.clone());
        Ok(plan)
    }

    /// Whoever panicked has left nothing half-written here.
    fn known(&self) -> MutexGuard<'_, BTreeMap<String, FieldPlan>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
