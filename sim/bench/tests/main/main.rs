//! What the bench measures keeps its bounds.

#[cfg(test)]
mod hard_cases;
