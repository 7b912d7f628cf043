//! Every hard case keeps its bound.

#[cfg(test)]
mod hard_cases;
