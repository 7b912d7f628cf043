//! What the service is told: JSON text, written into a buffer that is used again.

use std::fmt::Write;

use nalgebra::Vector3;

use super::axes;

/// How the service wants a force to be spelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// The field is `vector`: version 3.5 and later.
    Vector,
    /// The field is `values`: before 3.5.
    Values,
    /// Both fields, for a service that does not say its version: it takes the one that it knows and ignores the other.
    Both,
}

impl Dialect {
    fn fields(self) -> &'static [&'static str] {
        match self {
            Self::Vector => &["vector"],
            Self::Values => &["values"],
            Self::Both => &["vector", "values"],
        }
    }
}

/// Asks for a frame with everything in it.
pub const FULL_STATE: &str = r#"{"session":{"force_render_full_state":{}}}"#;
/// Keeps the connection alive and says nothing.
pub const KEEP_ALIVE: &str = "{}";

/// The command that sets a force, for one device in one dialect.
pub struct SetForce {
    prefix: String,
    fields: &'static [&'static str],
    text: String,
}

impl SetForce {
    pub fn new(device_id: &str, dialect: Dialect) -> Self {
        let device_id = serde_json::Value::from(device_id);
        let prefix = format!(r#"{{"inverse3":[{{"device_id":{device_id},"commands":{{"set_cursor_force":{{"#);
        Self { prefix, fields: dialect.fields(), text: String::new() }
    }

    /// The command as text. The force, in N, device frame, is finite.
    pub fn text(&mut self, force_n: &Vector3<f64>) -> &str {
        let force_n = axes::force_n(force_n);
        self.text.clear();
        self.text.push_str(&self.prefix);
        let mut comma = "";
        for field in self.fields {
            // Debug prints the shortest digits that read back to the same number. A string takes whatever is written.
            let (x, y, z) = (force_n.x, force_n.y, force_n.z);
            let _infallible = write!(self.text, r#"{comma}"{field}":{{"x":{x:?},"y":{y:?},"z":{z:?}}}"#);
            comma = ",";
        }
        self.text.push_str("}}}]}");
        &self.text
    }
}
