//! Messages to the service: JSON text, written into a reused buffer.

use std::fmt::Write;

use nalgebra::Vector3;

use super::axes;

/// The JSON field that the service expects for a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// The field is `vector`: version 3.5 and later.
    Vector,
    /// The field is `values`: before 3.5.
    Values,
    /// Both fields, for a service that does not report its version: it uses the one that it knows
    /// and ignores the other.
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

/// Requests a full state.
pub const FULL_STATE: &str = r#"{"session":{"force_render_full_state":{}}}"#;
/// An empty message that keeps the connection alive.
pub const KEEP_ALIVE: &str = "{}";

/// The command that sets a force, for one device and dialect.
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

    /// Returns the command as text. The force, in N, device frame, must be finite.
    pub fn text(&mut self, force_n: &Vector3<f64>) -> &str {
        let force_n = axes::force_n(force_n);
        self.text.clear();
        self.text.push_str(&self.prefix);
        let mut comma = "";
        for field in self.fields {
            // `Debug` prints the shortest digits that parse to the same number. Writing to a string
            // cannot fail.
            let (x, y, z) = (force_n.x, force_n.y, force_n.z);
            let _infallible = write!(self.text, r#"{comma}"{field}":{{"x":{x:?},"y":{y:?},"z":{z:?}}}"#);
            comma = ",";
        }
        self.text.push_str("}}}]}");
        &self.text
    }
}
